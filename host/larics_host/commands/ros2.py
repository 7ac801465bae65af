"""`larics ros2`: a camera's messages as live topics of ROS 2, by DDS, without ROS."""

from __future__ import annotations

import argparse
import os
import time
from typing import Any

from larics_host.errors import UserError, report
from larics_host.ros import options as ros_options
from larics_host.ros.topics import BASE, NONE, ODOM, TREE
from larics_host.wording import counted

NAME = "ros2"
HELP = "publish what a camera sends as topics of ROS 2, by DDS; on this computer alone unless told otherwise"
EXAMPLE = """
larics ros2 --port /dev/ttyACM0                     # pose, transforms, diagnostics, map, sightings
larics ros2 --port tcp://127.0.0.1:7007 --pictures 30 --reconnect
larics ros2 --port /dev/ttyACM0 --tf none --network # robot_localization tells the transforms
larics ros2 --input run.jsonl --speed 2             # a log, as if it happened now
"""

_SILENT_S = 3.0
_DOMAIN_MOST = 232  # the ports of more are none
_UNPUBLISHED = "/wire/raw_chunk"  # pixels: the picture has them
_WHO = {
    BASE: "{map} -> {base} comes from here: nobody else may tell it, or {odom} -> {base}",
    ODOM: "{map} -> {odom} comes from here, {odom} -> {base} from the vehicle's own node",
    TREE: "{map} -> {odom} and {odom} -> {base} come from here: nobody else may tell them",
    NONE: "no transform comes from here: {map} -> {odom} -> {base} are another's to tell",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--port", metavar="DEVICE", help="serial port, as /dev/ttyACM0, or tcp://HOST:PORT")
    source.add_argument("--input", metavar="LOG", help="a log of larics log, published with the time of now")
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")
    parser.add_argument("--speed", metavar="X", type=float, default=1.0, help="of a log (1)")
    parser.add_argument("--seconds", metavar="N", type=float, help="stop after N seconds")
    parser.add_argument("--reconnect", action="store_true", help="wait for a port that has gone to return")
    parser.add_argument("--listen", action="store_true", help="ask the camera nothing, not even for its map")
    parser.add_argument("--domain", metavar="N", type=int, help="of DDS (the variable ROS_DOMAIN_ID, else 0)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--interface", metavar="NAME", help="use this network interface, as eth0 (loopback)")
    where.add_argument(
        "--network",
        action="store_true",
        help="use what CYCLONEDDS_URI says, else the interface of Cyclone's choice",
    )
    ros_options.add_arguments(parser.add_argument_group("topics"), ODOM)


def run(args: argparse.Namespace) -> int:
    from larics_host.connection.byte_sources import ConnectionLost, stop_on_signals
    from larics_host.ros.dds import Publisher

    domain = _check(args)
    options = ros_options.options_of(args, ODOM, background=bool(args.port))
    source = _source(args)
    try:
        publisher = Publisher(domain, args.interface, args.network)
        try:
            work = _Bridge(args, source, publisher, options)
            print(_title(args, domain), flush=True)
            with stop_on_signals(source.live) as stopped:
                work.run(stopped)
        except KeyboardInterrupt:
            pass
        except ConnectionLost as error:
            raise UserError("%s; %s" % (error, work.summary())) from None
        finally:
            publisher.close()
    finally:
        source.close()
    return work.conclude()


def _check(args):
    """The domain. UserError for options that cannot be."""
    for name, value in (("speed", args.speed), ("baud", args.baud), ("seconds", args.seconds)):
        if value is not None and not value > 0:
            raise UserError("--%s %g: give a number above 0" % (name, value))
    if args.pictures is not None and (args.input or args.listen):
        raise UserError("--pictures asks a camera: it needs --port, and no --listen")
    where, domain = "--domain", args.domain
    if domain is None:
        where, text = "ROS_DOMAIN_ID", os.environ.get("ROS_DOMAIN_ID") or "0"
        if not text.strip().isdigit():
            raise UserError("the variable ROS_DOMAIN_ID is %r: it is a number, or --domain gives it" % text)
        domain = int(text)
    if not 0 <= domain <= _DOMAIN_MOST:
        raise UserError("%s %d: a domain is 0 to %d" % (where, domain, _DOMAIN_MOST))
    return domain


def _source(args) -> Any:
    from larics_host.connection.byte_sources import ReconnectingSource
    from larics_host.connection.lines import open_line
    from larics_host.logs.log_reader import read_pieces
    from larics_host.logs.log_source import LogSource

    if args.input:
        next(read_pieces(args.input))  # what cannot be read is told before anything is published
        return LogSource(args.input, args.speed)
    source = open_line(args.port, args.baud)
    return ReconnectingSource(source) if args.reconnect else source


def _title(args, domain):
    where = "the loopback interface alone"
    if args.network or args.interface:
        where = "interface %s" % args.interface if args.interface else "the network"
    namespace = args.namespace.strip("/")
    return "publishing /%s/... in domain %d on %s  (Ctrl-C ends)" % (namespace, domain, where)


class _Bridge:
    """From the source to the topics."""

    def __init__(self, args, source, publisher, options):
        from larics_host.connection.line_watch import LineWatch
        from larics_host.connection.receiver import Receiver
        from larics_host.ros.view import View

        self._args = args
        self._source = source
        self._publisher = publisher
        self._view = View(options)
        self._receiver = Receiver()
        self._watch = LineWatch()
        self._asker = None if args.input or args.listen else self._make_asker()
        self._told_mode = False
        self._start_s = self._status_s = self._due_s = time.monotonic()
        self._count = 0

    def _make_asker(self):
        from larics_host.connection.asker import Asker

        def on_silence():
            report(
                "the camera does not answer: --map and --settings tell what it would; is its RX connected?"
            )

        wanted = ros_options.asked_settings(self._args.pictures is not None)
        return Asker(self._source.write, wanted, self._args.pictures, on_silence)

    def run(self, stopped):
        self._publisher.announce(self._topics())
        while not stopped():
            data = self._source.read()
            now_s = time.monotonic()
            if data is None or (
                self._args.seconds is not None and now_s - self._start_s > self._args.seconds
            ):
                break
            if self._asker is not None:
                self._asker.step(now_s)
            self._watch.feed(data)
            for message in self._receiver.feed(data, now_s - self._start_s):
                self._take(message, now_s)
            self._watch_silence(now_s)
        self._publish(self._view.finish())

    def _topics(self):
        names = self._view.names
        arrays = "visualization_msgs/MarkerArray"
        topics = {
            names.topic("pose"): "geometry_msgs/PoseWithCovarianceStamped",
            names.topic("map"): arrays,
            names.topic("sightings"): arrays,
            "/diagnostics": "diagnostic_msgs/DiagnosticArray",
        }
        if self._args.tf != NONE:
            topics.update(dict.fromkeys(("/tf", "/tf_static"), "tf2_msgs/TFMessage"))
        if self._args.pictures is not None:
            topics[names.topic("image/compressed")] = "sensor_msgs/CompressedImage"
            topics[names.topic("annotations")] = "foxglove_msgs/ImageAnnotations"
        return topics

    def _take(self, message, now_s):
        if self._asker is not None:
            self._asker.note(message)
        if message.name == "STATUS":
            self._status_s = now_s
        self._publish(self._view.messages(message, time.time_ns()))
        mode = self._view.tree.mode
        if mode is not None and not self._told_mode:
            self._told_mode = True
            names = self._view.names
            print(_WHO[mode].format(map=names.map, odom=names.odom, base=names.base), flush=True)

    def _publish(self, outputs):
        for output in outputs:
            if not output.topic.endswith(_UNPUBLISHED):
                self._publisher.write(output)
                self._count += 1

    def _watch_silence(self, now_s):
        """A camera that tells nothing is told once a second."""
        silent_s = now_s - self._status_s
        if self._source.live and silent_s >= _SILENT_S and now_s >= self._due_s:
            self._publish([self._view.silent(silent_s, time.time_ns())])
            self._due_s = now_s + 1.0

    def summary(self):
        """What was done, for a person."""
        received = counted(self._receiver.counters.messages, "message")
        return "%s received, %s published" % (received, counted(self._count, "message"))

    def conclude(self):
        if not self._receiver.counters.messages:
            counters = self._receiver.counters
            what = self._watch.explain(counters, getattr(self._source, "baud", None))
            raise UserError("no message came from %s, %s" % (self._source.name, what))
        print(self.summary())
        return 0
