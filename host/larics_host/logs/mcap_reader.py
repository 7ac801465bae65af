"""The objects that messages of an .mcap are shown as, be it of this version of `larics log` or earlier."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from larics_host import files
from larics_host.errors import UserError, missing_package, report
from larics_host.logs.log_lines import NOT_OURS
from larics_host.packed import opened, place
from larics_host.ros.cdr import decode
from larics_host.ros.definitions import parse_definition
from larics_host.ros.wire_types import from_ros, name_of, type_of
from larics_host.wording import counted


def stamped_objects(
    path: Path, progress: Callable[[int], object] = files.unwatched
) -> Iterator[tuple[dict[str, Any], int]]:
    """Yields (object, wall clock of its reception in ns since 1970) of the messages in an .mcap; of one that
    is damaged, those before the damage, which is told. UserError where it is none. progress: see files.lines.
    """
    try:
        from mcap.exceptions import EndOfFile, McapError
        from mcap.reader import NonSeekingReader
        from zstandard import ZstdError
    except ImportError:
        raise missing_package("an .mcap", "mcap") from None
    damage = (McapError, ZstdError, ValueError, LookupError, AttributeError, TypeError, struct.error)
    count = 0
    try:
        with opened(path) as file:
            objects, reader = _Objects(), NonSeekingReader(file, validate_crcs=True)
            for schema, channel, message in reader.iter_messages(log_time_order=False):
                record = objects.of(schema, channel, message)
                if record is not None:
                    yield record, message.log_time
                    count += 1
                    progress(place(file))
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except EndOfFile:
        if count:
            report("%s was cut off: it has no end; %s read" % (path, counted(count, "message")))
    except (*damage, MemoryError):
        if not count:
            raise UserError("%s %s" % (path, NOT_OURS)) from None
        report("%s is damaged: read up to message %d, where it ceases to be a log" % (path, count))


class _Objects:
    """Of messages of `larics_msgs` in CDR, or in JSON as earlier versions wrote them."""

    def __init__(self):
        self._types = {}  # ID of a schema: (name of the message, type, what it is made of); None for others

    def of(self, schema, channel, message):
        """The object of a message; None for other topics, which tell the same in other words."""
        if channel.message_encoding == "json":
            fields = files.parse_json(message.data.decode())
            return {**fields, "message": schema.name.split(".")[-1], "sequence": message.sequence}
        if schema.id not in self._types:
            self._types[schema.id] = self._type(schema)
        known = self._types[schema.id]
        if known is None:
            return None
        name, kind, structs = known
        return from_ros(name, decode(kind, message.data, structs))

    @staticmethod
    def _type(schema):
        name = name_of(schema.name)
        if name is None:
            return None
        kind = type_of(name)
        return name, kind, parse_definition(kind, schema.data.decode())
