"""Bags of ROS 2: an MCAP file with the profile `ros2`, alone or in a folder with metadata.yaml as rosbag2 has
it.

Chunks are small and complete when they leave the program: ending it by force loses the last one. Such a file
has no index; what reads it from the front has all the rest.
"""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics import __version__
from larics_host.errors import missing_package
from larics_host.files import CannotWrite, GrowingFile, write_file
from larics_host.ros.cdr import encode
from larics_host.ros.definitions import definition_text, ros_name
from larics_host.ros.topics import qos_of
from larics_host.ros.type_hash import type_hash
from larics_host.ros.wire_types import wire_structs

if TYPE_CHECKING:
    from larics_host.annotations import StrPath
    from larics_host.ros.topics import Output

_CHUNK_BYTES = 65536  # one second at 60 frames/s
_VERSION = 8  # of metadata.yaml


def require_mcap() -> Any:
    """The module mcap.writer; UserError when the package is not installed."""
    try:
        from mcap import writer
    except ImportError:
        raise missing_package("a log as .mcap", "mcap") from None
    return writer


class _Channel:
    def __init__(self, number, output):
        self.number = number
        self.topic = output.topic
        self.type = output.type
        self.qos = qos_of(output.topic).rosbag2()
        self.hash = type_hash(output.type, wire_structs())
        self.count = 0


class Bag:
    """path: of the .mcap file, or with `folder` of a folder, in which there are <its name>_0.mcap and, once
    it is closed, metadata.yaml. CannotWrite when there is no room."""

    def __init__(self, path: StrPath, folder: bool = False) -> None:
        writer = require_mcap()
        self.path = path
        self._folder = Path(path) if folder else None
        self._channels: dict[str, _Channel] = {}
        self._structs = wire_structs()
        self._start_ns = self._end_ns = 0
        self._broken = False
        self._made = False
        name = Path(path).name
        if self._folder is not None:
            self._made = not self._folder.exists()
            try:
                self._folder.mkdir(exist_ok=True)
                (self._folder / "metadata.yaml").unlink(missing_ok=True)  # of a bag that was there before
            except OSError as error:
                raise CannotWrite("cannot write %s: %s" % (path, error.strerror)) from error
            name += "_0.mcap"
        self._name = name
        self._file = GrowingFile(self._folder / name if self._folder is not None else path)
        self._writer = writer.Writer(
            self._file, chunk_size=_CHUNK_BYTES, compression=writer.CompressionType.ZSTD
        )
        self._writer.start("ros2", "larics " + __version__)
        try:
            self._file.flush()
        except CannotWrite:
            self.discard()
            raise

    def write(self, output: Output, received_ns: int, sequence: int = 0) -> None:
        """Adds one message. received_ns: wall clock, ns since 1970, never before the one before."""
        channel = self._channels.get(output.topic) or self._register(output)
        if not any(one.count for one in self._channels.values()):
            self._start_ns = received_ns
        self._end_ns = received_ns
        channel.count += 1
        data = encode(output.type, output.value, self._structs)
        self._writer.add_message(channel.number, received_ns, data, output.stamp_ns, sequence)
        self._flush()

    def _register(self, output):
        text = definition_text(output.type, self._structs).encode()
        schema = self._writer.register_schema(ros_name(output.type), "ros2msg", text)
        channel = _Channel(0, output)
        told = {"offered_qos_profiles": channel.qos, "topic_type_hash": channel.hash}
        channel.number = self._writer.register_channel(output.topic, "cdr", schema, told)
        self._channels[output.topic] = channel
        return channel

    def _flush(self):
        try:
            self._file.flush()
        except CannotWrite:
            self._broken = True  # an index would name what is not there
            raise

    def close(self) -> None:
        """Writes index and metadata. CannotWrite when there is no room for them; the messages stay."""
        if self._file.closed:
            return
        try:
            if not self._broken:
                self._writer.add_metadata("rosbag2", {"serialized_metadata": self._metadata()})
                self._writer.finish()
                self._flush()
                if self._folder is not None:
                    text = "rosbag2_bagfile_information:\n" + _indented(self._metadata())
                    write_file(self._folder / "metadata.yaml", text)
        finally:
            self._file.close()

    def discard(self) -> None:
        """Removes what it has made."""
        self._file.discard()
        if self._folder is not None and self._made:
            with contextlib.suppress(OSError):
                os.rmdir(self._folder)

    def _metadata(self):
        count = sum(channel.count for channel in self._channels.values())
        start_ns, duration_ns = self._start_ns, self._end_ns - self._start_ns
        lines = [
            "version: %d" % _VERSION,
            "storage_identifier: mcap",
            "relative_file_paths:",
            "  - %s" % json.dumps(self._name),
            "duration:",
            "  nanoseconds: %d" % duration_ns,
            "starting_time:",
            "  nanoseconds_since_epoch: %d" % start_ns,
            "message_count: %d" % count,
            "topics_with_message_count:" if self._channels else "topics_with_message_count: []",
        ]
        for channel in self._channels.values():
            lines += [
                "  - topic_metadata:",
                "      name: %s" % channel.topic,
                "      type: %s" % ros_name(channel.type),
                "      serialization_format: cdr",
                "      offered_qos_profiles: %s" % json.dumps(channel.qos),
                "      type_description_hash: %s" % channel.hash,
                "    message_count: %d" % channel.count,
            ]
        lines += [
            'compression_format: ""',
            'compression_mode: ""',
            "files:",
            "  - path: %s" % json.dumps(self._name),
            "    starting_time:",
            "      nanoseconds_since_epoch: %d" % start_ns,
            "    duration:",
            "      nanoseconds: %d" % duration_ns,
            "    message_count: %d" % count,
            "custom_data: ~",
            'ros_distro: ""',
        ]
        return "\n".join(lines) + "\n"


def _indented(text):
    return "".join("  %s\n" % line for line in text.splitlines())
