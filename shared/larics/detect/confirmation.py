"""Whether an ID is confirmed by enough of the last frames."""

from larics.marker.detection import FLAG_UNCONFIRMED


class Confirmation:
    """Flags the IDs that were seen in fewer than `least` of the last `frames` frames.

    ValueError unless 1 <= least <= frames <= 255."""

    def __init__(self, least, frames):
        if not 1 <= least <= frames <= 255:
            raise ValueError("confirm is (n, m) with 1 <= n <= m <= 255, not (%s, %s)" % (least, frames))
        self._least = least
        self._history = bytearray(frames)  # of each frame, a bit for each ID seen
        self._next = 0

    def update(self, found, count):
        """Takes the first `count` detections of a frame and flags those not yet confirmed."""
        ids = 0
        for index in range(count):
            if found[index].marker_id >= 0:
                ids |= 1 << found[index].marker_id
        self._history[self._next] = ids
        self._next = (self._next + 1) % len(self._history)
        for index in range(count):
            one = found[index]
            if one.marker_id >= 0:
                agreeing = 0
                for ids in self._history:
                    agreeing += ids >> one.marker_id & 1
                if agreeing < self._least:
                    one.flags |= FLAG_UNCONFIRMED
