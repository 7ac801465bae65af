"""Writes what is derived from the wire's definition: the layouts that a board reads, the C library's tables,
the tables of docs/wire.md and README.md, the indices of fields that the board's modules use, the host's named
records, and the definitions of the same messages for ROS 2.

    python tools/make_protocol.py [--check]

Each target has a part between "generated: begin" and "generated: end" that is replaced. With --check
nothing is written and the exit code is 1 when something is stale. ROS_MESSAGES are made as whole files.

A module of shared/ or firmware/ that has such a part (INDICES) may use `_TYPE_FIELD`, the index of a field in
a message's values (`_MARKER_AGE_US`), and `_TYPE_FIELDS`, how many it has. They are written where they are
used, because MicroPython drops a `_NAME = const()` only within its module: there it costs no memory, and as
much as a number.
"""

import ast
import pathlib
import re
import struct
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "shared"))

from larics.device.outbox import Uptime  # noqa: E402
from larics.settings import fields as setting_fields  # noqa: E402
from larics.wire import codec as protocol  # noqa: E402
from larics.wire import messages  # noqa: E402
from larics_host import wire_names as codes  # noqa: E402
from larics_host.ros.wire_types import type_of, wire_structs  # noqa: E402

LAYOUTS = ROOT / "shared" / "larics" / "wire" / "layouts.py"
HEADER = ROOT / "firmware" / "vehicle" / "src" / "larics.h"
SOURCE = ROOT / "firmware" / "vehicle" / "src" / "larics_layout.c"
DOCUMENT = ROOT / "docs" / "wire.md"
README = ROOT / "README.md"
RECORDS = ROOT / "host" / "larics_host" / "connection" / "records.py"
ROS_MESSAGES = ROOT / "ros2" / "larics_msgs" / "msg"
INDICES = "# generated: begin indices (tools/make_protocol.py)", "# generated: end indices"

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

C_TYPES = {"B": "uint8_t", "H": "uint16_t", "h": "int16_t", "I": "uint32_t", "i": "int32_t"}
KINDS = {"B": "U8", "H": "U16", "h": "I16", "I": "U30", "i": "I30"}
NATURAL = {
    "B": (0, 255),
    "H": (0, 65535),
    "h": None,  # its range is always told
    "I": (0, messages.COUNT_MAX),
    "i": (-messages.COUNT_MAX, messages.COUNT_MAX),
}


SIZES = {code: struct.calcsize("<" + code) for code in NATURAL}


def layout_of(fields):
    """One entry of larics.wire.layouts.LAYOUTS."""
    sizes = [SIZES.get(field[1]) or int(field[1][:-1]) for field in fields]
    lows, highs = (tuple(field[place] for field in fields) for place in (3, 4))
    return "".join(field[1][-1] for field in fields).encode(), bytes(sizes), lows, highs, sum(sizes)


def layouts():
    """{type: entry} of the messages as they are defined now."""
    return {number: layout_of(fields) for _, number, _, fields in messages.MESSAGES}


def layouts_text():
    """They, as a dictionary of Python in lines of at most 110 characters."""
    lines = ["LAYOUTS = {"]
    for number, entry in layouts().items():
        text = textwrap.wrap("%d: %r," % (number, entry), 106, break_long_words=False)
        lines += ["    " + line for line in text]
    return "\n".join([*lines, "}"])


def members(fields):
    """The fields as C members (declaration, name, code, meaning); value0..value7 become one array."""
    found = []
    for name, code, unit, low, high, meaning in fields:
        if re.fullmatch(r"value[1-9]", name):
            continue
        comment = meaning
        if unit:
            comment += ", " + unit
        if code[-1] == "s":
            declaration = "uint8_t %s[%s]" % (name, code[:-1])
        elif name == "value0":
            declaration = "%s value[LARICS_SETTING_VALUES]" % C_TYPES[code]
        else:
            declaration = "%s %s" % (C_TYPES[code], name)
            if (low, high) != NATURAL[code]:
                comment += "; %d..%d" % (low, high)
        found.append((declaration, comment))
    return found


