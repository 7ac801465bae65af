"""The camera's own messages as ROS messages of a package `larics_msgs`, made from the table of the wire.

Fields keep their names and units. What may be unknown is a float64 that is NaN then; a name or a place in a
list (`id`, `route_position`), which is no measure, is an int32 that is -1 then.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import wire_names as codes
from larics_host.connection.records import as_json
from larics_host.ros.definitions import STRUCTS, Field, Struct, parsed

if TYPE_CHECKING:
    from larics_host.connection.receiver import Message

PACKAGE = "larics_msgs"
_NONE = -1
_NAMES = ("id", "route_position")
_INTEGERS = {"B": "uint8", "b": "int8", "H": "uint16", "h": "int16", "I": "uint32", "i": "int32"}
_MAY_BE_UNKNOWN = {*codes.UNKNOWN, *codes.UNKNOWN_BY_FLAG[m.MARKER_NONE]}
_BEFORE = """\
 builtin_interfaces/Time stamp  # middle of the exposure, for what is about a frame; else when it was received
 float64 time_s  # when it was received, seconds since the log or the connection began
 uint16 sequence  # number of the message
"""


def type_of(name: str) -> str:
    """ "larics_msgs/RawHeader" of "RAW_HEADER"."""
    return "%s/%s" % (PACKAGE, name.title().replace("_", ""))


@functools.cache
def wire_structs() -> dict[str, Struct]:
    """All types: the common ones and those of the wire."""
    text = ""
    for name, _, _, fields in protocol.MESSAGES:
        text += type_of(name) + "\n" + _BEFORE
        text += "".join(" %s\n" % _field(*field).line() for field in fields)
    return {**STRUCTS, **parsed(text)}


def _field(name, code, unit, _low, _high, meaning):
    comment = "%s: %s" % (unit, meaning) if unit else meaning
    if name in codes.TEXT_FIELDS:
        return Field(name, "string", None, comment)
    if code.endswith("s"):
        return Field(name, "uint8", 0, comment)
    if name in _NAMES:
        return Field(
            name, "int32", None, comment.partition(",")[0].partition(";")[0] + "; -1: none, or not certain"
        )
    if name in _MAY_BE_UNKNOWN:
        return Field(name, "float64", None, comment.partition(";")[0] + "; NaN: unknown")
    return Field(name, _INTEGERS[code], None, comment)


def to_ros(message: Message, stamp: dict[str, int]) -> dict[str, Any]:
    """The value of type `type_of(message.name)`; stamp: a builtin_interfaces/Time."""
    value: dict[str, Any] = {
        "stamp": stamp,
        "time_s": round(message.time_s, 6),
        "sequence": message.sequence,
    }
    for name, told in as_json(message.fields).items():
        if told is None:
            told = _NONE if name in _NAMES else math.nan
        elif isinstance(getattr(message.fields, name), bytes):
            told = bytes.fromhex(told)
        value[name] = told
    return value


def from_ros(name: str, value: dict[str, Any]) -> dict[str, Any]:
    """What `read_objects` of log_records gives of a message, of a decoded one of the type `type_of(name)`; a
    field that it does not have is left out. KeyError or ValueError when it is none."""
    number = next(number for known, number, _, _ in protocol.MESSAGES if known == name)
    record = {"message": name, "time_s": value["time_s"], "sequence": value["sequence"]}
    for field, code, *_ in protocol.fields(number):
        if field not in value:
            continue
        told = value[field]
        if field in _NAMES:
            told = None if told == _NONE else told
        elif field in _MAY_BE_UNKNOWN:
            told = None if math.isnan(told) else int(told)
        elif code.endswith("s") and field not in codes.TEXT_FIELDS:
            told = told.hex()
        record[field] = told
    return record


def name_of(kind: str) -> str | None:
    """ "RAW_HEADER" of "larics_msgs/msg/RawHeader"; None for another type."""
    wanted = kind.replace("/msg/", "/")
    return next((name for name, *_ in protocol.MESSAGES if type_of(name) == wanted), None)
