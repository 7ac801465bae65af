"""Whether markers are in view, for a sensor without a map. Of one with a map, the localizer tells."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.locate.localizer import SILENT_US
from larics.marker.detection import FLAG_UNCONFIRMED
from larics.wire.messages import COASTING, COUNT_MAX, LOST, TRACKING

_COASTING_MS = const(500)
_SILENT_MS = SILENT_US // 1000


class Sighting:
    """`update` with each processed frame. Times in ms, of any clock modulo 2**30; `state` must be asked more
    often than it wraps, every 12 days."""

    def __init__(self):
        self._state = LOST
        self._seen_ms = 0

    def update(self, measurements, count, now_ms):
        """Takes the first `count` Measurements of a frame; an ID that is uncertain or unconfirmed does not
        count."""
        for index in range(count):
            measurement = measurements[index]
            if measurement.marker_id >= 0 and not measurement.flags & FLAG_UNCONFIRMED:
                self._seen_ms = now_ms
                self._state = TRACKING
                return
        if self._state == TRACKING:
            self._state = COASTING

    def state(self, now_ms):
        """TRACKING, COASTING or LOST: with the time, not only with frames."""
        passed_ms = (now_ms - self._seen_ms) & COUNT_MAX
        if passed_ms >= (_COASTING_MS if self._state == COASTING else _SILENT_MS):
            self._state = LOST
        return self._state