def c_header():
    marker_frame = protocol.frame_size(messages.MARKER)
    lines = [
        "#define LARICS_VERSION %d" % messages.VERSION,
        "#define LARICS_COUNT_MAX 0x%Xu /* counters wrap to 0 after it */" % messages.COUNT_MAX,
        "#define LARICS_FIRST_COMMAND %d" % messages.FIRST_COMMAND,
        "#define LARICS_SETTING_VALUES %d" % messages.SETTING_VALUES,
        "#define LARICS_RAW_CHUNK_BYTES %d" % messages.RAW_CHUNK_BYTES,
        "#define LARICS_MARKER_FRAME %d /* bytes of a MARKER on the line */" % marker_frame,
        "",
        "/* larics_message.type */",
    ]
    lines += ["#define LARICS_%s %d" % (name, number) for name, number, _, _ in messages.MESSAGES]
    for title, entries in codes.ENUMS:
        lines += ["", "/* %s */" % title]
        lines += ["#define LARICS_%s %d /* %s */" % entry for entry in entries]
    lines += ["", "/* keys of the settings */"]
    lines += ["#define LARICS_KEY_%s %d" % (field.name.upper(), field.key) for field in setting_fields.FIELDS]
    for name, _, meaning, fields in messages.MESSAGES:
        lines += ["", "/* %s */" % meaning, "typedef struct {"]
        lines += ["    %s; /* %s */" % member for member in members(fields)]
        lines += ["} larics_%s;" % name.lower()]
    lines += ["", "typedef struct {", "    uint8_t type;", "    uint16_t sequence;", "    union {"]
    lines += ["        larics_%s %s;" % (name.lower(), name.lower()) for name, _, _, _ in messages.MESSAGES]
    lines += ["    } as;", "} larics_message;"]
    return "\n".join(lines)


def c_tables():
    fields_rows, layouts, ranges = [], [], []
    for name, _, _, fields in messages.MESSAGES:
        size = protocol.frame_size(messages.__dict__[name]) - 10
        layouts.append("    {LARICS_%s, %d, %d, %d}," % (name, len(fields_rows), len(fields), size))
        for field, code, _, low, high, _ in fields:
            kind = KINDS.get(code) or code[:-1]
            member = re.sub(r"^value(\d)$", r"value[\1]", field)
            if code[-1] != "s" and (low, high) != NATURAL[code]:
                ranges.append("    {%d, %d, %d}, /* %s.%s */" % (len(fields_rows), low, high, name, field))
                kind += " | RANGED"
            fields_rows.append("    {%s, offsetof(larics_%s, %s)}," % (kind, name.lower(), member))
    if len(fields_rows) > 255:
        raise SystemExit("more than 255 fields: `first` and `range.field` need 16 bits")
    lines = ["static const field fields[] LARICS_IN_FLASH = {", *fields_rows, "};", ""]
    lines += ["static const larics_layout layouts[] LARICS_IN_FLASH = {", *layouts, "};", ""]
    lines += ["static const range ranges[] LARICS_IN_FLASH = {", *ranges, "};"]
    return "\n".join(lines)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def fields_table(fields):
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
    rows = []
    for name, number, meaning, _ in messages.MESSAGES:
        way = "vehicle -> camera" if number >= messages.FIRST_COMMAND else "camera -> vehicle"
        rows.append((number, name, way, protocol.frame_size(number), meaning))
    return table(("type", "name", "direction", "bytes on the line", "meaning"), rows)


def examples(*named):
    """[(type number, values)] of (name, {field: value}); what is not given is 0."""
    found = []
    for name, given in named:
        number = messages.__dict__[name]
        found.append((number, [given.get(field[0], 0) for field in protocol.fields(number)]))
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

    size = protocol.frame_size
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


def all_indices():
    """{"_TYPE_FIELD": index, "_TYPE_FIELDS": how many}, in the order of the table."""
    found = {}
    for name, _, _, fields in messages.MESSAGES:
        found["_%s_FIELDS" % name] = len(fields)
        for index, field in enumerate(fields):
            found["_%s_%s" % (name, field[0].upper())] = index
    return found


def indices_used(text):
    """The lines of constants for those of `all_indices` that a module's text uses."""
    used = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    return "\n".join("%s = const(%d)" % item for item in all_indices().items() if item[0] in used)


def _without_part(text, begin, end):
    head, _, rest = text.partition(begin)
    return head + rest.partition(end)[2]


