"""Messages as MCAP, the recording format that Foxglove opens: JSON with a JSON schema for each type."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from larics.wire import codec as protocol
from larics.wire import messages
from larics_host import wire_names as codes
from larics_host.connection.records import as_json
from larics_host.errors import UserError
from larics_host.files import CannotWrite, GrowingFile

if TYPE_CHECKING:
    from larics_host.annotations import StrPath
    from larics_host.connection.receiver import Message


_NS = 1_000_000_000


def schema(number: int) -> dict[str, Any]:
    """The JSON schema of a message type, with range, unit and meaning of each field."""
    properties: dict[str, dict[str, Any]] = {
        "time_s": {"type": "number", "description": "when it was received, seconds since the log began"}
    }
    for name, code, unit, low, high, meaning in protocol.fields(number):
        if code.endswith("s"):
            properties[name] = {"type": "string", "description": meaning}
            continue
        text = "%s [%s]" % (meaning, unit) if unit else meaning
        may_be_unknown = name in codes.UNKNOWN or name in codes.UNKNOWN_BY_FLAG[messages.MARKER_NONE]
        kind = ["integer", "null"] if may_be_unknown else "integer"
        properties[name] = {"type": kind, "minimum": low, "maximum": high, "description": text}
    return {"title": "larics." + protocol.name(number), "type": "object", "properties": properties}


def writer_class() -> Any:
    """mcap's Writer; UserError when the package is not installed."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise UserError("--mcap needs the Python package mcap: pip install mcap") from None
    return Writer


class McapLog:
    """An MCAP file of messages, each on the channel /larics/<type in lower case>.

    It is written without chunks and flushed after each message, so that ending the program by force
    loses nothing. start_ns: wall clock of the messages' time_s 0.
    """

    def __init__(self, path: StrPath, start_ns: int) -> None:
        from larics import __version__

        writer = writer_class()
        self._file = GrowingFile(path)
        self._start_ns = start_ns
        self._channels: dict[str, int] = {}
        self._numbers = {name: number for name, number, _, _ in protocol.MESSAGES}
        self._writer = writer(self._file, use_chunking=False)
        self._writer.start(profile="", library="larics " + __version__)
        try:
            self._file.flush()
        except CannotWrite:
            self._file.discard()
            raise

    def write(self, message: Message) -> None:
        """Adds a receiver.Message; its publish time is that of the frame where it has an age."""
        channel = self._channels.get(message.name) or self._channel(message.name)
        received_ns = self._start_ns + round(message.time_s * _NS)
        data = json.dumps({"time_s": round(message.time_s, 6), **as_json(message.fields)}).encode()
        measured_ns = received_ns - 1000 * getattr(message.fields, "age_us", 0)
        self._writer.add_message(channel, received_ns, data, max(0, measured_ns), message.sequence)
        self._file.flush()

    def _channel(self, name):
        text = json.dumps(schema(self._numbers[name])).encode()
        schema_id = self._writer.register_schema("larics." + name, "jsonschema", text)
        channel = self._writer.register_channel("/larics/" + name.lower(), "json", schema_id)
        self._channels[name] = channel
        return channel

    def close(self) -> None:
        if self._file.closed:
            return
        try:
            self._writer.finish()
            self._file.flush()
        finally:
            self._file.close()

    def discard(self) -> None:
        """Removes the file."""
        self._file.discard()
