"""Sheets as a vector PDF, true to scale."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterable
from types import ModuleType
from typing import TYPE_CHECKING

# else reportlab seeks settings of its own in the home, and fails where that is no folder, as with services
for _name in ("reportlab_mods", "reportlab_settings"):
    sys.modules.setdefault(_name, ModuleType(_name))

from reportlab.pdfgen import canvas  # noqa: E402

from larics_host.printing.layout import Arc, Line, Ring, Text  # noqa: E402

if TYPE_CHECKING:
    from larics_host.printing.layout import Sheet


POINT_MM = 25.4 / 72


def _draw(page, items):
    for item in items:
        if isinstance(item, Text):
            page.setFillGray(0)
            page.setFont("Helvetica", item.size)
            draw = {"start": page.drawString, "middle": page.drawCentredString, "end": page.drawRightString}
            draw[item.anchor](item.x, item.y, item.text)
            continue
        page.setStrokeGray(item.grey)
        page.setLineWidth(item.width)
        if isinstance(item, Ring):
            page.setDash([item.dash, item.dash] if item.dash else [])
            page.circle(item.x, item.y, item.radius, stroke=1, fill=0)
        elif isinstance(item, Arc):
            page.setDash([])
            box = (item.x - item.radius, item.y - item.radius, item.x + item.radius, item.y + item.radius)
            page.arc(*box, item.first, item.last - item.first)
        elif isinstance(item, Line):
            page.setDash([])
            page.line(item.x1, item.y1, item.x2, item.y2)


def pdf_bytes(sheets: Iterable[Sheet], title: str) -> bytes:
    """A PDF of the sheets, a page each; equal input gives equal bytes."""
    buffer = io.BytesIO()
    page = canvas.Canvas(buffer, invariant=1)
    page.setTitle(title)
    page.setViewerPreference("PrintScaling", "None")  # a viewer must not offer "fit to page" by itself
    for sheet in sheets:
        page.setPageSize((sheet.width / POINT_MM, sheet.height / POINT_MM))
        page.scale(1 / POINT_MM, 1 / POINT_MM)
        page.saveState()
        window = page.beginPath()
        window.rect(*sheet.window)
        page.clipPath(window, stroke=0, fill=0)
        page.translate(sheet.dx, sheet.dy)
        _draw(page, sheet.content)
        page.restoreState()
        _draw(page, sheet.furniture)
        page.showPage()
    page.save()
    return buffer.getvalue()