def class_name(name):
    """RAW_HEADER -> RawHeader."""
    return "".join(word.capitalize() for word in name.split("_"))


def record_classes():
    """A NamedTuple for each message."""
    blocks = []
    for name, _, meaning, fields in messages.MESSAGES:
        lines = ["class %s(NamedTuple):" % class_name(name), '    """%s."""' % capital(meaning), ""]
        for field, code, unit, _, _, said in fields:
            if re.fullmatch(r"value[1-9]", field):
                lines.append("    %s: int" % field)
                continue
            kind = "str" if field in codes.TEXT_FIELDS else "bytes" if code[-1] == "s" else "int"
            said += ", " + unit if unit else ""
            if hasattr(tuple, field):
                said = "type: ignore[assignment]  # " + said
            lines.append("    %s: %s  # %s" % (field, kind, said))
        if fields[-1][0] == "value%d" % (messages.SETTING_VALUES - 1):
            first = len(fields) - messages.SETTING_VALUES
            lines += ["", "    @property", "    def values(self) -> tuple[int, ...]:"]
            lines += ['        """value0 and all after it."""', "        return self[%d:]" % first]
        blocks.append("\n".join(lines))
    rows = ["    messages.%s: %s," % (name, class_name(name)) for name, _, _, _ in messages.MESSAGES]
    return "\n\n\n".join([*blocks, "RECORDS = {\n%s\n}" % "\n".join(rows)])


def capital(text):
    return text[0].upper() + text[1:]


def replaced(text, content, begin, end):
    """`text` with what stands between the marks `begin` and `end` replaced by `content`."""
    head, mark, rest = text.partition(begin)
    old, end_mark, tail = rest.partition(end)
    if not mark or not end_mark:
        raise SystemExit("the marks %r and %r are missing" % (begin, end))
    return head + begin + "\n" + content + "\n" + end + tail


def targets():
    """(path, new text) of every file with a generated part; those that others are made with come first."""
    begin, end = "# generated: begin (tools/make_protocol.py)", "# generated: end"
    yield LAYOUTS, replaced(LAYOUTS.read_text(), layouts_text(), begin, end)
    protocol.LAYOUTS.update(layouts())  # for what follows
    for folder in ("shared", "firmware"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            text = path.read_text()
            if INDICES[0] in text:
                yield path, replaced(text, indices_used(_without_part(text, *INDICES)), *INDICES)
    begin, end = "/* generated: begin (tools/make_protocol.py) */", "/* generated: end */"
    yield HEADER, replaced(HEADER.read_text(), c_header(), begin, end)
    yield SOURCE, replaced(SOURCE.read_text(), c_tables(), begin, end)
    text = DOCUMENT.read_text()
    for name, content in document_parts().items():
        begin, end = "<!-- generated: begin %s -->" % name, "<!-- generated: end %s -->" % name
        text = replaced(text, "\n" + content + "\n", begin, end)
    yield DOCUMENT, text
    begin, end = "<!-- wire:begin -->", "<!-- wire:end -->"
    yield README, replaced(README.read_text(), "\n" + overview() + "\n", begin, end)
    begin, end = "# generated: begin (tools/make_protocol.py)", "# generated: end"
    yield RECORDS, replaced(RECORDS.read_text(), "\n\n" + record_classes() + "\n\n", begin, end)
    for name, number, meaning, _ in protocol.MESSAGES:
        yield ROS_MESSAGES / (type_of(name).split("/")[1] + ".msg"), ros_message(name, number, meaning)


def ros_message(name, number, meaning):
    """The text of a .msg file."""
    struct = wire_structs()[type_of(name)]
    lines = ["# %s (type %d of the wire): %s." % (name, number, meaning)]
    lines += [
        "# Generated by tools/make_protocol.py. What is not known is NaN, of an ID or a place in a list -1."
    ]
    return "\n".join([*lines, *struct.constants, *(field.line() for field in struct.fields)]) + "\n"


def main(arguments):
    check = "--check" in arguments
    stale = 0
    for path, text in targets():
        if path.exists() and path.read_text() == text:
            continue
        stale += 1
        if check:
            print("stale: %s (run: python tools/make_protocol.py)" % path.relative_to(ROOT))
        else:
            path.write_text(text)
    if check:
        return 1 if stale else 0
    print("%d file(s) changed" % stale)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
