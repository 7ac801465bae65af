"""Puts a raw frame together from its packed chunks; the other side of `larics.device.raw_frame`.

Every chunk can be decoded alone and in any order, so that a lost one costs only its own pixels.
"""

from __future__ import annotations

from binascii import crc32
from dataclasses import dataclass
from typing import Any

import numpy as np

from larics.wire.messages import RAW_CHUNK_BYTES, RAW_PIXELS_MOST, RAW_PLAIN, RAW_STRIP

_MOST = 1 << 26  # pixels; what claims more is damage and gets no memory
_ESCAPE = 12  # zeros before an error of prediction that is written as 8 bits


@dataclass
class RawFrame:
    """width, height: of the whole frame, px; frame: its number; pixels: bytes, row by row; window: (left,
    top, columns, rows) of those that came, outside of which each pixel is as the next one of the window."""

    width: int
    height: int
    frame: int
    pixels: bytes
    window: tuple[int, int, int, int]

    def array(self) -> np.ndarray:
        """The pixels as (height, width) uint8."""
        return np.frombuffer(self.pixels, np.uint8).reshape(self.height, self.width)


class RawAssembly:
    """header: the fields of RAW_HEADER; size, received: how many pixels there are, and how many came."""

    def __init__(self, header: Any) -> None:
        self.header = header
        self.token: int = header.token
        self.size: int = header.columns * header.rows
        self.received = 0
        kept = self.size if self.size <= _MOST else 0
        self._there = np.zeros(kept, bool)
        self._pixels = np.zeros(kept, np.uint8)  # numbered as in RAW_CHUNK

    def add(self, chunk: Any) -> bool:
        """Takes a RAW_CHUNK, the same twice too; False when it is no part of this frame."""
        first, count = chunk.first, chunk.count
        if chunk.token != self.token or count > len(self._there) - first:
            return False
        strip, number = divmod(first, RAW_STRIP * self.header.rows)
        width = min(RAW_STRIP, self.header.columns - RAW_STRIP * strip)
        if count > width * self.header.rows - number:
            return False
        pixels = unpacked(bytes(chunk.data), chunk.coding, count, number % width, width)
        if pixels is None:
            return False
        self._pixels[first : first + count] = pixels
        self.received += count - int(np.count_nonzero(self._there[first : first + count]))
        self._there[first : first + count] = True
        return True

    def missing(self) -> tuple[int, int] | None:
        """(first, count) of the first run of pixels that have not come; None when all have."""
        if self.received == self.size:
            return None
        if not len(self._there):
            return 0, 1
        first = int(np.argmin(self._there))
        rest = self._there[first:]
        count = int(np.argmax(rest)) if rest.any() else len(rest)
        return first, count

    def frame(self) -> RawFrame | None:
        """The RawFrame; None while pixels are missing, or when they are not those of the checksum."""
        told = self.header
        left, top, columns, rows = told.left, told.top, told.columns, told.rows
        right, bottom = told.width - left - columns, told.height - top - rows
        if self.received < self.size or right < 0 or bottom < 0:
            return None
        window = np.empty((rows, columns), np.uint8)
        for column in range(0, columns, RAW_STRIP):
            width = min(RAW_STRIP, columns - column)
            strip = self._pixels[column * rows : (column + width) * rows]
            window[:, column : column + width] = strip.reshape(rows, width)
        if crc32(window.tobytes()) != told.crc_low | told.crc_high << 16:
            return None
        whole = np.pad(window, ((top, bottom), (left, right)), mode="edge")
        return RawFrame(told.width, told.height, told.frame, whole.tobytes(), (left, top, columns, rows))


def unpacked(data: bytes, coding: int, count: int, column: int, width: int) -> list[int] | None:
    """The pixels of a chunk, the first of which is number `column` of a row of its strip, `width` wide.

    None when `data`, RAW_CHUNK_BYTES long, does not hold exactly so many."""
    if not 1 <= count <= RAW_PIXELS_MOST or len(data) != RAW_CHUNK_BYTES:
        return None
    if coding == RAW_PLAIN:
        plain = count <= RAW_CHUNK_BYTES and not any(data[count:])
        return list(data[:count]) if plain else None
    left = 8 * (RAW_CHUNK_BYTES - 1)  # bits not yet read
    bits = int.from_bytes(data[1:], "big")  # and they as a number
    pixels = [data[0]]
    for n in range(1, count):
        zeros = left - bits.bit_length()
        if zeros < _ESCAPE:
            left -= zeros + 1 + coding
            if left < 0:
                return None
            high = bits >> left  # a one, and the lower bits
            bits -= high << left
            z = zeros << coding | high & ((1 << coding) - 1)
            if z > 255:
                return None
        else:
            left -= _ESCAPE + 8
            if left < 0:
                return None
            z = bits >> left
            bits -= z << left
            if z > 255:
                return None
        west = pixels[-1]
        column += 1
        if column == width:
            column = 0
        if n < width:
            guess = west
        elif column == 0:
            guess = pixels[n - width]
        elif n == width:
            guess = west
        else:
            north, corner = pixels[n - width], pixels[n - width - 1]
            low, high = (west, north) if west < north else (north, west)
            guess = min(max(north + west - corner, low), high)
        pixels.append((guess + (z >> 1 if not z & 1 else ~(z >> 1))) & 255)
    return pixels if not bits else None
