"""The wire's definition as modules of Python use it: layouts, indices of fields, records."""

import ast
import re
import struct
import textwrap

from larics.wire import messages
from larics_host import wire_names as codes

SIZES = {code: struct.calcsize("<" + code) for code in "BHhIi"}


def kind_of(field):
    """(code, size, lowest value, highest value) of a field"""
    return field[1][-1], SIZES.get(field[1]) or int(field[1][:-1]), field[3], field[4]


def kinds():
    """The kinds of the fields as they are defined now, each once."""
    return sorted({kind_of(field) for *_, fields in messages.MESSAGES for field in fields})


def layouts():
    """{type: entry of larics.wire.layouts.LAYOUTS}"""
    known, entries = kinds(), {}
    for _, number, _, fields in messages.MESSAGES:
        used = [kind_of(field) for field in fields]
        entries[number] = bytes([sum(kind[1] for kind in used), *map(known.index, used)])
    return entries


def layouts_text():
    """All of larics.wire.layouts, in lines of at most 110 characters."""
    codes, sizes, lows, highs = zip(*kinds(), strict=True)
    lines = []
    for name, column in (
        ("CODES", "".join(codes).encode()), ("SIZES", bytes(sizes)), ("LOWS", lows), ("HIGHS", highs)
    ):  # fmt: skip
        lines += _wrapped("%s = %r" % (name, column))
    lines.append("LAYOUTS = {")
    for number, entry in layouts().items():
        lines += ["    " + line for line in _wrapped("%d: %s," % (number, _escaped(entry)))]
    return "\n".join([*lines, "}"])


def _wrapped(text):
    return textwrap.wrap(text, 106, break_long_words=False)


def _escaped(data):
    """Bytes as numbers throughout, parted where a line may end."""
    parts = [data[k : k + 24] for k in range(0, len(data), 24)]
    text = " ".join('b"%s"' % "".join("\\x%02x" % item for item in part) for part in parts)
    return "(%s)" % text if len(parts) > 1 else text


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


def class_name(name):
    """RAW_HEADER -> RawHeader."""
    return "".join(word.capitalize() for word in name.split("_"))


def record_classes():
    """A NamedTuple for each message."""
    blocks = []
    for name, _, meaning, fields in messages.MESSAGES:
        lines = ["class %s(NamedTuple):" % class_name(name), '    """%s."""' % _capital(meaning), ""]
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


def _capital(text):
    return text[0].upper() + text[1:]
