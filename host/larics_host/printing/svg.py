"""A sheet as SVG: one user unit is one millimetre."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from larics_host.printing.layout import Arc, Ring, Text

if TYPE_CHECKING:
    from larics_host.printing.layout import Sheet


def _number(value):
    return ("%.4f" % value).rstrip("0").rstrip(".")


def _attributes(**values):
    texts = {name: value if isinstance(value, str) else _number(value) for name, value in values.items()}
    return " ".join('%s="%s"' % (name.replace("_", "-"), text) for name, text in texts.items())


def _element(item, height, dx=0.0, dy=0.0):
    """One primitive; SVG counts y downwards."""
    if isinstance(item, Text):
        place = _attributes(
            x=item.x + dx, y=height - item.y - dy, font_size=item.size, text_anchor=item.anchor
        )
        return '<text %s font-family="Helvetica, Arial, sans-serif">%s</text>' % (place, escape(item.text))
    level = round(255 * item.grey)
    stroke = {"stroke": "#%02x%02x%02x" % (level, level, level), "stroke_width": item.width}
    if isinstance(item, Ring):
        if item.dash:
            stroke["stroke_dasharray"] = item.dash
        return '<circle %s fill="none"/>' % _attributes(
            cx=item.x + dx, cy=height - item.y - dy, r=item.radius, **stroke
        )
    if isinstance(item, Arc):
        ends = []
        for degrees in (item.first, item.last):
            angle = math.radians(degrees)
            x, y = item.x + item.radius * math.cos(angle), item.y + item.radius * math.sin(angle)
            ends.append("%s %s" % (_number(x + dx), _number(height - y - dy)))
        radius = _number(item.radius)
        path = "M %s A %s %s 0 0 0 %s" % (ends[0], radius, radius, ends[1])
        return '<path %s fill="none"/>' % _attributes(d=path, **stroke)
    return "<line %s/>" % _attributes(
        x1=item.x1 + dx, y1=height - item.y1 - dy, x2=item.x2 + dx, y2=height - item.y2 - dy, **stroke
    )


def svg_bytes(sheet: Sheet, title: str) -> bytes:
    """The sheet as an SVG document whose width and height are in millimetres."""
    width, height = _number(sheet.width), _number(sheet.height)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" width="%smm" height="%smm" viewBox="0 0 %s %s">'
        % (width, height, width, height),
        "<title>%s</title>" % escape(title),
        '<rect width="%s" height="%s" fill="#ffffff"/>' % (width, height),
    ]
    lines += [_element(item, sheet.height, sheet.dx, sheet.dy) for item in sheet.content]
    lines += [_element(item, sheet.height) for item in sheet.furniture]
    return ("\n".join([*lines, "</svg>"]) + "\n").encode()
