"""Docstrings of this project as reStructuredText.

They are plain text with Markdown's backticks: prose, columns of names and meanings, and what is shown as it
stands (diagrams, examples).
"""

import re

_SPECIAL = re.compile(r"([*|_\\])")
_CODE = re.compile(r"`+([^`]+)`+")
_ROW = re.compile(r"(\S.*?) {2,}(\S.*)")


def _prose(line):
    """A line of text: code in double backticks, all else without markup."""
    parts = _CODE.split(line)
    for k, part in enumerate(parts):
        parts[k] = "``%s``" % part if k % 2 else _SPECIAL.sub(r"\\\1", part)
    return "".join(parts)


def _columns(block):
    """[name, meaning] of each row when the block is two columns, else None; indented lines go on."""
    rows = []
    for line in block:
        row = _ROW.fullmatch(line)
        if row:
            rows.append([row[1], row[2]])
        elif line.startswith(" ") and rows:
            rows[-1][1] += " " + line.strip()
        else:
            return None
    return rows


def restructured(lines):
    """Lines of a docstring -> lines of reStructuredText."""
    out, block = [], []
    for line in [*lines, ""]:
        if line.strip():
            block.append(line)
        elif block:
            rows = _columns(block)
            if rows:
                out += [":``%s``: %s" % (name, _prose(meaning)) for name, meaning in rows]
            elif any(text.startswith(" ") for text in block):
                out += [".. code-block:: text", "", *("    " + text for text in block)]
            else:
                out += [_prose(text) for text in block]
            out.append("")
            block = []
    return out


def process(app, what, name, obj, options, lines):
    """Sphinx's event autodoc-process-docstring."""
    lines[:] = restructured(lines)


def setup(app):
    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True}
