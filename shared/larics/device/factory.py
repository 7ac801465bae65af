"""Makes what finds and places markers from the settings: the one path, on a board and in all tools on a PC.

`settings` is anything with the settings as attributes, `size` the (width, height) of the frames when it is
not that of the settings. What a function reads of the settings, those fields declare (`Field.rebuilds`).
"""

from larics.detect.tracker import Tracker
from larics.locate.camera_model import Camera
from larics.marker import LARICS3
from larics.settings.constraints import CAMERA_SETTINGS, calibrated_camera, line_mm, seen_ids


def make_detector(settings, size=None, thorough=False, weigh_all=True):
    """What finds the markers as the settings ask for: its `detect(frame)` gives a list of Detection.

    thorough, weigh_all: as of Detector. ValueError when the settings do not suit the frames, MemoryError."""
    width, height = size or (settings.width, settings.height)
    radii = (settings.radius_min_px, settings.radius_max_px)
    coded = settings.family == "coded"
    family = LARICS3.scaled(settings.outer_mm10, settings.line_mm10, settings.allow_id0, coded)
    if settings.method == "paper":
        from larics.detect.paper import PaperDetector

        return PaperDetector(width, height, *radii, family=family)
    from larics.detect.detector import Detector

    confirm = None
    if settings.confirm_needed > 1:
        confirm = (settings.confirm_needed, settings.confirm_frames)
    detector = Detector(
        width,
        height,
        radius_min_px=radii[0],
        radius_max_px=radii[1],
        line_mm=line_mm(settings.line_mm10, settings.outer_mm10),
        family=family,
        allowed_ids=seen_ids(settings.allowed_ids, settings.mirrored),
        mirrored=settings.mirrored,
        allow_id0=settings.allow_id0,
        confirm=confirm,
        second_opinion=settings.second_opinion,
        max_tilt_deg=(settings.max_tilt_cdeg + 99) // 100,
        margin_min=settings.margin_min,
        thorough=thorough,
        weigh_all=weigh_all,
    )
    return Tracker(detector) if settings.tracking else detector


def make_locator(settings, size=None):
    """The calibrated camera; without a calibration one of about 50 degrees, of which only the headings and
    IDs mean something. ValueError when the values are no camera."""
    width, height = size or (settings.width, settings.height)
    if not settings.focal_q8:
        focal_q8 = 256 * max(width, height)
        return Camera(width, height, focal_q8, mount_cdeg=settings.mount_cdeg, mirrored=settings.mirrored)
    return calibrated_camera(width, height, {name: getattr(settings, name) for name in CAMERA_SETTINGS})


def make_rolling(settings):
    """What undoes a rolling shutter; None where there is none, or not known, or no calibration."""
    if not settings.row_ns or not settings.focal_q8:
        return None
    from larics.locate.rolling import RollingShutter

    return RollingShutter(settings.row_ns, settings.focal_q8, settings.mount_cdeg, settings.camera_z_mm10)


def make_navigator(settings):
    """Pose in the map and on the route of the settings; None without a map or a calibration.
    ValueError for an impossible map or route."""
    if not settings.map or not settings.focal_q8:
        return None
    from larics.locate.navigator import Navigator
    from larics.locate.uncertainty import OdometryNoise, Systematic

    return Navigator(
        settings.map,
        settings.route,
        settings.allowed_ids,
        settings.outer_mm10,
        settings.camera_z_mm10,
        max(1, settings.max_speed_mm_s),
        systematic=Systematic(
            settings.map_sigma_mm10,
            settings.map_sigma_cdeg,
            settings.focal_sigma_ppm,
            settings.height_sigma_mm10,
            settings.tilt_sigma_cdeg,
            settings.mount_sigma_cdeg,
            settings.camera_sigma_mm10,
            settings.camera_z_mm10,
        ),
        odometry_noise=OdometryNoise(
            settings.odometry_scale_ppm,
            settings.odometry_turn_ppm,
            settings.odometry_drift_mdeg_m,
            settings.odometry_scale_sigma_ppm,
            settings.odometry_turn_sigma_ppm,
            settings.odometry_drift_sigma_mdeg_m,
            settings.odometry_noise_mm2_km,
            settings.odometry_speed_noise_us,
            settings.odometry_track_mm,
        ),
    )
