"""Bytes from the wire -> messages with named fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from larics.wire import codec as protocol
from larics.wire import messages

if TYPE_CHECKING:
    from larics.wire.codec import Encoder


_TEXT_FIELDS = ("board",)
_NAMES = {number: [field[0] for field in fields] for _, number, _, fields in protocol.MESSAGES}
_NUMBERS = {name: number for name, number, _, _ in protocol.MESSAGES}


class Message:
    """One received message: `name` ("MARKER"), `sequence`, `fields` (name: int, or text for byte fields) and
    `time_s`, when it was taken from the line."""

    __slots__ = ("name", "sequence", "fields", "time_s")

    def __init__(self, name: str, sequence: int, fields: dict[str, Any], time_s: float) -> None:
        self.name = name
        self.sequence = sequence
        self.fields = fields
        self.time_s = time_s


def readable(fields: dict[str, Any]) -> dict[str, Any]:
    """Fields as logs show them: an ID that is none or uncertain is None, which nobody takes for a marker."""
    return {**fields, "id": None} if fields.get("id") == messages.ID_NONE else fields


def wire_bytes(encoder: Encoder, name: str, sequence: int, fields: dict[str, Any]) -> bytes:
    """The bytes that carried a message: the inverse of what `Receiver` and `readable` make of them.

    Raises KeyError for an unknown name or a missing field, ValueError or TypeError for a wrong value."""
    number = _NUMBERS[name]
    values = []
    for field, code, *_ in protocol.fields(number):
        value = fields[field]
        if field == "id" and value is None:
            value = messages.ID_NONE
        if code.endswith("s"):
            data = value.encode("ascii") if field in _TEXT_FIELDS else bytes.fromhex(value)
            value = data.ljust(int(code[:-1]), b"\0")
        values.append(value)
    encoder.sequence = sequence
    return bytes(encoder.buffer[: encoder.encode(number, values)])


def message_of(number: int, sequence: int, values: Sequence[Any], time_s: float) -> Message:
    """The Message of what a Decoder hands out; copies what the decoder will reuse."""
    fields = {}
    for name, value in zip(_NAMES[number], values, strict=True):
        if isinstance(value, bytearray):
            data = bytes(value)
            value = data.rstrip(b"\0").decode("ascii", "replace") if name in _TEXT_FIELDS else data.hex()
        fields[name] = value
    return Message(protocol.name(number), sequence, fields, time_s)


class Receiver:
    """Feeds a Decoder and hands out what it found; `counters` are the decoder's."""

    def __init__(self) -> None:
        self._decoder = protocol.Decoder(self._on_message)
        self._found: list[Message] = []
        self._time_s = 0.0

    @property
    def counters(self) -> Any:
        return self._decoder.counters

    def _on_message(self, number, sequence, values):
        self._found.append(message_of(number, sequence, values, self._time_s))

    def feed(self, data: bytes, time_s: float) -> list[Message]:
        """The messages that `data` completes, in order."""
        self._time_s = time_s
        self._decoder.feed(data, len(data))
        found, self._found = self._found, []
        return found
