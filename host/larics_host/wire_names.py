"""What the codes in messages mean, for people: documentation, C header, and the PC's displays.

A board never imports this: the numbers are in `larics.wire.messages`.
"""

from __future__ import annotations

from larics.wire import messages as m

TEXT_FIELDS = ("board",)  # of the byte fields, those that are text

# field -> the number in it that means "unknown" or "none"
UNKNOWN = {
    "id": m.ID_NONE,
    "sigma_q12": m.SIGMA_UNKNOWN,
    "sigma_mdeg": m.SIGMA_UNKNOWN,
    "sigma_x_mm10": m.SIGMA_UNKNOWN,
    "sigma_y_mm10": m.SIGMA_UNKNOWN,
    "sigma_cdeg": m.SIGMA_UNKNOWN,
    "marker_age_ms": m.AGE_UNKNOWN,
    "way_mm": m.WAY_UNKNOWN,
    "route_position": m.ROUTE_NONE,
    "next_cdeg": m.DIRECTION_NONE,
    "x_mm10": m.PLACE_UNKNOWN,
    "y_mm10": m.PLACE_UNKNOWN,
    "heading_cdeg": m.HEADING_UNKNOWN,
    "grey_mean": m.GREY_UNKNOWN,
    "rate_chz": m.RATE_UNKNOWN,
    "frame_us": m.TIME_UNKNOWN,
    "detect_us": m.TIME_UNKNOWN,
    "latency_us": m.TIME_UNKNOWN,
}
# flag of a MARKER -> fields that are unknown then, and 0 on the wire
UNKNOWN_BY_FLAG = {
    m.MARKER_NO_OFFSET: ("x_mm10", "y_mm10", "z_mm10"),
    m.MARKER_NONE: ("x_mm10", "y_mm10", "z_mm10", "heading_cdeg", "margin", "radius_q8"),
}

