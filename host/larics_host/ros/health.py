"""STATUS and INFO as diagnostic_msgs/DiagnosticArray, as rqt_robot_monitor and Foxglove show it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import wire_names as codes
from larics_host.connection.records import as_json
from larics_host.logs.live_table import STATES, fault_text
from larics_host.ros.topics import header

if TYPE_CHECKING:
    from larics_host.connection.records import Info, Status

OK, WARN, ERROR, STALE = range(4)
_NAME = "larics: camera"


class Health:
    """Remembers what tells a new fault from an old one."""

    def __init__(self) -> None:
        self._info: Info | None = None
        self._faults: int | None = None

    def info(self, fields: Info) -> None:
        """Takes who the camera is."""
        self._info = fields

    def array(self, fields: Status, stamp_ns: int) -> dict[str, Any]:
        """A DiagnosticArray: ERROR while a fault lasts, WARN while LOST and for a fault since the last
        STATUS."""
        new = self._faults is not None and fields.faults != self._faults
        self._faults = fields.faults
        state = STATES[fields.state]
        active = fault_text(fields.active_faults, 0)
        if fields.active_faults:
            level, message = ERROR, "%s; %s" % (active, state)
        elif new:
            level, message = WARN, "fault: %s; %s" % (codes.name_of("Fault", fields.last_fault), state)
        else:
            level, message = WARN if fields.state == m.LOST else OK, state
        units = {name: unit for name, _, unit, *_ in protocol.fields(m.STATUS)}
        values = [("state", state), ("faults that last", active)]
        for name, told in as_json(fields).items():
            if name not in ("state", "active_faults"):
                text = "unknown" if told is None else "%d %s" % (told, units[name])
                values.append((name, text.strip()))
        return self._array(level, message, values, stamp_ns)

    def silent(self, seconds: float, stamp_ns: int) -> dict[str, Any]:
        """A DiagnosticArray for a camera of which nothing came."""
        return self._array(STALE, "no STATUS for %.0f s" % seconds, [], stamp_ns)

    def _array(self, level, message, values, stamp_ns):
        info = self._info
        if info is not None:
            values = [
                *values,
                ("board", info.board),
                ("frame size", "%d x %d px" % (info.width, info.height)),
            ]
        status = {
            "level": level,
            "name": _NAME,
            "message": message,
            "hardware_id": info.unique_id.hex() if info is not None else "",
            "values": [{"key": key, "value": value} for key, value in values],
        }
        return {"header": header(stamp_ns, ""), "status": [status]}
