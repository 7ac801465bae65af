"""`larics calibrate`: focal length, tilt, lens, mounting angle and rotation centre from recorded frames, what
odometry leaves out from a log, and of each how well it is known."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from larics_host import files
from larics_host.connection import camera_settings
from larics_host.detection import options as detection_options
from larics_host.errors import UserError, missing_package
from larics_host.wording import counted

NAME = "calibrate"
HELP = "find focal length, lens, tilt, mounting angle and rotation centre from frames of markers"
EXAMPLE = """
larics calibrate --places places --turn turn --straight ahead --height-mm 2750 -o camera.json --plot fit.png
larics calibrate --places places --height-mm 2750 --level          # focal length and mm per px alone
larics calibrate --turn turn --facing-deg 0 --settings camera.json -o camera.json --force
larics calibrate --odometry drive.jsonl --settings camera.json -o camera.json --force
"""

_HEIGHT_RANGE_MM = (100.0, 26000.0)
_OUTER_RANGE_MM = (10.0, 400.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    frames = parser.add_argument_group("frames, as of larics record")
    frames.add_argument("--places", nargs="+", metavar="PATH", help="a marker in all parts of the picture")
    frames.add_argument("--turn", nargs="+", metavar="PATH", help="one turn on the spot under a marker")
    frames.add_argument(
        "--straight", nargs="+", metavar="PATH", help="a straight drive forward under a marker, in order"
    )
    parser.add_argument(
        "--odometry", metavar="LOG", help="a log of larics log: a drive by markers of the map, with odometry"
    )
    parser.add_argument(
        "--facing-deg",
        metavar="DEG",
        type=float,
        help="instead of --straight: where the vehicle pointed in the first frame of the turn, "
        "counterclockwise from the direction of the marker's orientation line",
    )
    parser.add_argument(
        "--height-mm", metavar="MM", type=float, help="markers above the lens, measured by hand"
    )
    parser.add_argument("--outer-mm", metavar="MM", type=float, help="radius of the outer ring (150)")
    parser.add_argument("--level", action="store_true", help="keep tilt and lens: only the focal length")
    parser.add_argument("--with-k2", action="store_true", help="fit the distortion's k2 too")
    detection_options.add_arguments(parser)
    detection_options.add_jobs(parser)
    known = parser.add_argument_group("what is known, and where the result goes")
    known.add_argument("--settings", metavar="FILE.json", help="settings to begin with")
    camera_settings.add_port_arguments(known, required=False)
    known.add_argument("-o", "--output", metavar="FILE.json", help="write all settings with the result here")
    known.add_argument("--force", action="store_true", help="overwrite an existing file")
    known.add_argument(
        "--send", action="store_true", help="send the result to the camera at --port and save it"
    )
    known.add_argument(
        "--plot", metavar="FILE.png", help="draw the residuals; with a second plot FILE-turn.png"
    )


def run(args: argparse.Namespace) -> int:
    try:
        import scipy.optimize  # noqa: F401 (asked for before anybody waits for the detection)
    except ImportError:
        raise missing_package("larics calibrate", "scipy") from None
    _check(args)
    options = detection_options.from_args(args)
    known = _known(args)
    work = _Calibration(args, camera_settings.checked(known))
    if args.places:
        work.lens(options)
    if args.turn:
        work.turn(options)
    if args.odometry:
        work.odometry()
    values = {**known, **work.changes}
    camera_settings.checked(values)
    if args.output:
        camera_settings.write_file(args.output, values)
        print("settings written to %s" % args.output)
        if not known:
            print("all others are the defaults, without map and route: --settings begins with a camera's own")
    if args.send:
        with camera_settings.connected(args.port, args.baud) as client:
            sent = camera_settings.apply(client, camera_settings.read_all(client), work.changes)
            client.save()
        print("sent and saved: %s" % ", ".join(sent) if sent else "the camera has these values already")
    return 0


def _check(args):
    if not args.places and not args.turn and not args.odometry:
        raise UserError("nothing to calibrate from: give --places, --turn or --odometry")
    for option, value, (low, high) in (
        ("--height-mm", args.height_mm, _HEIGHT_RANGE_MM),
        ("--outer-mm", args.outer_mm, _OUTER_RANGE_MM),
        ("--facing-deg", args.facing_deg, (-360.0, 360.0)),
    ):
        if value is not None and not low <= value <= high:
            raise UserError("%s is %g: give a number from %g to %g" % (option, value, low, high))
    if (args.straight or args.facing_deg is not None) and not args.turn:
        raise UserError("the mounting angle needs the rotation centre: give --turn too")
    if args.straight and args.facing_deg is not None:
        raise UserError("--straight and --facing-deg say the same: give one of them")
    if args.send and not args.port:
        raise UserError("--send needs the --port of the camera")
    if args.settings and args.port and not args.send:
        raise UserError("--settings and --port both say what is known: give one of them")
    if args.output:
        files.refuse_existing(args.output, args.force)
    if args.plot:
        read = [path for paths in (args.places, args.turn, args.straight) for path in paths or ()]
        for suffix in _PLOTS:
            files.refuse_other(_plot_path(args.plot, suffix), files.PICTURE, read)


def _plot_path(plot, suffix):
    path = Path(plot)
    return path.with_name(path.stem + suffix + (path.suffix or ".png"))


def _known(args):
    """{setting: value} to begin with; empty without --settings and --port."""
    if args.settings:
        return camera_settings.read_file(args.settings)
    if args.port:
        with camera_settings.connected(args.port, args.baud) as client:
            return camera_settings.read_all(client)
    return {}


class _Calibration:
    """The steps of one run; `changes` are the settings found so far, `model` the camera."""

    def __init__(self, args, settings):
        self.args = args
        self.settings = settings
        self.changes = {}
        self.model = None
        self.sigmas = {}  # of what was fitted to the sizes of rings
        self.outer_mm = args.outer_mm or settings.outer_mm10 / 10
        self.height_mm = args.height_mm
        if not self.height_mm and settings.ceiling_mm10:
            self.height_mm = (settings.ceiling_mm10 - settings.camera_z_mm10) / 10

    def _observe(self, paths, options):
        from larics_host.calibration.camera_model import model_of
        from larics_host.calibration.observe import observe

        mirrored = options.mirrored or self.settings.mirrored
        seen = observe(paths, options._replace(mirrored=mirrored), self.args.jobs)
        if self.model is None:
            self._suit(seen, mirrored)
            self.model = model_of(self.settings, seen.width, seen.height)
        if (seen.width, seen.height) != (self.model.width, self.model.height):
            raise UserError("the recordings differ in frame size: a calibration is for one size")
        counts = counted(seen.frames, "frame"), counted(len(seen.x_px), "marker")
        print("%s: %s, %s" % (", ".join(paths), *counts))
        return seen

    def _suit(self, seen, mirrored):
        """A calibration that is there already is for its frame size; --mirrored becomes a setting."""
        if mirrored and not self.settings.mirrored:
            self.changes["mirrored"] = True
        reason = camera_settings.calibrated_for(self.settings, seen.width, seen.height)
        if reason and not self.args.places:
            raise UserError("%s: give --places of this size too" % reason)
        if reason:
            print("%s: begun anew" % reason)
            self.changes.update(dict.fromkeys(_OF_SIZE, 0))
        self.settings.update({"width": seen.width, "height": seen.height, **self.changes})

    def _keep(self):
        from larics_host.calibration.camera_model import settings_of

        self.changes.update(settings_of(self.model))
        self.changes["outer_mm10"] = round(10 * self.outer_mm)
        self.changes["ceiling_mm10"] = round(10 * self.height_mm) + self.settings.camera_z_mm10

    def lens(self, options):
        from larics_host.calibration import lens

        seen = self._observe(self.args.places, options)
        if not self.height_mm:
            share = self.outer_mm / float(sorted(seen.radius_px)[len(seen.radius_px) // 2])
            raise UserError(
                "1 px is %.3f mm at the markers, but rings alone do not tell focal length from height: "
                "measure how far the markers are above the lens and give --height-mm" % share
            )
        free = lens.SCALE if self.args.level else (*lens.LENS, "k2") if self.args.with_k2 else lens.LENS
        found = lens.fit(seen, self.model, free, self.height_mm, self.outer_mm)
        self.model = found.model
        self._keep()
        self.sigmas = found.sigmas
        self._keep_sigmas()
        self._print_fitted(name for name in free if not (self.args.turn and "tilt" in name))
        _print("at the markers, straight ahead", self.height_mm / found.model.focal_px, None, "mm per px")
        _print("residual of the radii, rms", found.rms_px, None, "px")
        self._plot("", lambda plots: plots.lens(seen, found))

    def turn(self, options):
        from larics_host.calibration import turn

        seen = self._observe(self.args.turn, options)
        seen = seen.of(seen.commonest_id())
        if not self.args.places and not self.settings.focal_q8:
            raise UserError("the turn needs the focal length: give --places too, or --settings that have it")
        if not self.height_mm:
            raise UserError("the turn needs the markers' height above the lens: give --height-mm")
        tilts = [sigma for name, sigma in self.sigmas.items() if "tilt" in name]
        tilt_deg = (sum(sigma**2 for sigma in tilts) / max(1, len(tilts))) ** 0.5
        found = turn.fit_turn(seen, self.model, self.height_mm, tilt_deg)
        mount = self._mount(turn, found, options)
        centre = turn.rotated(found.centre_mm, mount.correction_deg)
        self.model = self.model.turned(mount.correction_deg)
        self._keep()
        self.changes["camera_x_mm10"], self.changes["camera_y_mm10"] = (round(10 * float(v)) for v in centre)
        if mount.sigma_deg is not None:
            self.changes["mount_sigma_cdeg"] = max(1, math.ceil(100 * mount.sigma_deg))
        self.changes["camera_sigma_mm10"] = min(10000, max(1, math.ceil(10 * found.sigma_mm)))
        # the lean towards the vehicle's sides is known only now
        self._print_fitted(name for name in self.sigmas if "tilt" in name)
        _print("mounting angle", self.model.mount_deg, mount.sigma_deg, "deg")
        _print("lens ahead of the rotation centre", centre[0], found.sigma_mm, "mm")
        _print("lens to the left of it", centre[1], found.sigma_mm, "mm")
        _print("turned by", found.span_deg, None, "deg")
        _print("residual of the places, rms", found.rms_mm, None, "mm")
        self._plot(_PLOTS[1] if self.args.places else "", lambda plots: plots.turn(found, mount))

    def _keep_sigmas(self):
        """How well lens and tilt are known, which the camera has in the sigma of its poses."""
        sigmas = self.sigmas
        if "focal_px" in sigmas:
            share = sigmas["focal_px"] / self.model.focal_px
            self.changes["focal_sigma_ppm"] = min(100000, max(1, math.ceil(1e6 * share)))
        tilts = [sigma for name, sigma in sigmas.items() if "tilt" in name]
        if tilts:
            self.changes["tilt_sigma_cdeg"] = min(3000, max(1, math.ceil(100 * max(tilts))))

    def odometry(self):
        from larics_host.calibration import odometry

        frames = odometry.frames_of(self.args.odometry)
        found = odometry.fit(odometry.windows_of(frames), self.settings.odometry_track_mm)
        self.changes.update(found.settings())
        _print("odometry: the way is longer by", 100 * found.scale, 100 * found.scale_sigma, "%")
        if found.turn_sigma is None:
            print("odometry: too few turns of 60 degrees to tell its track")
        else:
            _print("odometry: the turn is larger by", 100 * found.turn, 100 * found.turn_sigma, "%")
        _print("odometry: drift to the left", found.drift_deg_m, found.drift_sigma, "deg per m")
        _print("odometry: noise of a wheel", found.noise_mm2_km, None, "mm2 per km")
        print("compared by %s between or along markers" % counted(found.windows, "way"))

    def _print_fitted(self, names):
        for name in names:
            text, unit = _NAMES[name]
            _print(text, getattr(self.model, name), self.sigmas[name], unit)

    def _mount(self, turn, found, options):
        if self.args.straight:
            seen = self._observe(self.args.straight, options)
            seen = seen.of(seen.commonest_id())
            return turn.mount_by_drive(seen, self.model, self.height_mm, found.centre_mm)
        if self.args.facing_deg is not None:
            return turn.mount_by_facing(found, self.args.facing_deg)
        if not self.args.settings and not self.args.port:
            raise UserError(
                "turning alone does not tell where forward is: give --straight, --facing-deg, or --settings "
                "with the mounting angle"
            )
        print("the mounting angle is kept: turning alone does not tell it")
        return turn.KEPT

    def _plot(self, suffix, draw):
        if not self.args.plot:
            return
        from larics_host.calibration import plots

        files.write_file(_plot_path(self.args.plot, suffix), draw(plots))


_PLOTS = ("", "-turn")  # ends of the names of the plots
_OF_SIZE = ("focal_q8", "center_x_q8", "center_y_q8", "k1_e5", "k2_e5")
_NAMES = {
    "focal_px": ("focal length", "px"),
    "tilt_forward_deg": ("tilt, forward", "deg"),
    "tilt_left_deg": ("tilt, to the left", "deg"),
    "k1": ("lens distortion k1", ""),
    "k2": ("lens distortion k2", ""),
}


def _print(text, value, sigma, unit):
    shown = "%-36s %12.4f" % (text, value)
    if sigma is not None:
        shown += " +- %.4f" % sigma
    print((shown + " " + unit).rstrip())
