"""`larics map`: where the markers are: made, checked, drawn, built from logs, and given to a camera."""

from __future__ import annotations

import argparse
import math
import os
import statistics
from collections import Counter

from larics.wire import messages as m
from larics_host import files
from larics_host.connection import camera_settings
from larics_host.errors import UserError
from larics_host.wording import counted

NAME = "map"
HELP = "make, check, draw and build maps of markers"
EXAMPLE = """
larics map create hall.json --marker 3,0,0,0 --marker 5,1500,0,90 --route 3,5,3
larics map build run.jsonl -o hall.json --anchor 3,0,0,0 --png hall.png
larics map build drive.bin -o hall.json --distance 3,17,12480       # odometry in the log, one distance taped
larics map check hall.json --reach-mm 4000
larics map draw hall.json -o hall.png
larics map send hall.json --port /dev/ttyACM0 --save
"""

EXIT_PROBLEMS = 1
MISREAD_MOST = 5  # readings
WEAK_MM, WEAK_TIMES = 15.0, 2.0  # standard deviation of a place, that of most


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")

    create = _action(actions, "create", "a map from a survey", "the map to write")
    create.add_argument(
        "--marker", action="append", default=[], metavar="ID,X,Y,DEG", help="mm, degrees; [,HEIGHT[,RADIUS]]"
    )
    create.add_argument(
        "--csv", metavar="FILE", help="columns id,x_mm,y_mm,heading_deg[,height_mm,radius_mm]"
    )
    create.add_argument("--settings", metavar="FILE.json", help="the map and route that these settings have")
    _route_argument(create)
    create.add_argument("--force", action="store_true", help="overwrite an existing file")

    check = _action(actions, "check", "every problem of a map and its route; exit code 1 when there is one")
    check.add_argument("--reach-mm", type=float, default=5000.0, metavar="MM", help="farthest leg (5000)")
    check.add_argument(
        "--settings", metavar="FILE.json", help="camera's settings: sizes, heights, IDs in use"
    )
    _distance_argument(check)

    draw = _action(actions, "draw", "a picture of a map")
    draw.add_argument("-o", "--output", required=True, metavar="FILE.png")

    build = actions.add_parser(
        "build",
        help="a map from logs",
        description="A map from logs in which neighbouring markers are seen together, or of drives of a "
        "vehicle that sends its odometry: then no two need be in view at once. Loops that pass each marker "
        "three times and one distance measured by hand make it exact.",
    )
    build.add_argument("logs", nargs="+", metavar="LOG", help=".jsonl, .csv, .bin or .mcap")
    build.add_argument("-o", "--output", required=True, metavar="MAP.json")
    build.add_argument("--anchor", metavar="ID,X,Y,DEG", help="where this marker is (the first seen: 0,0,0)")
    build.add_argument(
        "--place", action="append", default=[], metavar="ID,X,Y[,DEG]", help="known place; may be repeated"
    )
    build.add_argument("--repeats", action="store_true", help="IDs stand at several places of the building")
    build.add_argument("--heights", action="store_true", help="store the markers' measured heights")
    build.add_argument("--png", metavar="FILE.png", help="draw the result, its links and error ellipses")
    build.add_argument("--force", action="store_true", help="overwrite an existing file")
    _route_argument(build)
    _distance_argument(build)

    send = _action(actions, "send", "give map and route to a camera")
    camera_settings.add_port_arguments(send)
    send.add_argument("--save", action="store_true", help="and keep them through a restart")


def _action(actions, name, text, what="a map, or settings that hold one"):
    added = actions.add_parser(name, help=text, description=text)
    added.add_argument("map", metavar="MAP.json", help=what)
    return added


def _route_argument(parser):
    parser.add_argument("--route", metavar="ID,ID...", help="IDs in the order of driving")


def _distance_argument(parser):
    parser.add_argument(
        "--distance",
        action="append",
        default=[],
        metavar="ID,ID,MM",
        help="measured from centre to centre; may be repeated",
    )


def run(args: argparse.Namespace) -> int:
    return _ACTIONS[args.action](args)


