"""A sheet as an anti-aliased grey PNG with its resolution written into it."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from larics_host.errors import UserError
from larics_host.printing.layout import Arc, Ring, Text

if TYPE_CHECKING:
    from larics_host.printing.layout import Sheet


MAX_SIDE_PX = 20000
STRIP_ROWS = 256  # bounds the memory: a large sheet has more pixels than fit as floats


def _distance_mm(item, x, y):
    """Signed distance of each point to the black of a primitive, negative inside."""
    if isinstance(item, Ring):
        return np.abs(np.hypot(x - item.x, y - item.y) - item.radius) - item.width / 2
    if isinstance(item, Arc):
        u, v = x - item.x, y - item.y
        middle, half = np.radians((item.first + item.last) / 2), np.radians((item.last - item.first) / 2)
        along, across = u * np.cos(middle) + v * np.sin(middle), v * np.cos(middle) - u * np.sin(middle)
        beside = np.abs(across) * np.cos(half) - along * np.sin(half)
        return np.maximum(np.abs(np.hypot(u, v) - item.radius) - item.width / 2, beside)
    length = np.hypot(item.x2 - item.x1, item.y2 - item.y1)
    ux, uy = (item.x2 - item.x1) / length, (item.y2 - item.y1) / length
    along = (x - item.x1) * ux + (y - item.y1) * uy
    across = np.abs((y - item.y1) * ux - (x - item.x1) * uy)
    return np.maximum(np.maximum(-along, along - length), across - item.width / 2)


def _bounds(item):
    """x0, y0, x1, y1 of a primitive."""
    half = item.width / 2
    if isinstance(item, (Ring, Arc)):
        reach = item.radius + half
        return item.x - reach, item.y - reach, item.x + reach, item.y + reach
    xs, ys = sorted((item.x1, item.x2)), sorted((item.y1, item.y2))
    return xs[0] - half, ys[0] - half, xs[1] + half, ys[1] + half


def _draw(pixels, items, sheet_height, scale, dx=0.0, dy=0.0):
    """Darkens `pixels` (float rows by columns, 1 white) by the primitives; `scale` is px per mm."""
    rows, columns = pixels.shape
    for item in items:
        if isinstance(item, Text):
            continue
        x0, y0, x1, y1 = _bounds(item)
        left = max(0, int((x0 + dx) * scale) - 1)
        right = min(columns, int((x1 + dx) * scale) + 2)
        top = max(0, int((sheet_height - y1 - dy) * scale) - 1)
        bottom = min(rows, int((sheet_height - y0 - dy) * scale) + 2)
        x = (np.arange(left, right, dtype=np.float32) + 0.5) / scale - dx
        for first in range(top, bottom, STRIP_ROWS):
            last = min(bottom, first + STRIP_ROWS)
            y = sheet_height - (np.arange(first, last, dtype=np.float32)[:, None] + 0.5) / scale - dy
            cover = np.clip(0.5 - _distance_mm(item, x, y) * scale, 0.0, 1.0)
            cover = np.minimum(cover, item.width * scale)  # a line thinner than a pixel
            if isinstance(item, Ring) and item.dash:
                turn = np.arctan2(y - item.y, x - item.x) * (item.radius / item.dash)
                cover[np.floor(turn).astype(int) % 2 == 1] = 0
            window = pixels[first:last, left:right]
            np.minimum(window, 255 - (255 * (1 - item.grey) * cover + 0.5).astype(np.uint8), out=window)


def png_bytes(sheet: Sheet, dpi: float) -> bytes:
    """The sheet as an 8-bit grey PNG at `dpi` pixels an inch. Raises UserError when that is too large."""
    scale = dpi / 25.4
    width, height = round(sheet.width * scale), round(sheet.height * scale)
    if max(width, height) > MAX_SIDE_PX:
        raise UserError(
            "a PNG of %d x %d pixels is too large: choose a lower --dpi, or PDF or SVG" % (width, height)
        )
    pixels = np.full((height, width), 255, np.uint8)
    _draw(pixels, sheet.content, sheet.height, scale, sheet.dx, sheet.dy)
    _draw(pixels, sheet.furniture, sheet.height, scale)
    image = Image.fromarray(pixels)
    pen = ImageDraw.Draw(image)
    anchors = {"start": "ls", "middle": "ms", "end": "rs"}
    for items, dx, dy in ((sheet.content, sheet.dx, sheet.dy), (sheet.furniture, 0.0, 0.0)):
        for item in items:
            if isinstance(item, Text):
                place = ((item.x + dx) * scale, (sheet.height - item.y - dy) * scale)
                font = ImageFont.load_default(max(4.0, item.size * scale))
                pen.text(place, item.text, fill=0, font=font, anchor=anchors[item.anchor])
    buffer = io.BytesIO()
    image.save(buffer, "PNG", dpi=(dpi, dpi), optimize=True)
    return buffer.getvalue()
