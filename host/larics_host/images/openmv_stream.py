"""OpenMV ImageIO streams (.bin), as `image.ImageIO("clip.bin", "w")` records them on the camera.

A stream is 16 bytes of magic, then frames. A frame of version 2.0 is, in little-endian 32-bit words,
elapsed milliseconds, width, height, pixel format, size, 12 bytes of padding and the data; versions 1.0 and
1.1 have no size and no padding, and a small number for the format, or the size of a JPEG. Data is padded
to 16 bytes. Pixel formats as in the firmware's imlib.h.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import BinaryIO

import numpy as np

from larics_host.errors import UserError
from larics_host.images.stills import check_size, decode_still

MAGIC = b"OMV IMG STR V"
VERSIONS = (b"1.0", b"1.1", b"2.0")

BINARY = 0x08010000
GRAYSCALE = 0x08020001
RGB565 = 0x0C030002
BAYER = {0x05040001: "BGGR", 0x05040101: "GBRG", 0x05040201: "GRBG", 0x05040301: "RGGB"}
YUV422 = (0x14050002, 0x14050102)
COMPRESSED = (0x06060000, 0x06070000)  # JPEG, PNG
_OLD_FORMATS = {0: BINARY, 1: GRAYSCALE, 2: RGB565, 3: 0x05040001}


def write_stream(file: BinaryIO, frames: Iterable[np.ndarray], period_ms: int) -> int:
    """Writes 2-D uint8 arrays of one size as a stream of version 2.0; returns how many."""
    file.write(MAGIC + b"2.0")
    count = 0
    for frame in frames:
        height, width = frame.shape
        data = frame.tobytes()
        file.write(struct.pack("<5I12x", period_ms, width, height, GRAYSCALE, len(data)))
        file.write(data + bytes(-len(data) % 16))
        count += 1
    return count


def _data_size(pixel_format, width, height, size):
    if pixel_format == BINARY:
        return (width + 31) // 32 * 4 * height
    if pixel_format == GRAYSCALE or pixel_format in BAYER:
        return width * height
    if pixel_format == RGB565 or pixel_format in YUV422:
        return 2 * width * height
    if pixel_format in COMPRESSED:
        return size
    raise UserError("unknown pixel format 0x%08x" % pixel_format)


def _grey_of_rgb565(pixels):
    """Grey as the camera's own conversion computes it."""
    pixels = pixels.astype(np.uint32)
    red, green, blue = (pixels >> 8) & 0xF8, (pixels >> 3) & 0xFC, (pixels << 3) & 0xF8
    red, green, blue = red | red >> 5, green | green >> 6, blue | blue >> 5
    return ((red * 38 + green * 75 + blue * 15) >> 7).astype(np.uint8)


def _decode(data, pixel_format, width, height, big_endian):
    if pixel_format in COMPRESSED:
        frame = decode_still(data)
        if frame.shape != (height, width):
            raise UserError("a frame of %d x %d holds an image of another size" % (width, height))
        return frame
    if pixel_format == BINARY:
        bits = np.unpackbits(np.frombuffer(data, np.uint8).reshape(height, -1), axis=1, bitorder="little")
        return bits[:, :width] * np.uint8(255)
    if pixel_format == RGB565:
        return _grey_of_rgb565(np.frombuffer(data, ">u2" if big_endian else "<u2").reshape(height, width))
    if pixel_format in YUV422:
        return np.frombuffer(data, np.uint8)[::2].reshape(height, width).copy()
    frame = np.frombuffer(data, np.uint8).reshape(height, width).copy()
    if pixel_format in BAYER:
        if width < 4 or height < 4:
            raise UserError("a Bayer frame of %d x %d is too small" % (width, height))
        import cv2

        frame = cv2.cvtColor(frame, getattr(cv2, "COLOR_Bayer%s2GRAY" % BAYER[pixel_format]))
    return frame


def read_stream(file: BinaryIO) -> Iterator[np.ndarray]:
    """Yields the frames of an open binary file as 2-D uint8 arrays.

    Raises UserError where the stream is no stream, damaged or truncated, after the frames before.
    """
    head = file.read(16)
    version = head[len(MAGIC) :]
    if not head.startswith(MAGIC) or version not in VERSIONS:
        raise UserError("not an OpenMV image stream of version 1.0, 1.1 or 2.0")
    old = version != b"2.0"
    header_size = 16 if old else 32
    number = 0
    while True:
        header = file.read(16)
        if not header:
            break
        if header.startswith(MAGIC) and header[len(MAGIC) :] == version:
            continue  # streams one after the other, as cat joins them
        header += file.read(header_size - 16)
        try:
            if len(header) < header_size:
                raise UserError("truncated")
            _, width, height, pixel_format, size = struct.unpack("<5I", (header + bytes(4))[:20])
            if old:
                size = pixel_format
                pixel_format = _OLD_FORMATS.get(pixel_format, COMPRESSED[0])
            check_size(width, height)
            size = _data_size(pixel_format, width, height, size)
            check_size(size, 1)
            data = file.read(size)
            if len(data) < size:
                raise UserError("truncated: %d of %d bytes" % (len(data), size))
            file.read(-size % 16)
            frame = _decode(data, pixel_format, width, height, version == b"1.0")
        except UserError as error:
            raise UserError("frame %d: %s" % (number, error)) from error
        yield frame
        number += 1
    if not number:
        raise UserError("the stream holds no frame")
