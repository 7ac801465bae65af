"""Follows a single marker from frame to frame, and searches the whole frame often enough to miss no other."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.marker.detection import FLAG_BLUR_MODEL, FLAG_BORDER

_SEARCH_EVERY = const(8)  # frames; a second marker is found after so many at the latest


class Tracker:
    """A Detector whose `detect` looks around the predicted place first while that is safe.

    It is safe while exactly one marker is in view, with a certain ID, away from the border of the frame and
    read by the direct reader: with two, only one would be followed; at the border, the next marker is about
    to come; what the blur-model reader has read is not fitted at once. A frame in which nothing is found at
    the predicted place has no detections, and the next one is searched. `detector`:
    larics.detect.detector.Detector; `detect` returns and raises as there."""

    def __init__(self, detector):
        self._detector = detector
        self._followed = 0  # frames since the last search
        self._is_safe = False

    def detect(self, frame):
        if self._is_safe and self._followed < _SEARCH_EVERY - 1:
            self._followed += 1
            found = self._detector.track(frame)
        else:
            self._followed = 0
            found = self._detector.detect(frame)
        self._is_safe = (
            len(found) == 1
            and found[0].marker_id >= 0
            and not found[0].flags & (FLAG_BORDER | FLAG_BLUR_MODEL)
        )
        return found
