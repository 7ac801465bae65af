"""Every message on the wire, defined once; the C header and docs/wire.md are generated from here.

A field is (name, code, unit, min, max, meaning). Codes are those of `struct`, little-endian: B b H h I i,
and "64s" for so many bytes. All 32-bit fields stay within 30 bits, so that a 32-bit board holds them
without allocating; counters wrap to 0 after COUNT_MAX. A value outside min..max is never sent, and a
receiver refuses the message. What the codes mean is told in `larics_host.wire_names`.

Rules for versions: byte 0 (version), byte 1 (type), bytes 2..3 (sequence) and the CRC-32 at the end keep
their places for ever. A type never changes its fields: what needs another field gets a new type number,
or VERSION goes up when most would change. Receivers skip and count unknown types and other versions.
Numbers below FIRST_COMMAND go from the camera to the vehicle, the others from the vehicle to the camera.
Each command begins with a token, which its answer returns; ODOMETRY has none, since nothing answers it.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

VERSION = const(1)
FIRST_COMMAND = const(64)
COUNT_MAX = const(0x3FFFFFFF)

INFO = const(1)
MARKER = const(2)
POSE = const(3)
STATUS = const(4)
ACK = const(5)
NACK = const(6)
SETTING = const(7)
RAW_HEADER = const(8)
RAW_CHUNK = const(9)
MOTION = const(10)
GET_INFO = const(64)
PING = const(65)
GET_SETTING = const(66)
SET_SETTING = const(67)
SAVE_SETTINGS = const(68)
GET_RAW = const(69)
GET_RAW_AGAIN = const(70)
RESTART = const(71)
ODOMETRY = const(72)

# MARKER.flags: the first five are Detection's
MARKER_ID_UNCERTAIN = const(1)
MARKER_UNCONFIRMED = const(2)
MARKER_TRACKED = const(4)
MARKER_BORDER = const(8)
MARKER_MODEL = const(16)
MARKER_NONE = const(32)
MARKER_NO_OFFSET = const(64)

ID_NONE = const(65535)
ROUTE_NONE = const(65535)
DIRECTION_NONE = const(36000)
SIGMA_UNKNOWN = const(65535)
AGE_UNKNOWN = const(65535)
WAY_UNKNOWN = const(65535)
PLACE_UNKNOWN = const(-COUNT_MAX)
HEADING_UNKNOWN = const(36000)
TIME_UNKNOWN = const(COUNT_MAX)
RATE_UNKNOWN = const(65535)
GREY_UNKNOWN = const(65535)

LOST = const(0)
COASTING = const(1)
TRACKING = const(2)
CARRIED = const(3)

# MOTION.state
MOTION_NONE = const(0)
MOTION_INTERPOLATED = const(1)
MOTION_EXTRAPOLATED = const(2)

# ODOMETRY.flags
ODOMETRY_SLIP = const(1)
ODOMETRY_STANDING = const(2)

SETTING_VALUES = const(8)  # how many values one SETTING or SET_SETTING carries
RAW_CHUNK_BYTES = const(64)
RAW_PIXELS_MOST = const(505)  # of a chunk: a byte for the first, a bit for each other one
RAW_STRIP = const(16)  # columns

# GET_RAW.window
RAW_WHOLE = const(0)
RAW_MARKERS = const(1)

# RAW_CHUNK.coding: the Rice parameter 0..7, or
RAW_PLAIN = const(8)

# NACK.reason
NACK_UNKNOWN_KEY = const(1)
NACK_RANGE = const(2)
NACK_LENGTH = const(3)
NACK_LIST_ORDER = const(4)
NACK_CONFLICT = const(5)
NACK_STORAGE = const(6)
NACK_BUSY = const(7)
NACK_NO_FRAME = const(8)
NACK_TRANSFER = const(9)
NACK_PIXELS = const(10)
NACK_TOKEN = const(11)
NACK_BOOT = const(12)
NACK_UNKNOWN_COMMAND = const(13)
NACK_MEMORY = const(14)

# STATUS.last_fault, and the bits of STATUS.active_faults
FAULT_CAMERA_TIMEOUT = const(1)
FAULT_CAMERA_RESET = const(2)
FAULT_UART_WRITE = const(3)
FAULT_SETTINGS_MISSING = const(4)
FAULT_SETTINGS_CORRUPT = const(5)
FAULT_SETTINGS_VERSION = const(6)
FAULT_STORAGE = const(7)
FAULT_DETECT = const(8)
FAULT_MEMORY = const(9)
FAULT_SAVE_INTERRUPTED = const(10)
FAULT_WATCHDOG = const(11)
FAULT_SAFE_MODE = const(12)
FAULT_CAMERA = const(13)
FAULT_COMMAND = const(14)
FAULT_LOOP = const(15)
FAULT_MARKER_UNKNOWN = const(16)
FAULT_MARKER_HEIGHT = const(17)
FAULT_MARKER_PLACE = const(18)
FAULT_ROUTE = const(19)
FAULT_CAMERA_FROZEN = const(20)
FAULT_CAMERA_DARK = const(21)
FAULT_CAMERA_WHITE = const(22)
FAULT_ODOMETRY = const(23)

_TOKEN = ("token", "H", "", 0, 65535, "returned by the answer; a retry repeats it, a new command does not")
_FRAME = ("frame", "I", "", 0, COUNT_MAX, "number of the camera frame, wraps to 0 after 2**30 - 1")
_FAR = const(0x1FFFFFFF)  # of odometry: 53 km, so that a difference stays within 30 bits
_AGE = ("age_us", "I", "us", 0, COUNT_MAX, "from the middle of the exposure to the start of sending")


def _values(code, low, high, meaning):
    return tuple(("value%d" % k, code, "", low, high, meaning) for k in range(SETTING_VALUES))


_PART = (
    ("key", "B", "", 0, 255, "number of the setting"),
    ("first", "H", "", 0, 65535, "index of value0 within a list; 0 for single values"),
    ("count", "H", "", 0, 65535, "length of the whole list; 1 for single values"),
) + _values("i", -COUNT_MAX, COUNT_MAX, "value of index first + k; 0 where there is none")

# (name, type number, meaning, fields)
MESSAGES = (
    (
        "INFO",
        INFO,
        "who is speaking: at start and as answer to GET_INFO",
        (
            ("token", "H", "", 0, 65535, "of GET_INFO; 0 at start"),
            ("boot", "H", "", 0, 65535, "drawn at random at each start; RESTART needs it"),
            ("version_major", "B", "", 0, 255, "version of the firmware"),
            ("version_minor", "B", "", 0, 255, "version of the firmware"),
            ("version_patch", "B", "", 0, 255, "version of the firmware"),
            ("width", "H", "px", 0, 65535, "frame width"),
            ("height", "H", "px", 0, 65535, "frame height"),
            ("settings", "B", "", 0, 255, "highest key of a setting"),
            ("board", "16s", "", 0, 255, "board name, ASCII, padded with 0"),
            ("unique_id", "12s", "", 0, 255, "unique ID of the processor, padded with 0"),
        ),
    ),
    (
        "MARKER",
        MARKER,
        "one marker in one processed frame; sent with count 0 when the frame has none",
        (
            _FRAME,
            _AGE,
            ("flags", "H", "", 0, 65535, "sum of MARKER flags; others may follow and are ignored"),
            ("id", "H", "", 0, 65535, "marker ID, or 65535 for none or uncertain"),
            ("index", "B", "", 0, 254, "which of the markers of this frame, 0..count-1; 0 when count is 0"),
            ("count", "B", "", 0, 255, "number of markers in this frame"),
            ("x_mm10", "i", "0.1 mm", -1000000, 1000000, "marker centre minus vehicle origin, forward"),
            ("y_mm10", "i", "0.1 mm", -1000000, 1000000, "the same, to the left"),
            ("z_mm10", "i", "0.1 mm", -1000000, 1000000, "the same, up"),
            ("heading_cdeg", "H", "0.01 deg", 0, 35999, "orientation line, vehicle frame, ccw from above"),
            ("margin", "B", "", 0, 255, "how far the weakest decision is from its limit"),
            ("radius_q8", "H", "1/256 px", 0, 65535, "outer ring in the image; 65535 for that and more"),
            ("sigma_q12", "H", "1/4096 px", 0, 65535, "standard deviation of the centre; 65535 unknown"),
            ("sigma_mdeg", "H", "0.001 deg", 0, 65535, "standard deviation of the heading; 65535 unknown"),
        ),
    ),
    (
        "POSE",
        POSE,
        "the vehicle in the map, once for each processed frame when there is a map",
        (
            _FRAME,
            _AGE,
            ("marker_age_ms", "H", "ms", 0, 65535, "since the last marker it rests on; 65535 none, or more"),
            ("state", "B", "", 0, 3, "POSE state"),
            ("id", "H", "", 0, 65535, "that marker, 65535 for none"),
            ("x_mm10", "i", "0.1 mm", -COUNT_MAX, COUNT_MAX, "vehicle origin, map frame; unknown when LOST"),
            ("y_mm10", "i", "0.1 mm", -COUNT_MAX, COUNT_MAX, "vehicle origin, map frame; unknown when LOST"),
            ("heading_cdeg", "H", "0.01 deg", 0, 36000, "vehicle's x axis, map frame, ccw; 36000 unknown"),
            ("sigma_x_mm10", "H", "0.1 mm", 0, 65535, "standard deviation of x; 65535 unknown"),
            ("sigma_y_mm10", "H", "0.1 mm", 0, 65535, "standard deviation of y; 65535 unknown"),
            ("correlation_q14", "h", "1/16384", -16384, 16384, "of the errors of x and y; 0 if unknown"),
            ("sigma_cdeg", "H", "0.01 deg", 0, 65535, "standard deviation of the heading; 65535 unknown"),
            ("way_mm", "H", "mm", 0, 65535, "driven since that marker, by odometry; 65535 unknown, or more"),
            ("route_position", "H", "", 0, 65535, "index in the route of the marker reached; 65535 none"),
            ("next_cdeg", "H", "0.01 deg", 0, 36000, "direction to go on, vehicle frame; 36000 none"),
        ),
    ),
    (
        "STATUS",
        STATUS,
        "health, once a second; counters since start",
        (
            ("version_major", "B", "", 0, 255, "version of the firmware"),
            ("version_minor", "B", "", 0, 255, "version of the firmware"),
            ("version_patch", "B", "", 0, 255, "version of the firmware"),
            ("boot", "H", "", 0, 65535, "as in INFO"),
            ("uptime_s", "I", "s", 0, COUNT_MAX, "time since start"),
            ("frames", "I", "", 0, COUNT_MAX, "frames processed"),
            ("missed", "I", "", 0, COUNT_MAX, "camera frames not processed, because a newer one was there"),
            ("detections", "I", "", 0, COUNT_MAX, "markers reported"),
            ("rejects", "I", "", 0, COUNT_MAX, "candidates refused"),
            ("drops", "I", "", 0, COUNT_MAX, "measurements replaced by newer ones before they were sent"),
            ("crc_errors", "I", "", 0, COUNT_MAX, "received frames with a wrong CRC"),
            ("line_errors", "I", "", 0, COUNT_MAX, "received frames refused for any other reason"),
            ("faults", "I", "", 0, COUNT_MAX, "number of faults"),
            ("last_fault", "B", "", 0, 255, "code of the last fault, 0 for none"),
            ("active_faults", "I", "", 0, COUNT_MAX, "faults that last: bit n stands for code n"),
            ("state", "B", "", 0, 3, "POSE state; without a map, of the marker"),
            ("exposure_us", "I", "us", 0, COUNT_MAX, "exposure time"),
            ("gain_cdb", "H", "0.01 dB", 0, 65535, "camera gain"),
            ("grey_mean", "H", "", 0, 65535, "mean grey of the last frame, 0..255; 65535 without one"),
            ("rate_chz", "H", "0.01 Hz", 0, 65535, "frames processed a second; 65535 not yet known"),
            ("frame_us", "I", "us", 0, COUNT_MAX, "mean time from frame to frame in this second, if any"),
            ("detect_us", "I", "us", 0, COUNT_MAX, "mean time of a detection in this second, if any"),
            ("latency_us", "I", "us", 0, COUNT_MAX, "longest time from capture to sending of it, if any"),
            ("free_bytes", "I", "", 0, COUNT_MAX, "free heap after a collection, measured each 30 s"),
            ("unanswered", "I", "", 0, COUNT_MAX, "commands left unanswered, because too many came at once"),
            ("clamped", "I", "", 0, COUNT_MAX, "values reported as the nearest that their field can hold"),
            ("odometry_used", "I", "", 0, COUNT_MAX, "ODOMETRY messages taken into use"),
            ("odometry_refused", "I", "", 0, COUNT_MAX, "those that came twice or out of order"),
            ("odometry_stale", "I", "", 0, COUNT_MAX, "those that came too late to be of use"),
            ("odometry_jumps", "I", "", 0, COUNT_MAX, "times that it began anew: reset, jump, other clock"),
        ),
    ),
    (
        "ACK",
        ACK,
        "the command was carried out; after the data it asked for",
        (_TOKEN, ("command", "B", "", 0, 255, "type number of the command")),
    ),
    (
        "NACK",
        NACK,
        "the command was refused and changed nothing",
        (
            _TOKEN,
            ("command", "B", "", 0, 255, "type number of the command"),
            ("reason", "B", "", 0, 255, "NACK reason"),
            ("detail", "B", "", 0, 255, "key of the setting in question, else 0"),
        ),
    ),
    ("SETTING", SETTING, "up to eight values of one setting: answer to GET_SETTING", (_TOKEN,) + _PART),
    (
        "RAW_HEADER",
        RAW_HEADER,
        "what the raw frame is, or the window of it, whose chunks follow",
        (
            ("token", "H", "", 0, 65535, "of GET_RAW; names the transfer"),
            _FRAME,
            ("width", "H", "px", 1, 65535, "frame width"),
            ("height", "H", "px", 1, 65535, "frame height"),
            ("left", "H", "px", 0, 65535, "first column of the window"),
            ("top", "H", "px", 0, 65535, "first row of the window"),
            ("columns", "H", "px", 1, 65535, "width of the window; that of the frame when it is whole"),
            ("rows", "H", "px", 1, 65535, "height of the window"),
            ("crc_low", "H", "", 0, 65535, "CRC-32 of the window's pixels row by row, low half"),
            ("crc_high", "H", "", 0, 65535, "CRC-32 of the window's pixels, high half"),
        ),
    ),
    (
        "RAW_CHUNK",
        RAW_CHUNK,
        "pixels of a raw frame, packed without loss; sent when the line is otherwise idle",
        (
            ("token", "H", "", 0, 65535, "of GET_RAW"),
            ("first", "I", "", 0, COUNT_MAX, "number of the first pixel, in strips of 16 columns"),
            ("count", "H", "", 1, RAW_PIXELS_MOST, "number of pixels"),
            ("coding", "B", "", 0, RAW_PLAIN, "Rice parameter 0..7, or 8: plain bytes"),
            ("data", "64s", "", 0, 255, "the pixels; 0 after the last one"),
        ),
    ),
    (
        "MOTION",
        MOTION,
        "the vehicle's odometry at the exposure of a processed frame, as the camera used it; once it has any",
        (
            _FRAME,
            ("state", "B", "", 0, 2, "MOTION state"),
            ("epoch", "B", "", 0, 255, "of the ODOMETRY used"),
            ("x_mm10", "i", "0.1 mm", -_FAR, _FAR, "odometry frame, in the middle of the exposure"),
            ("y_mm10", "i", "0.1 mm", -_FAR, _FAR, "the same, to the left"),
            ("heading_cdeg", "H", "0.01 deg", 0, 35999, "the same, counterclockwise"),
            ("way_mm10", "I", "0.1 mm", 0, COUNT_MAX, "driven since the start, to and fro, wraps to 0"),
            ("turn_cdeg", "I", "0.01 deg", 0, COUNT_MAX, "turned since the start, to and fro, wraps to 0"),
            ("odometry_age_us", "I", "us", 0, COUNT_MAX, "from the newest odometry to the exposure; 0: none"),
        ),
    ),
    ("GET_INFO", GET_INFO, "answered by INFO, then ACK", (_TOKEN,)),
    ("PING", PING, "answered by ACK", (_TOKEN,)),
    (
        "GET_SETTING",
        GET_SETTING,
        "answered by SETTING, one for each eight values, then ACK",
        (_TOKEN, ("key", "B", "", 0, 255, "number of the setting")),
    ),
    (
        "SET_SETTING",
        SET_SETTING,
        "up to eight values; a list takes effect with its last part",
        (_TOKEN,) + _PART,
    ),
    ("SAVE_SETTINGS", SAVE_SETTINGS, "writes all settings to flash", (_TOKEN,)),
    (
        "GET_RAW",
        GET_RAW,
        "answered by RAW_HEADER and ACK, then all RAW_CHUNKs",
        (_TOKEN, ("window", "B", "", 0, RAW_MARKERS, "window of the frame")),
    ),
    (
        "GET_RAW_AGAIN",
        GET_RAW_AGAIN,
        "sends pixels again, of the frame still kept",
        (
            _TOKEN,
            ("transfer", "H", "", 0, 65535, "token of the GET_RAW"),
            ("first", "I", "", 0, COUNT_MAX, "number of the first pixel, as in RAW_CHUNK"),
            ("count", "I", "", 1, COUNT_MAX, "number of pixels"),
        ),
    ),
    (
        "RESTART",
        RESTART,
        "restarts after its ACK was sent",
        (_TOKEN, ("boot", "H", "", 0, 65535, "from INFO or STATUS, so that a retry cannot restart twice")),
    ),
    (
        "ODOMETRY",
        ODOMETRY,
        "where the vehicle is by its wheels, up to 100 times a second; not answered",
        (
            ("time_us", "I", "us", 0, COUNT_MAX, "when it was sampled, on the vehicle's clock; wraps to 0"),
            ("age_us", "I", "us", 0, COUNT_MAX, "from then to the start of sending"),
            ("x_mm10", "i", "0.1 mm", -_FAR, _FAR, "odometry frame; cumulative since its start"),
            ("y_mm10", "i", "0.1 mm", -_FAR, _FAR, "the same, to the left"),
            ("heading_cdeg", "H", "0.01 deg", 0, 35999, "vehicle's x axis in that frame, counterclockwise"),
            ("epoch", "B", "", 0, 255, "another one after each jump or reset of x, y, heading or time_us"),
            ("flags", "B", "", 0, 255, "sum of ODOMETRY flags; others may follow and are ignored"),
        ),
    ),
)
