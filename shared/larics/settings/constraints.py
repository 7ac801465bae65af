"""Whether settings suit the detector and the camera, found out without making a detector.

The reasons name settings. What passes here, `larics.device.factory` can make; a test holds it to that.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.locate.camera_model import MAX_HEIGHT_MM10, Camera
from larics.marker import LARICS3, PLAIN_ID_MOST, ids_in_words, is_used, mirrored_lines
from larics.marker.id_set import ends_of, within

_FOCAL_LEAST_Q8 = const(5120)
_LINE_LEAST_MM = const(5)  # at an outer radius of 150 mm
_LINE_MOST_MM = const(30)

CAMERA_SETTINGS = (
    "focal_q8", "center_x_q8", "center_y_q8",
    "k1_e5", "k2_e5", "mount_cdeg", "mirrored", "tilt_forward_cdeg", "tilt_left_cdeg", "camera_x_mm10",
    "camera_y_mm10", "camera_z_mm10", "ceiling_mm10",
)  # fmt: skip


def line_mm(line_mm10, outer_mm10):
    """The width of the lines in whole mm at an outer radius of 150 mm; None when it is not known."""
    return (line_mm10 * 150 + outer_mm10 // 2) // outer_mm10 if line_mm10 else None


def seen_ids(allowed, mirrored):
    """How the detector reads the allowed IDs, numbers or (first, last).

    A mirrored sensor shows it plain markers' lines in the opposite order; coded ones it puts right itself."""
    if not mirrored or not allowed:
        return allowed
    plain = [i for i in range(PLAIN_ID_MOST + 1) if within(allowed, i)]
    seen = [mirrored_lines(i) for i in plain]
    for item in allowed:
        first, last = ends_of(item)
        if last > PLAIN_ID_MOST:
            seen.append((max(first, PLAIN_ID_MOST + 1), last))
    return seen


def calibrated_camera(width, height, values):
    """The camera_model.Camera of settings (name: value) with a focal length. ValueError as there."""
    return Camera(
        width,
        height,
        values["focal_q8"],
        center_x_q8=values["center_x_q8"] or None,
        center_y_q8=values["center_y_q8"] or None,
        **{name: values[name] for name in CAMERA_SETTINGS[3:]},
    )


def family_reason(values):
    """None when the family has the allowed IDs and those of the map (name: value), else one line."""
    coded, allow_id0 = values["family"] == "coded", values["allow_id0"]
    for item in values["allowed_ids"]:
        first, last = ends_of(item)
        if first == last == 0 and not allow_id0:
            return "allowed_ids has ID 0, but allow_id0 is false"
        if not any(is_used(i, coded, allow_id0) for i in range(first, last + 1)):
            what = "ID %d" % first if first == last else "IDs %d to %d" % (first, last)
            return "allowed_ids has %s, but %s" % (what, ids_in_words(coded, allow_id0))
    for row in values["map"]:
        if not is_used(row[0], coded, True):
            return "the map has marker %d, but %s" % (row[0], ids_in_words(coded, allow_id0))
    return None


def detector_reason(values):
    """None when a detector can be made of the values (name: value), else one line that says why not."""
    outer_mm10, line_mm10 = values["outer_mm10"], values["line_mm10"]
    try:
        LARICS3.scaled(outer_mm10, line_mm10)
    except ValueError as error:
        return "line_mm10 = %d does not suit outer_mm10 = %d: %s" % (line_mm10, outer_mm10, error)
    wide_mm = line_mm(line_mm10, outer_mm10)
    if wide_mm is not None and not _LINE_LEAST_MM <= wide_mm <= _LINE_MOST_MM:
        return "line_mm10 = %d is not within %d and %d for outer_mm10 = %d" % (
            line_mm10,
            -(-_LINE_LEAST_MM * outer_mm10 // 150),
            _LINE_MOST_MM * outer_mm10 // 150,
            outer_mm10,
        )
    return _radius_reason(values)


def _radius_reason(values):
    low, high = values["radius_min_px"], values["radius_max_px"]
    width, height = values["width"], values["height"]
    if low >= high:
        return "radius_min_px = %d is not below radius_max_px = %d" % (low, high)
    if 2 * low >= min(width, height):
        return "a ring of radius_min_px = %d does not fit a frame of %dx%d" % (low, width, height)
    return None


def camera_reason(values):
    """None when the values (name: value) make a camera, else one line that says why not."""
    ceiling_mm10, lens_mm10 = values["ceiling_mm10"], values["camera_z_mm10"]
    if ceiling_mm10 and not 0 < ceiling_mm10 - lens_mm10 <= MAX_HEIGHT_MM10:
        return "ceiling_mm10 = %d is not above camera_z_mm10 = %d by up to %d" % (
            ceiling_mm10,
            lens_mm10,
            MAX_HEIGHT_MM10,
        )
    if not values["focal_q8"]:
        return None
    if values["focal_q8"] < _FOCAL_LEAST_Q8:
        return "focal_q8 = %d is neither 0 nor at least %d (20 px)" % (values["focal_q8"], _FOCAL_LEAST_Q8)
    try:
        calibrated_camera(values["width"], values["height"], values)
    except ValueError as error:
        return "focal_q8 = %d: %s" % (values["focal_q8"], error)
    return None
