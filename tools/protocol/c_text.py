"""The wire's definition as the C library has it: types and tables."""

import re

from larics.settings import fields as setting_fields
from larics.wire import codec, messages
from larics_host import wire_names as codes

C_TYPES = {"B": "uint8_t", "H": "uint16_t", "h": "int16_t", "I": "uint32_t", "i": "int32_t"}
KINDS = {"B": "U8", "H": "U16", "h": "I16", "I": "U30", "i": "I30"}
NATURAL = {
    "B": (0, 255),
    "H": (0, 65535),
    "h": None,  # its range is always told
    "I": (0, messages.COUNT_MAX),
    "i": (-messages.COUNT_MAX, messages.COUNT_MAX),
}


def members(fields):
    """[(declaration, comment)] of the fields as C members; value0..value7 become one array."""
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
    """The generated part of larics.h."""
    marker_frame = codec.frame_size(messages.MARKER)
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
    """The generated part of larics_layout.c."""
    fields_rows, layouts, ranges = [], [], []
    for name, _, _, fields in messages.MESSAGES:
        size = codec.frame_size(messages.__dict__[name]) - 10
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
