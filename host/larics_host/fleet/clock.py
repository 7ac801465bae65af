"""When the messages of recorded bytes came, where no log beside tells it: by the camera's own uptime."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from larics_host.connection.receiver import Message

# before the second STATUS; rather slow, as a gap that was none would part what belongs together
_RATE_HZ = 10.0
_STATUS_S = 1.0  # between two STATUS


class Clock:
    """Seconds since the first message, by the uptime of STATUS, and between two by the numbers of frames."""

    def __init__(self) -> None:
        self._time_s = self._base_s = self._origin_s = 0.0
        self._rate_hz = _RATE_HZ
        self._frame: int | None = None
        self._base_frame: int | None = None
        self._last: tuple[int, int] | None = None  # boot and uptime

    def of(self, message: Message) -> float:
        """When this message came, after all that were asked for before; never earlier than those."""
        fields = message.fields
        if message.name == "STATUS":
            self._take_status(fields)
        elif message.name == "MARKER":
            self._frame = fields.frame
            if self._base_frame is None:
                self._base_frame = fields.frame
            passed_s = (fields.frame - self._base_frame) / self._rate_hz
            self._time_s = max(self._time_s, self._base_s + min(passed_s, _STATUS_S))
        return self._time_s

    def _take_status(self, fields):
        last, self._last = self._last, (fields.boot, fields.uptime_s)
        if last is None or last[0] != fields.boot or fields.uptime_s < last[1]:  # it goes on from here
            self._origin_s = self._time_s - fields.uptime_s
        elif fields.uptime_s > last[1]:
            frames = (self._frame or 0) - (self._base_frame or 0)
            self._rate_hz = max(frames, 1) / (fields.uptime_s - last[1])
        self._time_s = self._base_s = max(self._time_s, self._origin_s + fields.uptime_s)
        self._base_frame = self._frame
