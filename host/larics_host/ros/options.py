"""Options of commands that speak ROS: names of topics and frames, transforms, map, what the camera is asked
for."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, field
from typing import Any

from larics_host.errors import UserError
from larics_host.ros.topics import BASE, MODES, TREE, Names

_DEFAULT = Names()


@dataclass
class Options:
    """tf: of topics.MODES, None for what suits the odometry (`tf_with_odometry` where there is any).

    map_rows, route: a map, None for the camera's own; settings: {name: value} of the camera, as far as known;
    ahead_s: by how much map -> odom is told for later than it was measured, as AMCL's transform_tolerance;
    background: pictures are searched in another thread, so that nothing waits for it.
    """

    names: Names = field(default_factory=Names)
    tf: str | None = None
    tf_with_odometry: str = TREE
    map_rows: list[list[int]] | None = None
    route: list[int] | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    ahead_s: float = 0.0
    background: bool = False


def add_arguments(parser: Any, with_odometry: str) -> None:
    """with_odometry: of topics.MODES, what is told when the camera has been sent odometry."""
    parser.add_argument("--map", metavar="FILE.json", help="map, or settings with a map, to be drawn")
    parser.add_argument(
        "--settings", metavar="FILE.json", help="the camera's settings: where it sits, what it sees, its map"
    )
    parser.add_argument(
        "--pictures",
        metavar="SECONDS",
        type=float,
        help="ask the camera for its settings, and for a raw frame so long after each",
    )
    parser.add_argument(
        "--namespace", metavar="NAME", default=_DEFAULT.namespace, help="of topics (%(default)s)"
    )
    frames = (
        ("map", _DEFAULT.map),
        ("odom", _DEFAULT.odom),
        ("base", _DEFAULT.base),
        ("camera", _DEFAULT.camera),
    )
    for name, default in frames:
        parser.add_argument("--%s-frame" % name, metavar="NAME", default=default, help="(%(default)s)")
    parser.add_argument(
        "--tf",
        choices=MODES,
        help="transforms: base: map -> base; odom: map -> odom; tree: that and odom -> base; none "
        "(%s where the camera is sent odometry, else %s)" % (with_odometry, BASE),
    )
    parser.add_argument(
        "--tf-ahead", metavar="SECONDS", type=float, default=0.0, help="map -> odom is told for so much later"
    )


def options_of(args: argparse.Namespace, with_odometry: str, background: bool) -> Options:
    """The Options of parsed arguments. UserError for what cannot be."""
    if args.pictures is not None and not (args.pictures > 0 and math.isfinite(args.pictures)):
        raise UserError("--pictures %g: give a number above 0" % args.pictures)
    if not 0 <= args.tf_ahead <= 10:
        raise UserError("--tf-ahead %g: give 0 to 10 s" % args.tf_ahead)
    names = Names(args.namespace, args.map_frame, args.odom_frame, args.base_frame, args.camera_frame)
    options = Options(names, args.tf, with_odometry, ahead_s=args.tf_ahead, background=background)
    if args.settings:
        from larics_host.connection.camera_settings import checked, read_file

        values = read_file(args.settings)
        options.settings = checked(values).as_dict()
        if "map" not in values:  # then it is not known, which is not the same as empty
            options.settings.pop("map")
    if args.map:
        from larics_host.mapping.mapfile import read_map

        hall = read_map(args.map)
        options.map_rows, options.route = hall.rows(), list(hall.route)
    return options


def asked_settings(pictures: bool) -> tuple[str, ...]:
    """Names of the settings that a camera is asked for; with pictures also of those that decide what it
    sees."""
    from larics_host.ros.known_settings import HALL, MOUNTING

    names = [*MOUNTING, *HALL]
    if pictures:
        from larics.device.sensor import EVERY_PART
        from larics.settings import FIELDS

        names = [f.name for f in FIELDS if f.rebuilds & EVERY_PART and f.name not in names] + names
    return tuple(names)
