"""Whether an ID is confirmed by enough of the last frames."""

from array import array

from larics.marker.detection import FLAG_UNCONFIRMED

_NONE = 65535


class Confirmation:
    """Flags the IDs that were seen in fewer than `least` of the last `frames` frames.

    markers: that a frame may have. ValueError unless 1 <= least <= frames <= 255."""

    def __init__(self, least, frames, markers):
        if not 1 <= least <= frames <= 255:
            raise ValueError("confirm is (n, m) with 1 <= n <= m <= 255, not (%s, %s)" % (least, frames))
        self._least = least
        self._markers = markers
        self._history = array("H", [_NONE] * (frames * markers))  # the IDs that each frame had
        self._next = 0

    def update(self, found, count):
        """Takes the first `count` detections of a frame and flags those not yet confirmed."""
        history = self._history
        for index in range(self._markers):
            is_certain = index < count and found[index].marker_id >= 0
            history[self._next + index] = found[index].marker_id if is_certain else _NONE
        self._next = (self._next + self._markers) % len(history)
        for index in range(count):
            one = found[index]
            if one.marker_id >= 0 and self._frames_with(one.marker_id) < self._least:
                one.flags |= FLAG_UNCONFIRMED

    def _frames_with(self, marker_id):
        history = self._history
        frames = index = 0
        while index < len(history):
            if history[index] == marker_id:
                frames += 1
                index += self._markers - index % self._markers  # a frame counts once
            else:
                index += 1
        return frames
