"""Reports as one HTML file: pictures inside, nothing loaded from anywhere."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from typing import Any

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2733; margin: 2em auto; max-width: 68em; }
h1 { font-size: 1.6em; margin-bottom: 0; } h2 { font-size: 1.2em; margin: 2em 0 .5em; }
table { border-collapse: collapse; } th, td { padding: .25em .8em; border-bottom: 1px solid #dde3ea; }
td { text-align: right; font-variant-numeric: tabular-nums; } th { text-align: left; font-weight: 600; }
thead th { border-bottom: 2px solid #9fb0c0; text-align: right; } thead th:first-child { text-align: left; }
 .note { color: #5b6b7b; }
.right { background: #e2f4e8; } .wrong { background: #fbdcdc; } .zero { color: #b7c2cc; }
.passed { color: #1d7a3f; } .failed { color: #b3261e; font-weight: 600; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(20em, 1fr)); gap: 1em; }
figure { margin: 0; } img { max-width: 100%; } figcaption { font-size: .9em; overflow-wrap: anywhere; }
"""


def escape(text: object) -> str:
    """As text of a page."""
    return html.escape(str(text))


def table(headings: Sequence[object], rows: Iterable[tuple[object, Sequence[Any]]]) -> str:
    """A table of [(name, cells)]."""
    head = "".join("<th>%s</th>" % escape(heading) for heading in headings)
    body = "".join(
        "<tr><th>%s</th>%s</tr>" % (escape(name), "".join("<td>%s</td>" % escape(cell) for cell in cells))
        for name, cells in rows
    )
    return "<table><thead><tr>%s</tr></thead><tbody>%s</tbody></table>" % (head, body)


def picture(data: bytes, kind: str, caption: str) -> str:
    """A picture with its caption; kind: "png" or "jpeg"."""
    text = base64.b64encode(data).decode()
    return '<figure><img src="data:image/%s;base64,%s" alt=""><figcaption>%s</figcaption></figure>' % (
        kind,
        text,
        escape(caption),
    )


def page(title: str, body: str) -> str:
    """The whole file."""
    head = '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>%s</title><style>%s</style>'
    return head % (escape(title), _STYLE) + "</head><body>" + body + "</body></html>\n"
