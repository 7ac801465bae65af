"""Messages as docs/wire.md describes them, by nothing of ours: struct, zlib, and COBS written out.

It made the bytes of tests/dual/frozen_frames.py once; they are not made again.
"""

import struct
import zlib


def frame(number, sequence, codes, values):
    """The bytes on the line of version 1. codes: of `struct`, one for each value."""
    message = struct.pack("<BBH" + "".join(codes), 1, number, sequence, *values)
    message += struct.pack("<I", zlib.crc32(message))
    blocks = message.split(b"\0")  # below 254 bytes each
    return b"".join(bytes([len(block) + 1]) + block for block in blocks) + b"\0"
