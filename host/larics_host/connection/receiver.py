"""Bytes from the wire -> messages with named fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from larics.wire import codec as protocol
from larics.wire import messages
from larics_host import wire_names as codes
from larics_host.connection.decoder import Decoder
from larics_host.connection.records import record_of

if TYPE_CHECKING:
    from larics.wire.codec import Encoder


_NUMBERS = {name: number for name, number, _, _ in protocol.MESSAGES}


class Message:
    """One received message: `name` ("MARKER"), `sequence`, `fields` (a record of its type, see records) and
    `time_s`, when it was taken from the line."""

    __slots__ = ("name", "sequence", "fields", "time_s")

    def __init__(self, name: str, sequence: int, fields: Any, time_s: float) -> None:
        self.name = name
        self.sequence = sequence
        self.fields = fields
        self.time_s = time_s


def values_of(number: int, fields: dict[str, Any]) -> list[Any]:
    """The values of a message, in field order: the inverse of what `records.as_json` makes of them.

    Raises KeyError for an unknown number or a missing field, ValueError or TypeError for a wrong value."""
    values = []
    for field, code, *_ in protocol.fields(number):
        value = fields[field]
        if value is None:
            flagged = number == messages.MARKER and field in codes.UNKNOWN_BY_FLAG[messages.MARKER_NONE]
            value = 0 if flagged else codes.UNKNOWN[field]
        if code.endswith("s"):
            data = value.encode("latin-1") if field in codes.TEXT_FIELDS else bytes.fromhex(value)
            value = data.ljust(int(code[:-1]), b"\0")
        elif type(value) is not int:
            raise TypeError("%s = %r is no whole number" % (field, value))
        values.append(value)
    return values


def wire_bytes(encoder: Encoder, name: str, sequence: int, fields: dict[str, Any]) -> bytes:
    """The bytes that carried a message: the inverse of what `Receiver` and `records.as_json` make of them.

    Raises KeyError for an unknown name or a missing field, ValueError or TypeError for a wrong value."""
    number = _NUMBERS[name]
    values = values_of(number, fields)
    encoder.sequence = sequence
    return bytes(encoder.buffer[: encoder.encode(number, values)])


def message_of(number: int, sequence: int, values: Sequence[Any], time_s: float) -> Message:
    """The Message of what a Decoder hands out; copies what the decoder will reuse."""
    return Message(protocol.name(number), sequence, record_of(number, values), time_s)


class Receiver:
    """Feeds a Decoder and hands out what it found; `counters` are the decoder's, `message_bytes` counts those
    of all messages."""

    def __init__(self) -> None:
        self._decoder = Decoder(self._on_message)
        self._found: list[Message] = []
        self._time_s = 0.0
        self.message_bytes = 0

    @property
    def counters(self) -> Any:
        return self._decoder.counters

    def _on_message(self, number, sequence, values):
        self.message_bytes += protocol.frame_size(number)
        self._found.append(message_of(number, sequence, values, self._time_s))

    def feed(self, data: bytes, time_s: float) -> list[Message]:
        """The messages that `data` completes, in order."""
        self._time_s = time_s
        self._decoder.feed(data, len(data))
        found, self._found = self._found, []
        return found
