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

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "shared")]

from larics.wire import codec  # noqa: E402
from larics_host.ros.wire_types import type_of  # noqa: E402
from tools.protocol import c_text, page_text, python_text, ros_text  # noqa: E402

LAYOUTS = ROOT / "shared" / "larics" / "wire" / "layouts.py"
HEADER = ROOT / "firmware" / "vehicle" / "src" / "larics.h"
SOURCE = ROOT / "firmware" / "vehicle" / "src" / "larics_layout.c"
DOCUMENT = ROOT / "docs" / "wire.md"
README = ROOT / "README.md"
RECORDS = ROOT / "host" / "larics_host" / "connection" / "records.py"
ROS_MESSAGES = ROOT / "ros2" / "larics_msgs" / "msg"
INDICES = "# generated: begin indices (tools/make_protocol.py)", "# generated: end indices"


def _without_part(text, begin, end):
    head, _, rest = text.partition(begin)
    return head + rest.partition(end)[2]


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
    yield LAYOUTS, replaced(LAYOUTS.read_text(), python_text.layouts_text(), begin, end)
    codec.LAYOUTS.update(python_text.layouts())  # for what follows
    for folder in ("shared", "firmware"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            text = path.read_text()
            if INDICES[0] in text:
                used = python_text.indices_used(_without_part(text, *INDICES))
                yield path, replaced(text, used, *INDICES)
    begin, end = "/* generated: begin (tools/make_protocol.py) */", "/* generated: end */"
    yield HEADER, replaced(HEADER.read_text(), c_text.c_header(), begin, end)
    yield SOURCE, replaced(SOURCE.read_text(), c_text.c_tables(), begin, end)
    text = DOCUMENT.read_text()
    for name, content in page_text.document_parts().items():
        begin, end = "<!-- generated: begin %s -->" % name, "<!-- generated: end %s -->" % name
        text = replaced(text, "\n" + content + "\n", begin, end)
    yield DOCUMENT, text
    begin, end = "<!-- wire:begin -->", "<!-- wire:end -->"
    yield README, replaced(README.read_text(), "\n" + page_text.overview() + "\n", begin, end)
    begin, end = "# generated: begin (tools/make_protocol.py)", "# generated: end"
    yield RECORDS, replaced(RECORDS.read_text(), "\n\n" + python_text.record_classes() + "\n\n", begin, end)
    for name, number, meaning, _ in codec.MESSAGES:
        path = ROS_MESSAGES / (type_of(name).split("/")[1] + ".msg")
        yield path, ros_text.ros_message(name, number, meaning)


def main(arguments):
    """Writes or checks all targets; returns the exit code."""
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
