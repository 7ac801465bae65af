"""Makes the parts of the program from the settings."""

from larics.camera import Camera
from larics.marker import LARICS3


def make_detector(settings):
    """The detector that the settings ask for. ValueError when its ranges do not suit it, MemoryError."""
    radii = (settings.radius_min_px, settings.radius_max_px)
    family = LARICS3.scaled(settings.outer_mm10, settings.line_mm10, settings.allow_id0)
    if settings.method == "paper":
        from larics.paper import PaperDetector

        return PaperDetector(settings.width, settings.height, *radii, family=family)
    from larics.detector import Detector

    line_mm = settings.line_mm10 * 150 // settings.outer_mm10 if settings.line_mm10 else None
    confirm = None
    if settings.confirm_needed > 1:
        confirm = (settings.confirm_needed, settings.confirm_frames)
    return Detector(
        settings.width,
        settings.height,
        radius_min_px=radii[0],
        radius_max_px=radii[1],
        line_mm=line_mm,
        family=family,
        allow_id0=settings.allow_id0,
        confirm=confirm,
    )


def make_locator(settings):
    """The calibrated camera; without a calibration one of about 50 degrees, of which only the headings and
    IDs mean something. ValueError when the values are no camera."""
    if not settings.focal_q8:
        return Camera(
            settings.width,
            settings.height,
            256 * max(settings.width, settings.height),
            mount_cdeg=settings.mount_cdeg,
            mirrored=settings.mirrored,
        )
    return Camera(
        settings.width,
        settings.height,
        settings.focal_q8,
        center_x_q8=settings.center_x_q8 or None,
        center_y_q8=settings.center_y_q8 or None,
        k1_e5=settings.k1_e5,
        k2_e5=settings.k2_e5,
        mount_cdeg=settings.mount_cdeg,
        mirrored=settings.mirrored,
        tilt_forward_cdeg=settings.tilt_forward_cdeg,
        tilt_left_cdeg=settings.tilt_left_cdeg,
        camera_x_mm10=settings.camera_x_mm10,
        camera_y_mm10=settings.camera_y_mm10,
        camera_z_mm10=settings.camera_z_mm10,
        ceiling_mm10=settings.ceiling_mm10,
    )


def make_navigator(settings):
    """Pose in the map and on the route of the settings; None without a map or a calibration.
    ValueError for an impossible map or route."""
    if not settings.map or not settings.focal_q8:
        return None
    from larics.navigator import Navigator

    return Navigator(
        settings.map,
        settings.route,
        settings.allowed_ids,
        settings.outer_mm10,
        settings.camera_z_mm10,
        max(1, settings.max_speed_mm_s),
    )
