"""The wire's definition as modules of Python use it: layouts, indices of fields, records."""

import ast
import re
import struct
import textwrap

from larics.wire import messages
from larics_host import wire_names as codes

SIZES = {code: struct.calcsize("<" + code) for code in "BHhIi"}


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
