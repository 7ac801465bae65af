"""`larics simulate`: frames with truth, to try everything without a camera."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from larics_host.compilation import told
from larics_host.drive.command import OUTPUTS, add_loop_arguments, run_loop
from larics_host.drive.desk_options import add_desk_arguments
from larics_host.errors import EXIT_INTERRUPTED, UserError, missing_package
from larics_host.files import write_file
from larics_host.images.frame_folder import keeping, make_folder, write_frame
from larics_host.marker_ids import is_coded, parse_ids
from larics_host.progress import watched
from larics_host.truth import TruthWriter
from larics_host.wording import counted

NAME = "simulate"
HELP = (
    "render frames of a ceiling with markers, with the truth about each; a camera on the desk that sees them"
)
EXAMPLE = """
larics simulate --preset sunny --frames 100 --seed 7 --radius-px 30 -o frames
larics simulate --preset harsh --family coded --frames 100 -o coded
larics simulate --preset cloudy --drive curve --ids 1,2,3 --rate 10 -o drive
larics simulate --drive loop --condition pushed --seconds 60 -o pushed
larics simulate --tour -o tour                    # what the README's tour works on
larics simulate --desk tour/drive --link camera   # a camera that sees these frames, at the port ./camera
"""

# named here as well, for a quick --help; a test compares them with the renderer's
PRESET_NAMES = (
    *("sunny", "cloudy", "double", "fast", "harsh", "multi", "border", "negative"),
    *("glossy", "webcam", "dirty_lens", "worn"),
)
MIN_SIDE_PX, MAX_SIDE_PX = 16, 2048
MAX_RADIUS_PX = 400.0
LOOP = "loop"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("--preset", default="sunny", help=", ".join(PRESET_NAMES))
    parser.add_argument("--frames", type=int, metavar="N", help="how many (100; a drive: to the path's end)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="the same seed gives the same bytes")
    parser.add_argument("--radius-px", type=float, default=30.0, metavar="PX", help="outer ring in the image")
    parser.add_argument("--width", type=int, default=360, metavar="PX", help="of a frame (360)")
    parser.add_argument("--height", type=int, default=296, metavar="PX", help="of a frame (296)")
    parser.add_argument(
        "--ids", metavar="N,N-N", help="IDs to draw from; on a drive: the markers in their order"
    )
    parser.add_argument(
        "--family", metavar="NAME", help="plain (default), coded, or mixed: some of both; not with --ids"
    )
    parser.add_argument("--target", default="larics", help="larics, or a tag to compare: aruco, apriltag")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for the frames")
    parser.add_argument(
        "--overwrite", action="store_true", help="replace the frames or the drive that DIR holds"
    )
    scene = parser.add_argument_group("instead of what the preset draws")
    scene.add_argument("--contrast", type=float, metavar="GREY", help="between white plate and black ink")
    scene.add_argument("--blur-px", type=float, metavar="PX", help="motion during the exposure")
    scene.add_argument("--defocus-px", type=float, metavar="PX", help="sigma of the optics' blur")
    scene.add_argument("--tilt-deg", type=float, metavar="DEG", help="lean of the camera")
    scene.add_argument("--occlusion", type=float, metavar="SHARE", help="hidden share of the ring, 0 to 1")
    scene.add_argument("--line-mm", type=float, metavar="MM", help="line width, 5 to 30")
    drive = parser.add_argument_group("a drive under several markers")
    drive.add_argument("--drive", metavar="SHAPE", help="straight, curve, or loop: see below")
    drive.add_argument("--speed-cm-s", type=float, metavar="CM", help="speed (that of the preset)")
    drive.add_argument("--rate", type=float, default=30.0, metavar="HZ", help="frames per second (30)")
    drive.add_argument(
        "--spacing-mm", type=float, default=1500.0, metavar="MM", help="marker to marker (1500)"
    )
    add_loop_arguments(parser)
    add_desk_arguments(parser)
    parser.add_argument("--tour", action="store_true", help="all that the README's tour works on")


# option, lowest, highest value that makes sense
_LIMITS = (
    ("radius_px", 3.0, MAX_RADIUS_PX),
    ("width", MIN_SIDE_PX, MAX_SIDE_PX),
    ("height", MIN_SIDE_PX, MAX_SIDE_PX),
    ("frames", 1, 1_000_000),
    ("seed", 0, 2**62),
    ("contrast", 0.5, 255.0),
    ("blur_px", 0.0, 100.0),
    ("defocus_px", 0.0, 50.0),
    ("tilt_deg", 0.0, 60.0),
    ("occlusion", 0.0, 1.0),
    ("line_mm", 5.0, 30.0),
    ("speed_cm_s", 0.1, 2000.0),
    ("rate", 0.01, 10000.0),
    ("spacing_mm", 500.0, 100_000.0),
)
_OVERRIDES = ("contrast", "blur_px", "defocus_px", "tilt_deg", "occlusion", "line_mm")


def _check(args):
    from larics_host.render.drive import SHAPES
    from larics_host.render.plates import TARGETS

    for value, known, what in (
        (args.preset, PRESET_NAMES, "preset"),
        (args.target, TARGETS, "target"),
        (args.drive or SHAPES[0], (*SHAPES, LOOP), "drive"),
    ):
        if value not in known:
            raise UserError("unknown %s %s: choose from %s" % (what, value, ", ".join(known)))
    if args.family:
        if args.ids or args.drive or args.target != "larics":
            raise UserError("--family does not go with --ids, --drive and tags: with --ids the IDs decide")
        if args.family != "mixed":
            is_coded(args.family)
    for name, low, high in _LIMITS:
        value = getattr(args, name)
        if value is not None and not low <= value <= high:  # also refuses nan
            option = "--" + name.replace("_", "-")
            raise UserError("%s is %.10g: give a number from %.10g to %.10g" % (option, value, low, high))
    if args.drive:
        given = [name for name in _OVERRIDES if getattr(args, name) is not None]
        if given:
            raise UserError("--%s does not go with --drive" % given[0].replace("_", "-"))
    elif args.speed_cm_s is not None:
        raise UserError("--speed-cm-s needs --drive")


def _ids(args):
    """The IDs of --ids; tags, which are there to be compared, have those of plain markers."""
    return parse_ids([args.ids], "coded" if args.target == "larics" else "plain", allow_id0=True)


def _camera_facts(camera):
    return {
        "focal_px": round(camera.focal_px, 4),
        "center_x_px": round(camera.center_x_px, 4),
        "center_y_px": round(camera.center_y_px, 4),
        "k1": round(camera.k1, 6),
        "k2": round(camera.k2, 6),
        "row_us": round(camera.row_us, 3),
        "mounting_deg": camera.mounting_deg,
        "mirrored": camera.mirrored,
    }


def _plan_drive(args, facts):
    """(function index -> frame and truths, number of frames); completes the facts."""
    from larics_host.render.drive import draw_drive

    drive = draw_drive(
        args.preset,
        args.seed,
        shape=args.drive,
        marker_ids=_ids(args) if args.ids else (1, 2, 3, 4, 5),
        spacing_mm=args.spacing_mm,
        speed_mm_s=None if args.speed_cm_s is None else 10 * args.speed_cm_s,
        rate_hz=args.rate,
        width=args.width,
        height=args.height,
        radius_px=args.radius_px,
        target=args.target,
    )
    camera = drive.camera
    facts["camera"] = _camera_facts(camera)
    facts["camera"]["tilt_deg"] = round(camera.tilt_deg, 4)
    facts["camera"]["tilt_direction_deg"] = round(camera.tilt_direction_deg, 3)
    facts["camera"]["exposure_us"] = round(camera.exposure_us, 1)
    facts["ceiling_mm"] = round(drive.scene.ceiling_mm, 3)
    facts["drive"] = {"shape": args.drive, "speed_mm_s": round(drive.speed_mm_s, 3), "rate_hz": args.rate}
    facts["markers"] = [
        {
            "id": plate.marker_id,
            "x_mm": round(plate.pose.x_mm, 3),
            "y_mm": round(plate.pose.y_mm, 3),
            "heading_deg": round(plate.pose.heading_deg, 4),
        }
        for plate in drive.scene.plates
    ]
    return drive.frame, args.frames or drive.frames


def _plan_series(args, facts):
    from larics_host.render import render_frame
    from larics_host.render.series import draw_camera

    sizes = {"width": args.width, "height": args.height, "radius_px": args.radius_px}
    overrides = {name: getattr(args, name) for name in _OVERRIDES if getattr(args, name) is not None}
    facts["camera"] = _camera_facts(draw_camera(args.preset, args.seed, **sizes))
    facts["overrides"] = dict(overrides)
    if args.family:
        overrides["family"] = args.family
    if args.ids:
        overrides["marker_ids"] = _ids(args)

    def frame(index):
        return render_frame(args.preset, args.seed, index, target=args.target, **sizes, **overrides)

    return frame, args.frames or 100


def run(args: argparse.Namespace) -> int:
    """Renders the frames, or is the camera on the desk; returns the exit code."""
    if args.desk:
        if args.output or args.drive or args.tour:
            raise UserError("--desk shows frames that are there: it does not go with -o, --drive and --tour")
        from larics_host.drive.desk import run_desk

        return run_desk(args)
    if not args.output:
        raise UserError("-o DIR is missing: where the frames go")
    try:
        import numba  # noqa: F401 (the renderer's loops are hopeless without it)
    except ImportError:
        raise missing_package("larics simulate", "numba") from None
    if args.tour:
        from larics_host.drive.tour import write_tour

        count = write_tour(Path(args.output), args.overwrite)
        print("%s in drive, places, turn, ahead, and clip.bin in %s" % (counted(count, "frame"), args.output))
        return 0
    if args.drive == LOOP:
        return run_loop(args, make_folder(args.output, args.overwrite, OUTPUTS))
    _check(args)
    facts = {"preset": args.preset, "seed": args.seed, "width": args.width, "height": args.height}
    facts.update(radius_px=args.radius_px, target=args.target)
    render, count = (_plan_drive if args.drive else _plan_series)(args, facts)
    facts["frames"] = count
    beside = "truth.csv", "scene.json"
    folder = make_folder(args.output, args.overwrite, beside)
    seen = 0
    interrupted = ""
    try:
        with (
            keeping(folder, beside) as kept,
            TruthWriter(folder / "truth.csv") as truth_file,
        ):
            write_file(folder / "scene.json", json.dumps(facts, indent=2) + "\n")
            for index in watched(range(count), count, quiet_stdout=True):
                with told("the renderer"):
                    frame, truths = render(index)
                path = folder / truths[0].frame
                write_frame(path, frame)
                try:
                    truth_file.write(truths)
                except UserError:
                    path.unlink()  # a frame without its truth is none
                    raise
                kept.frames += 1
                seen += sum(truth.id is not None for truth in truths)
    except KeyboardInterrupt:
        if not kept.frames:
            raise
        interrupted = "interrupted: "
    counts = counted(kept.frames, "frame"), counted(seen, "marker")
    print("%s%s with %s, truth.csv and scene.json in %s" % (interrupted, *counts, folder))
    return EXIT_INTERRUPTED if interrupted else 0
