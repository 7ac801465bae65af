"""Topics: names, types, and the qualities of service that ROS 2 nodes expect of each."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, NamedTuple

from larics_host.errors import UserError

RELIABLE = "reliable"
VOLATILE, TRANSIENT_LOCAL = "volatile", "transient_local"

# what --tf chooses: the transforms that are told
BASE = "base"  # map -> base_link
ODOM = "odom"  # map -> odom
TREE = "tree"  # map -> odom and odom -> base_link
NONE = "none"
MODES = (BASE, ODOM, TREE, NONE)

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_FRAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./-]*")


class Qos(NamedTuple):
    """Keep the last `depth`, reliable; durability: whether who comes later gets what was sent last."""

    depth: int = 10
    durability: str = VOLATILE

    def rosbag2(self) -> str:
        """As rosbag2 (version 8) writes it: a list in YAML, numbers of rmw's enumerations."""
        numbers = (1, self.depth, 1, 1 if self.durability == TRANSIENT_LOCAL else 2)
        times = "{0}:\n    sec: 9223372036\n    nsec: 854775807\n".format
        return (
            "- history: %d\n  depth: %d\n  reliability: %d\n  durability: %d\n" % numbers
            + "  " + times("deadline")
            + "  " + times("lifespan")
            + "  liveliness: 1\n  " + times("liveliness_lease_duration")
            + "  avoid_ros_namespace_conventions: false"
        )  # fmt: skip


LATCHED = Qos(1, TRANSIENT_LOCAL)


class Output(NamedTuple):
    """One message for a topic: its full name, the type "package/Name", the value (see cdr), the time of what
    it tells."""

    topic: str
    type: str
    value: dict[str, Any]
    stamp_ns: int


@dataclass(frozen=True)
class Names:
    """Names of topics and frames. Frames are those of REP 105; the camera's is optical (REP 103): z along the
    optical axis, x to the right of the picture, y down. Raises UserError for what ROS 2 does not allow."""

    namespace: str = "larics"
    map: str = "map"
    odom: str = "odom"
    base: str = "base_link"
    camera: str = "camera_optical_frame"

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.namespace.strip("/")):
            raise UserError(
                "namespace %r: letters, digits and _, parts separated by /, no part begins with a digit"
                % self.namespace
            )
        frames = (self.map, self.odom, self.base, self.camera)
        for frame in frames:
            if not _FRAME.fullmatch(frame):
                raise UserError("frame %r: no name that tf2 takes (and none begins with /)" % frame)
        if len(set(frames)) < len(frames):
            raise UserError("the frames %s must differ: each is one place in the tree" % ", ".join(frames))

    def topic(self, name: str) -> str:
        """The full name of a topic in the namespace."""
        return "/%s/%s" % (self.namespace.strip("/"), name)


def qos_of(topic: str) -> Qos:
    """By the last part of a topic's name: the map and fixed transforms are for who comes later, too."""
    last = topic.rsplit("/", 1)[-1]
    if last in ("map", "tf_static"):
        return LATCHED
    return Qos(100) if last == "tf" else Qos()


def time_of(ns: int) -> dict[str, int]:
    """A builtin_interfaces/Time."""
    return {"sec": ns // 1_000_000_000, "nanosec": ns % 1_000_000_000}


def header(ns: int, frame: str) -> dict[str, Any]:
    """A std_msgs/Header."""
    return {"stamp": time_of(ns), "frame_id": frame}
