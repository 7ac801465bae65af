"""From the camera's messages to those of ROS topics."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from larics.wire import messages as m
from larics_host.connection.frame_times import FrameTimes
from larics_host.ros import frames, pictures
from larics_host.ros.drawing import Sightings, map_array
from larics_host.ros.health import Health
from larics_host.ros.known_settings import HALL, MOUNTING, KnownSettings
from larics_host.ros.options import Options
from larics_host.ros.topics import NONE, Output, header, time_of
from larics_host.ros.wire_types import to_ros, type_of

if TYPE_CHECKING:
    import numpy as np

    from larics_host.connection.receiver import Message


class View:
    """Give it every message of a camera in order; it gives the Outputs that follow from each.

    What belongs to one frame has one stamp: when the first message about it was received, minus its age.
    """

    def __init__(self, options: Options | None = None) -> None:
        self.options = options or Options()
        self.names = self.options.names
        self.tree = frames.Tree(self.names, self.options.tf, self.options.tf_with_odometry)
        self.health = Health()
        self._settings = KnownSettings(self.options.settings)
        self._ahead_ns = round(self.options.ahead_s * 1e9)
        self._times = FrameTimes()
        self._sightings = Sightings(self.names.base)
        self._seen: list[Any] = []
        self._assembler = pictures.Assembler()
        self._raw_stamp_ns = 0
        self._searches: list[tuple[int, Future[Any]]] = []
        self._executor = ThreadPoolExecutor(1) if self.options.background else None
        self._begun = False

    def messages(self, message: Message, received_ns: int) -> Iterator[Output]:
        """The Outputs of a receiver.Message; received_ns: wall clock, ns since 1970."""
        if not self._begun:
            self._begun = True
            yield from self._hall(received_ns)
            yield from self._camera(received_ns)
        yield from self._annotations(wait=False)
        stamp_ns = self._times.of(message.fields, received_ns)
        value = to_ros(message, time_of(stamp_ns))
        yield Output(self.names.topic("wire/" + message.name.lower()), type_of(message.name), value, stamp_ns)
        handler = getattr(self, "_of_" + message.name.lower(), None)
        if handler is not None:
            yield from handler(message.fields, stamp_ns)

    def picture(self, number: int, frame: np.ndarray, stamp_ns: int | None = None) -> Iterator[Output]:
        """The Outputs of a raw frame ((height, width) uint8) by its number; nothing when its time is not
        known."""
        stamp_ns = self._times.get(number) if stamp_ns is None else stamp_ns
        if stamp_ns is None:
            return
        value = pictures.compressed_image(frame, self.names.camera, stamp_ns)
        yield Output(self.names.topic("image/compressed"), "sensor_msgs/CompressedImage", value, stamp_ns)
        settings = dict(self._settings.values)
        if self._executor is not None:
            search = self._executor.submit(pictures.detections, frame, settings)
            self._searches.append((stamp_ns, search))
        else:
            yield from self._annotated(pictures.detections(frame, settings), stamp_ns)

    def finish(self) -> Iterator[Output]:
        """What is still under way."""
        yield from self._annotations(wait=True)
        if self._executor is not None:
            self._executor.shutdown()

    def silent(self, seconds: float, stamp_ns: int) -> Output:
        """Of a camera of which nothing came."""
        return self._diagnostics(self.health.silent(seconds, stamp_ns), stamp_ns)

    def _of_marker(self, fields, stamp_ns):
        if self._seen and self._seen[0].frame != fields.frame:  # the rest of that frame was lost
            self._seen = []
        if not fields.flags & m.MARKER_NONE:
            self._seen.append(fields)
        if fields.index + 1 >= fields.count:
            seen, self._seen = self._seen, []
            self._sightings.outer_m = (
                self._settings.values.get("outer_mm10", 10000 * self._sightings.outer_m) / 1e4
            )
            value = self._sightings.array(seen, stamp_ns)
            if value["markers"]:
                yield Output(self.names.topic("sightings"), "visualization_msgs/MarkerArray", value, stamp_ns)

    def _of_pose(self, fields, stamp_ns):
        if fields.state == m.LOST:
            return
        x, y, angle = frames.place_of(fields)
        pose = {"position": {"x": x, "y": y}, "orientation": frames.quaternion(angle)}
        value = {
            "header": header(stamp_ns, self.names.map),
            "pose": {"pose": pose, "covariance": frames.covariance(fields)},
        }
        yield Output(self.names.topic("pose"), "geometry_msgs/PoseWithCovarianceStamped", value, stamp_ns)
        yield from self.tree.pose(fields, stamp_ns, self._ahead_ns)

    def _of_motion(self, fields, stamp_ns):
        yield from self.tree.motion(fields, stamp_ns, self._ahead_ns)

    def _of_status(self, fields, stamp_ns):
        yield self._diagnostics(self.health.array(fields, stamp_ns), stamp_ns)

    def _of_info(self, fields, stamp_ns):
        self.health.info(fields)
        yield from ()

    def _of_setting(self, fields, stamp_ns):
        name = self._settings.add(fields)
        if name in HALL:
            yield from self._hall(stamp_ns)
        if name in MOUNTING:
            yield from self._camera(stamp_ns)

    def _of_raw_header(self, fields, stamp_ns):
        self._raw_stamp_ns = stamp_ns
        self._assembler.header(fields)
        yield from ()

    def _of_raw_chunk(self, fields, stamp_ns):
        whole = self._assembler.chunk(fields)
        if whole is not None:
            yield from self.picture(*whole, self._raw_stamp_ns)

    def _hall(self, stamp_ns):
        """The map, when it is known."""
        values = self._settings.values
        rows = self.options.map_rows if self.options.map_rows is not None else values.get("map")
        if rows is None:
            return
        route = self.options.route if self.options.route is not None else values.get("route", ())
        value = map_array(rows, route, values, self.names.map, stamp_ns)
        yield Output(self.names.topic("map"), "visualization_msgs/MarkerArray", value, stamp_ns)

    def _camera(self, stamp_ns):
        """Where the camera sits, when that is known."""
        if self.options.tf == NONE or not self._settings.has(*MOUNTING):
            return
        value = {"transforms": [frames.camera_transform(stamp_ns, self.names, self._settings.values)]}
        yield Output("/tf_static", "tf2_msgs/TFMessage", value, stamp_ns)

    def _annotations(self, wait):
        while self._searches and (wait or self._searches[0][1].done()):
            stamp_ns, search = self._searches.pop(0)
            yield from self._annotated(search.result(), stamp_ns)

    def _annotated(self, found, stamp_ns):
        if found is not None:
            value = pictures.drawn(found, stamp_ns)
            yield Output(self.names.topic("annotations"), "foxglove_msgs/ImageAnnotations", value, stamp_ns)

    def _diagnostics(self, value, stamp_ns):
        return Output("/diagnostics", "diagnostic_msgs/DiagnosticArray", value, stamp_ns)