def _numbers(option, text, counts, what):
    """The numbers of an option, the IDs in front whole; UserError that names it."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(math.isfinite(number) for number in numbers):
        raise UserError("%s %s: give %s, such as %s" % (option, text, *what))
    return numbers


def _id(option, text, number):
    if number != int(number) or not 0 <= number < m.ID_NONE:
        raise UserError("%s %s: %g is no ID" % (option, text, number))
    return int(number)


def _distances(args):
    found = []
    for text in args.distance:
        a, b, mm = _numbers("--distance", text, (3,), ("ID,ID,MM", "3,17,12480"))
        if a == b or not mm > 0:
            raise UserError("--distance %s: two markers, and a distance above 0" % text)
        found.append((_id("--distance", text, a), _id("--distance", text, b), mm))
    return found


def _route(args):
    try:
        return [int(part) for part in args.route.split(",")] if args.route else []
    except ValueError:
        raise UserError("--route %s is no list of IDs, such as 3,5,3" % args.route) from None


def _create(args):
    from larics_host.mapping import mapfile
    from larics_host.mapping.check import doubts, problems

    files.refuse_existing(args.map, args.force)
    hall = mapfile.Map()
    if args.settings:
        hall = mapfile.of_settings(camera_settings.read_file(args.settings), args.settings)
    if args.csv:
        hall.markers += mapfile.read_csv(args.csv)
    hall.markers += [mapfile.parse_marker(text) for text in args.marker]
    hall.route = _route(args) or hall.route
    if not hall.markers:
        raise UserError("a map needs markers: give --marker, --csv or --settings")
    mapfile.write_map(args.map, hall)
    print("%s written to %s" % (counted(len(hall.markers), "marker"), args.map))
    return _tell(problems(hall, float("inf")), doubts(hall))


def _tell(found, doubtful=()):
    for line in doubtful:
        print("doubt: " + line)
    for line in found:
        print("problem: " + line)
    return EXIT_PROBLEMS if found else 0


def _check(args):
    from larics_host.mapping.check import doubts, problems
    from larics_host.mapping.mapfile import read_map

    if not args.reach_mm > 0:
        raise UserError("--reach-mm %g: give a number above 0" % args.reach_mm)
    hall = read_map(args.map)
    settings = None
    if args.settings:
        known = camera_settings.read_file(args.settings)
        settings = camera_settings.checked({k: v for k, v in known.items() if k not in ("map", "route")})
    found = problems(hall, args.reach_mm, _distances(args), settings)
    if not found:
        counts = counted(len(hall.markers), "marker"), counted(len(hall.route), "step")
        print("%s: %s, route of %s: no problem" % (args.map, *counts))
    return _tell(found, doubts(hall))


def _draw(args):
    from larics_host.mapping.draw import draw_map
    from larics_host.mapping.mapfile import read_map

    hall = read_map(args.map)
    if not hall.markers:
        raise UserError("%s has no marker" % args.map)
    files.refuse_other(args.output, files.PICTURE)
    try:
        files.write_file(args.output, draw_map(hall, title=args.map))
    except ValueError as error:
        raise UserError("%s: %s; larics map check tells more" % (args.map, error)) from None
    print("drawn to %s" % args.output)
    return 0


def _build(args):
    from larics_host.mapping import graph, mapfile
    from larics_host.mapping.build import build
    from larics_host.mapping.check import problems
    from larics_host.mapping.collect import collect
    from larics_host.progress import measured

    graph.needed()  # before the logs are read
    files.refuse_existing(args.output, args.force)
    if args.png:
        files.refuse_other(args.png, files.PICTURE)
    request = _request(args)
    _refuse_twice(args.logs)
    with measured(sum(files.size(path) for path in args.logs), "reading") as progress:
        collected = collect(args.logs, args.repeats, progress)
    with measured(1, "building") as progress:
        built = build(collected, request, progress)
    hall = mapfile.Map(route=_route(args))
    for number, pose in sorted(built.poses.items()):
        hall.markers.append(_marker(built, number, args.heights))
        place, sigmas = built.places[number], built.sigmas(number)
        print(
            "marker %3d: x %9.1f y %9.1f mm, heading %6.2f deg, +- %.1f mm, %.2f deg, %s"
            % (place.id, *pose, sigmas.place_mm, sigmas.heading_deg, counted(place.seen, "reading"))
        )
    mapfile.write_map(args.output, hall)
    _tell_build(collected, built)
    print("%s written to %s" % (counted(len(hall.markers), "marker"), args.output))
    if args.png:
        from larics_host.mapping.draw import draw_map

        numbers = sorted(built.poses)
        ellipses = [(built.poses[number][:2], built.covariances[number][:2, :2]) for number in numbers]
        title = "built from %s" % ", ".join(args.logs)
        picture = draw_map(hall, built.lines, title, ellipses, _moved(built), _remarks(built))
        files.write_file(args.png, picture)
    found = []
    for group in built.untied:
        # a few readings of an ID that nothing else supports are misread markers, not another one
        if sum(built.places[k].seen for k in group) < MISREAD_MOST:
            print("ignored, as misread: marker %s" % _names(built, group))
        else:
            found.append("not tied to the rest: marker %s" % _names(built, group))
    return _tell(found + built.notes + problems(hall, float("inf")))


def _refuse_twice(logs):
    """What is said twice would count twice."""
    seen = set()
    for path in logs:
        if os.path.realpath(path) in seen:
            raise UserError("%s is given twice" % path)
        seen.add(os.path.realpath(path))


def _request(args):
    from larics_host.mapping.build import Request

    given = []
    for text in args.place:
        marker_id, x, y, *turned = _numbers("--place", text, (3, 4), ("ID,X,Y or ID,X,Y,DEG", "3,1500,0"))
        given.append((_id("--place", text, marker_id), x, y, turned[0] if turned else None))
    if len(given) == 1 and not args.anchor:
        raise UserError("--place holds the map by two or more places: give one more, or --anchor alone")
    anchor = None
    if args.anchor is not None:
        marker_id, *pose = _numbers("--anchor", args.anchor, (4,), ("ID,X,Y,DEG", "3,0,0,90"))
        anchor = (_id("--anchor", args.anchor, marker_id), *pose)
    held = Counter(one[0] for one in [*given, anchor] if one)
    for marker_id, count in held.items():
        if count > 1:
            raise UserError(
                "marker %d is given %d places: --place and --anchor take one each" % (marker_id, count)
            )
    return Request(anchor, given, _distances(args))


def _marker(built, number, heights):
    import numpy as np

    from larics_host.mapping.mapfile import Marker

    place, sigmas = built.places[number], built.sigmas(number)
    height = float(np.median(place.heights_mm)) if heights else None
    pose = built.poses[number]
    return Marker(place.id, *pose, height, None, sigmas.place_mm, sigmas.heading_deg)


def _tell_build(collected, built):
    weak = _weak(built) if built.is_scaled else []  # else far ones are less known, wherever one drives
    if weak:
        told = ", ".join("%d (%s)" % (built.places[number].id, _how_well(built, number)) for number in weak)
        print("known less well than the others, drive by once more: marker %s" % told)
    for move in built.moves:
        text = "marker %d was moved by %.0f mm while it was logged: the map has its last place"
        print(text % (move.id, move.mm))
    for lacked in built.unknown:
        text = "the map lacks a marker near x %.0f y %.0f mm, read as marker %s: drive by it once more"
        print(text % (lacked.x_mm, lacked.y_mm, _read_as(lacked)))
    if built.passages:
        aside = ", ".join("%d" % marker_id for marker_id in sorted(built.aside))
        print(
            "%s, %d misread or set aside%s; %s outvoted"
            % (
                counted(built.passages, "passage"),
                built.aside.total(),
                " (read as marker %s)" % aside if aside else "",
                counted(collected.outvoted, "reading"),
            )
        )
    for shares in built.shares.values():
        scale, drift, track = shares[:3]
        text = "odometry: scale %+.2f %%, drift %+.3f deg/m, turn %+.2f %%, noise %.0f mm2/km"
        print(text % (100 * scale, math.degrees(drift) * 1000, 100 * track, 1e6 * built.noise))
    counts = counted(built.links, "link"), built.rms_mm, counted(collected.refused, "reading")
    print("%s, rms %.2f mm; %s refused" % counts)


def _weak(built):
    """Numbers of the markers whose places are known much less well than most, the worst first."""
    sigmas = {number: built.sigmas(number).place_mm for number in built.poses}
    least = max(WEAK_MM, WEAK_TIMES * statistics.median(sigmas.values()))
    return sorted((number for number in sigmas if sigmas[number] > least), key=lambda number: -sigmas[number])


def _moved(built):
    """[((x, y) before, (x, y) now)] of the markers that were moved."""
    now = {
        move.former: [number for number in built.poses if built.places[number].id == move.id]
        for move in built.moves
    }
    return [
        (place, min((built.poses[number][:2] for number in now[former]), key=lambda at: math.dist(at, place)))
        for former, place in built.before.items()
        if now[former]
    ]


def _remarks(built):
    """[((x, y), text)] of what the picture should say."""
    weak = _weak(built) if built.is_scaled else []
    said = [(built.poses[number][:2], _how_well(built, number)) for number in weak]
    return said + [((one.x_mm, one.y_mm), "? read as %s" % _read_as(one)) for one in built.unknown]


def _read_as(unknown):
    return ", ".join("%d" % marker_id for marker_id in sorted(set(unknown.ids)))


def _how_well(built, number):
    once = "passed once, " if built.passed[number] == 1 else ""
    return once + "+- %.0f mm" % built.sigmas(number).place_mm


def _names(built, group):
    places = [built.places[k] for k in group]
    return ", ".join("%d (%s)" % (place.id, counted(place.seen, "reading")) for place in places)


def _send(args):
    from larics_host.mapping.mapfile import read_map

    hall = read_map(args.map)
    changes = {"map": hall.rows(), "route": hall.route}
    camera_settings.checked(changes)
    with camera_settings.connected(args.port, args.baud) as client:
        sent = camera_settings.apply(client, camera_settings.read_all(client), changes)
        if args.save:
            client.save()
    print("changed: %s" % ", ".join(sent) if sent else "the camera has this map already")
    if args.save:
        print("saved")
    return 0


_ACTIONS = {"create": _create, "check": _check, "draw": _draw, "build": _build, "send": _send}