# (group, ((name, number, meaning), ...))
ENUMS = (
    (
        "MARKER flag",
        (
            ("MARKER_ID_UNCERTAIN", m.MARKER_ID_UNCERTAIN, "pose certain, ID not: id is 65535"),
            ("MARKER_UNCONFIRMED", m.MARKER_UNCONFIRMED, "ID not yet agreed on by enough frames"),
            ("MARKER_TRACKED", m.MARKER_TRACKED, "found around the prediction, without a search"),
            ("MARKER_BORDER", m.MARKER_BORDER, "plate cut off by the border of the frame"),
            ("MARKER_MODEL", m.MARKER_MODEL, "accepted by the blur-model reader, not by the direct reader"),
            ("MARKER_NONE", m.MARKER_NONE, "no marker seen in this frame: count 0, id 65535, measures 0"),
            ("MARKER_NO_OFFSET", m.MARKER_NO_OFFSET, "x, y, z unknown and 0: the camera is not calibrated"),
        ),
    ),
    (
        "POSE state",
        (
            ("LOST", m.LOST, "no usable pose; x, y, heading and sigma are unknown"),
            ("COASTING", m.COASTING, "predicted from earlier markers"),
            ("TRACKING", m.TRACKING, "measured in this frame"),
            ("CARRIED", m.CARRIED, "carried on by the vehicle's odometry from earlier markers"),
        ),
    ),
    (
        "MOTION state",
        (
            ("MOTION_NONE", m.MOTION_NONE, "no odometry for this frame; the other fields tell the last one"),
            ("MOTION_INTERPOLATED", m.MOTION_INTERPOLATED, "between two ODOMETRY messages"),
            ("MOTION_EXTRAPOLATED", m.MOTION_EXTRAPOLATED, "after the last one"),
        ),
    ),
    (
        "ODOMETRY flag",
        (
            ("ODOMETRY_SLIP", m.ODOMETRY_SLIP, "the vehicle suspects that a wheel slips"),
            ("ODOMETRY_STANDING", m.ODOMETRY_STANDING, "the vehicle stands, and knows it"),
        ),
    ),
    (
        "Special value",
        (
            ("ID_NONE", m.ID_NONE, "id: none, or uncertain"),
            ("ROUTE_NONE", m.ROUTE_NONE, "route_position: no route, or not on it"),
            ("DIRECTION_NONE", m.DIRECTION_NONE, "next_cdeg: no next direction"),
            ("SIGMA_UNKNOWN", m.SIGMA_UNKNOWN, "sigma: unknown or larger than can be told"),
            ("AGE_UNKNOWN", m.AGE_UNKNOWN, "marker_age_ms: no marker yet, or older than can be told"),
            ("WAY_UNKNOWN", m.WAY_UNKNOWN, "way_mm: no odometry, or longer than can be told"),
            ("PLACE_UNKNOWN", m.PLACE_UNKNOWN, "x, y of POSE: LOST"),
            ("HEADING_UNKNOWN", m.HEADING_UNKNOWN, "heading of POSE: LOST"),
            (
                "TIME_UNKNOWN",
                m.TIME_UNKNOWN,
                "times of STATUS: no frame in this second, or longer",
            ),
            ("RATE_UNKNOWN", m.RATE_UNKNOWN, "rate: no second has passed yet"),
            ("GREY_UNKNOWN", m.GREY_UNKNOWN, "grey_mean: no frame yet"),
        ),
    ),
    (
        "GET_RAW window",
        (
            ("RAW_WHOLE", m.RAW_WHOLE, "the whole frame"),
            ("RAW_MARKERS", m.RAW_MARKERS, "around the markers found in it; the whole frame without one"),
        ),
    ),
    (
        "RAW_CHUNK coding",
        (("RAW_PLAIN", m.RAW_PLAIN, "bytes as they are, at most 64; 0..7 are Rice parameters"),),
    ),
    (
        "NACK reason",
        (
            ("NACK_UNKNOWN_KEY", m.NACK_UNKNOWN_KEY, "no setting has this key"),
            ("NACK_RANGE", m.NACK_RANGE, "a value is outside its range"),
            ("NACK_LENGTH", m.NACK_LENGTH, "wrong number of values for this setting"),
            (
                "NACK_LIST_ORDER",
                m.NACK_LIST_ORDER,
                "a list's parts came out of order: start again at first 0",
            ),
            ("NACK_CONFLICT", m.NACK_CONFLICT, "valid alone, but not together with other settings"),
            ("NACK_STORAGE", m.NACK_STORAGE, "the settings could not be written; the old file is kept"),
            ("NACK_BUSY", m.NACK_BUSY, "not now: try again"),
            ("NACK_NO_FRAME", m.NACK_NO_FRAME, "no frame yet, or no memory for a copy of it"),
            ("NACK_TRANSFER", m.NACK_TRANSFER, "this raw frame is not kept any more"),
            ("NACK_PIXELS", m.NACK_PIXELS, "this raw frame has no such pixels"),
            ("NACK_TOKEN", m.NACK_TOKEN, "this token was just used for another command"),
            ("NACK_BOOT", m.NACK_BOOT, "the boot number is not the current one: already restarted"),
            ("NACK_UNKNOWN_COMMAND", m.NACK_UNKNOWN_COMMAND, "this firmware does not have this command"),
            (
                "NACK_MEMORY",
                m.NACK_MEMORY,
                "the board has no memory for this value; the one before is in use",
            ),
        ),
    ),
    (
        "Fault",
        (
            ("FAULT_CAMERA_TIMEOUT", m.FAULT_CAMERA_TIMEOUT, "no frame within the time limit"),
            ("FAULT_CAMERA_RESET", m.FAULT_CAMERA_RESET, "the camera was started again"),
            ("FAULT_UART_WRITE", m.FAULT_UART_WRITE, "the line took fewer bytes than given, or none"),
            ("FAULT_SETTINGS_MISSING", m.FAULT_SETTINGS_MISSING, "no settings file: defaults in use"),
            (
                "FAULT_SETTINGS_CORRUPT",
                m.FAULT_SETTINGS_CORRUPT,
                "settings file damaged: the previous one in use, or defaults",
            ),
            (
                "FAULT_SETTINGS_VERSION",
                m.FAULT_SETTINGS_VERSION,
                "settings of another version: what is valid is used",
            ),
            ("FAULT_STORAGE", m.FAULT_STORAGE, "flash full or read-only"),
            ("FAULT_DETECT", m.FAULT_DETECT, "exception in the detection of a frame"),
            (
                "FAULT_MEMORY",
                m.FAULT_MEMORY,
                "memory ran out; while it lasts: no second opinion, rings from 15 or 22 px, or no detector",
            ),
            (
                "FAULT_SAVE_INTERRUPTED",
                m.FAULT_SAVE_INTERRUPTED,
                "power lost while saving: previous settings in use",
            ),
            ("FAULT_WATCHDOG", m.FAULT_WATCHDOG, "started by the watchdog"),
            ("FAULT_SAFE_MODE", m.FAULT_SAFE_MODE, "safe mode: three fast resets, or the button"),
            ("FAULT_CAMERA", m.FAULT_CAMERA, "the camera driver reported an error"),
            ("FAULT_COMMAND", m.FAULT_COMMAND, "a command ended in an exception"),
            ("FAULT_LOOP", m.FAULT_LOOP, "exception outside of camera, detection and commands"),
            ("FAULT_MARKER_UNKNOWN", m.FAULT_MARKER_UNKNOWN, "a marker that is not in the map"),
            ("FAULT_MARKER_HEIGHT", m.FAULT_MARKER_HEIGHT, "a marker whose size contradicts its height"),
            (
                "FAULT_MARKER_PLACE",
                m.FAULT_MARKER_PLACE,
                "a marker where it cannot be: misread, moved, or the vehicle was moved",
            ),
            ("FAULT_ROUTE", m.FAULT_ROUTE, "a wrong, missing or unexpected marker on the route"),
            (
                "FAULT_CAMERA_FROZEN",
                m.FAULT_CAMERA_FROZEN,
                "the camera serves the same picture again and again",
            ),
            ("FAULT_CAMERA_DARK", m.FAULT_CAMERA_DARK, "nothing but black: no light, or the lens is covered"),
            ("FAULT_CAMERA_WHITE", m.FAULT_CAMERA_WHITE, "nothing but white: far too much light"),
            (
                "FAULT_ODOMETRY",
                m.FAULT_ODOMETRY,
                "odometry contradicts the markers (unit, sign, axis?): it is ignored",
            ),
        ),
    ),
)


def name_of(group: str, number: int) -> str:
    """The name of a number in one of the ENUMS, without its prefix, lower case; the number if unknown."""
    for title, entries in ENUMS:
        if title == group:
            for name, value, _ in entries:
                if value == number:
                    return name.split("_", 1)[-1].lower().replace("_", " ")
    return str(number)


# of the bits of Field.rebuilds, from the lowest on
_PARTS = ("detector", "locator", "navigator", "exposure", "output", "after a restart")


def rebuilds_text(parts: int) -> str:
    """What a change of a setting makes anew: "detector, exposure", "after a restart", "nothing"."""
    return ", ".join(name for bit, name in enumerate(_PARTS) if parts >> bit & 1) or "nothing"
