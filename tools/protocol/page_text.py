"""The wire's definition as people read it: tables, examples, and the share of the line."""

import re

from larics.device.outbox import Uptime
from larics.settings import fields as setting_fields
from larics.wire import codec, messages
from larics_host import wire_names as codes

# a usual message of each kind, to tell how long it is in other encodings
EXAMPLES = (
    (
        "MARKER",
        {"frame": 123456, "age_us": 16650, "flags": messages.MARKER_TRACKED, "id": 3, "count": 1,
         "x_mm10": 1234, "y_mm10": -567, "z_mm10": 25000, "heading_cdeg": 9005, "margin": 200,
         "radius_q8": 7745, "sigma_q12": 41, "sigma_mdeg": 12},
    ),
    (
        "POSE",
        {"frame": 123456, "age_us": 16650, "marker_age_ms": 16, "state": messages.TRACKING, "id": 3,
         "x_mm10": -123456, "y_mm10": 65432, "heading_cdeg": 35999, "sigma_x_mm10": 35, "sigma_y_mm10": 31,
         "correlation_q14": -2048, "sigma_cdeg": 120, "way_mm": messages.WAY_UNKNOWN, "route_position": 12,
         "next_cdeg": 27000},
    ),
    (
        "STATUS",
        {"version_major": 1, "boot": 1, "uptime_s": 86400, "frames": 123456, "missed": 12,
         "detections": 123450, "rejects": 123, "state": messages.TRACKING, "exposure_us": 5000,
         "gain_cdb": 600, "grey_mean": 110, "rate_chz": 6000, "frame_us": 16667, "detect_us": 9000,
         "latency_us": 25000, "free_bytes": 123456},
    ),
)  # fmt: skip
NOTHING_SEEN = (
    "MARKER",
    {
        "frame": 123457,
        "age_us": 16650,
        "flags": messages.MARKER_NONE,
        "id": messages.ID_NONE,
        "sigma_q12": messages.SIGMA_UNKNOWN,
        "sigma_mdeg": messages.SIGMA_UNKNOWN,
    },
)


def table(head, rows):
    """A table of Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def fields_table(fields):
    """The fields of a message; value0..value7 are one row."""
    rows = []
    for name, code, unit, low, high, meaning in fields:
        if re.fullmatch(r"value[1-9]", name):
            continue
        bytes_each = {"B": 1, "H": 2, "h": 2, "I": 4, "i": 4}.get(code) or int(code[:-1])
        kind = {"B": "u8", "H": "u16", "h": "i16", "I": "u32", "i": "i32"}.get(code) or "bytes"
        allowed = "%d..%d" % (low, high)
        if name == "value0":
            name, bytes_each = "value0 ... value7", 8 * bytes_each
            kind += " x 8"
        rows.append((name, kind, bytes_each, unit, allowed, meaning))
    return table(("field", "type", "bytes", "unit", "range", "meaning"), rows)


def overview():
    """All messages with their sizes."""
    rows = []
    for name, number, meaning, _ in messages.MESSAGES:
        way = "vehicle -> camera" if number >= messages.FIRST_COMMAND else "camera -> vehicle"
        rows.append((number, name, way, codec.frame_size(number), meaning))
    return table(("type", "name", "direction", "bytes on the line", "meaning"), rows)


def examples(*named):
    """[(type number, values)] of (name, {field: value}); what is not given is 0."""
    found = []
    for name, given in named:
        number = messages.__dict__[name]
        found.append((number, [given.get(field[0], 0) for field in codec.fields(number)]))
    return found


def lines_of_text():
    """The EXAMPLES as NmeaEncoder writes them, and a frame without a marker."""
    from larics.wire.nmea import NmeaEncoder  # by now with its indices written

    encoder = NmeaEncoder()
    lines = []
    for number, values in examples(*EXAMPLES, NOTHING_SEEN):
        size = encoder.encode(number, values)
        lines.append(bytes(encoder.buffer[:size]).decode())
    return lines


def rates():
    """Share of the line at 60 frames/s, ten bits a byte."""
    from larics.wire.mavlink import MavlinkEncoder  # by now with its indices written

    size = codec.frame_size
    marker, pose, status = size(messages.MARKER), size(messages.POSE), size(messages.STATUS)
    text = [len(line) for line in lines_of_text()]
    encoder = MavlinkEncoder(Uptime(), target="ardupilot")
    mavlink = [encoder.encode(number, values) for number, values in examples(*EXAMPLES)]
    cases = (
        ("MARKER", marker * 60),
        ("MARKER, POSE, STATUS", (marker + pose) * 60 + status),
        ("three MARKERs, POSE, STATUS", (3 * marker + pose) * 60 + status),
        ("MARKER, POSE, STATUS, rate_divider 3", (marker + pose) * 20 + status),
        ("MARKER, POSE, MOTION, STATUS", (marker + pose + size(messages.MOTION)) * 60 + status),
        ("received: ODOMETRY, 100 a second", size(messages.ODOMETRY) * 100),
        ("nmea: MARKER, POSE, STATUS", (text[0] + text[1]) * 60 + text[2]),
        ("mavlink: LANDING_TARGET, HEARTBEAT", mavlink[0] * 60 + mavlink[2]),
        ("mavlink: with VISION_POSITION_ESTIMATE", (mavlink[0] + mavlink[1]) * 60 + mavlink[2]),
    )
    rows = []
    for title, bytes_a_second in cases:
        shares = ["%.1f %%" % (bytes_a_second * 10 / baud * 100) for baud in (115200, 921600)]
        rows.append((title, bytes_a_second, *shares))
    return table(("at 60 frames/s", "bytes/s", "of 115200 baud", "of 921600 baud"), rows)


def settings_table():
    """All settings of the camera."""
    rows = []
    for field in setting_fields.FIELDS:
        default = field.default
        if field.kind == "bool":
            default = "true" if default else "false"
        elif field.kind in ("list", "ranges", "table"):
            default = "empty"
        rebuilds = codes.rebuilds_text(field.rebuilds)
        rows.append((field.key, field.name, default, field.range_text(), field.unit, rebuilds, field.meaning))
    return table(("key", "name", "default", "allowed", "unit", "rebuilds", "meaning"), rows)


def document_parts():
    """{mark: text} of the generated parts of docs/wire.md."""
    parts = {"overview": overview(), "rates": rates(), "settings": settings_table()}
    parts["text"] = "\n".join("    " + line.rstrip() for line in lines_of_text())
    blocks = []
    for name, number, meaning, fields in messages.MESSAGES:
        blocks.append("### %s (%d): %s\n\n%s" % (name, number, meaning, fields_table(fields)))
    parts["messages"] = "\n\n".join(blocks)
    blocks = []
    for title, entries in codes.ENUMS:
        rows = [(number, name, meaning) for name, number, meaning in entries]
        blocks.append("### %s\n\n%s" % (title, table(("value", "name", "meaning"), rows)))
    parts["codes"] = "\n\n".join(blocks)
    return parts
