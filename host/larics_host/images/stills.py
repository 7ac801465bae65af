"""Still images from bytes: PGM, PNG and JPEG as 2-D uint8 arrays.

Whatever is wrong with the bytes, the only exception is UserError; its text lacks the name of the file,
which the caller puts in front.
"""

from __future__ import annotations

import contextlib
import io
import re
import warnings

import numpy as np

from larics_host.errors import UserError, report_once
from larics_host.wording import counted

MAX_PIXELS = 150_000_000  # a telephone's photograph, a marker at 600 dpi; a damaged header may claim any size
ORIENTATION_TAG = 274
_TURNS = {  # what a viewer does for the value of the tag
    2: "mirrored",
    3: "turned by 180 degrees",
    4: "upside down, mirrored",
    5: "turned by 90 degrees and mirrored",
    6: "turned by 90 degrees",
    7: "turned by 270 degrees and mirrored",
    8: "turned by 270 degrees",
}

PGM_MAGIC = (b"P5", b"P2")
PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
JPEG_MAGIC = b"\xff\xd8\xff"

_OTHERS = (
    (rb"BM", "BMP"),
    (rb"II\*\0|MM\0\*", "TIFF"),
    (rb"RIFF....WEBP", "WebP"),
    (rb"....ftyp(heic|heix|mif1|avif)", "HEIF"),
    (rb"\0\0\0\x0cjP  ", "JPEG 2000"),
    (rb"P[1346]\s", "PBM or PPM"),
)
_SIXTEEN_BIT = "a 16-bit image: convert it to 8 bits a pixel"
_HEADER_ITEM = re.compile(rb"(?:\s|#[^\n]*\n)+(\d{1,9})")


def check_size(width: int, height: int) -> None:
    """Raises UserError for a frame without pixels or with absurdly many."""
    if width < 1 or height < 1:
        raise UserError("the image has no pixels (%d x %d)" % (width, height))
    if width * height > MAX_PIXELS:
        raise UserError("%d x %d pixels are more than a frame can have" % (width, height))


def _decode_pgm(data):
    place = 2
    numbers = []
    for _ in range(3):
        item = _HEADER_ITEM.match(data, place)
        if not item:
            raise UserError("damaged or truncated PGM header")
        numbers.append(int(item.group(1)))
        place = item.end()
    width, height, maximum = numbers
    check_size(width, height)
    if maximum > 255:
        raise UserError(_SIXTEEN_BIT)
    if maximum != 255:
        raise UserError("a PGM with the maximum %d: convert it to 255" % maximum)
    count = width * height
    if data[:2] == b"P5":
        end = 2 if data[place : place + 2] == b"\r\n" and len(data) - place - 2 == count else 1
        pixels = np.frombuffer(data, np.uint8, offset=min(place + end, len(data)))
        if pixels.size > count and bytes(pixels[count:]).strip():
            sizes = counted(pixels.size - count, "byte"), width, height
            raise UserError("%s more than %d x %d pixels" % sizes)
    else:
        try:
            pixels = np.array(data[place:].split(), dtype=np.int64)
        except (ValueError, OverflowError) as error:
            raise UserError("a text PGM with something that is no number") from error
        if pixels.size and not 0 <= pixels.min() <= pixels.max() <= 255:
            raise UserError("a text PGM with a value outside 0..255")
        if pixels.size > count:
            raise UserError("%d values more than %d x %d pixels" % (pixels.size - count, width, height))
    if pixels.size < count:
        raise UserError("truncated: %d of %d pixels" % (pixels.size, count))
    return pixels[:count].astype(np.uint8).reshape(height, width)


def tell_of_turn(name: str, turn: str) -> None:
    """One line about a tag that is not obeyed; the next pictures with the same one are not told of."""
    text = "%s: a tag asks to show it %s; that is ignored: pixels are taken as the camera delivered them"
    report_once(("turn", turn), text % (name, turn))


def _decode_compressed(data, name):
    from PIL import Image

    if data.startswith(PNG_MAGIC) and data[24:25] == b"\x10":
        raise UserError(_SIXTEEN_BIT)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # size is checked here, metadata does not matter
            image = Image.open(io.BytesIO(data), formats=("PNG", "JPEG"))
            check_size(*image.size)
            if image.mode.startswith(("I", "F")):
                raise UserError(_SIXTEEN_BIT)
            frame = _grey(image)
            with contextlib.suppress(Exception):  # nor does a damaged one
                turn = _TURNS.get(image.getexif().get(ORIENTATION_TAG))
                if turn:
                    tell_of_turn(name, turn)
            return frame
    except UserError:
        raise
    except Exception as error:  # the decoders raise whatever a damaged file leads them to
        raise UserError("damaged or truncated image (%s)" % error) from error


def _grey(image):
    """The pixels as the camera delivered them, transparent paper white."""
    from PIL import Image

    if "transparency" in image.info or image.mode in ("LA", "PA", "RGBA"):
        image = image.convert("RGBA")
        if not image.getextrema()[3][1]:
            raise UserError("all of it is transparent: save it without transparency")
        image = Image.alpha_composite(Image.new("RGBA", image.size, (255, 255, 255, 255)), image)
    return np.array(image.convert("L"))


def other_kind(head: bytes) -> str | None:
    """What kind of image the first bytes of a file are that is none of ours; None when they are no image."""
    return next((name for magic, name in _OTHERS if re.match(magic, head, re.DOTALL)), None)


def is_still(head: bytes) -> bool:
    """Whether the first bytes of a file say that it is a PGM, PNG or JPEG."""
    return head.startswith((*PGM_MAGIC, PNG_MAGIC, JPEG_MAGIC))


def decode_still(data: bytes, name: str = "an image") -> np.ndarray:
    """An image file's bytes as a 2-D uint8 array (rows, columns); colour becomes grey (ITU-R 601).

    Pixels are as the camera delivered them: a tag that asks for the picture to be turned is named on standard
    error and not obeyed. What is transparent is white.
    Raises UserError when it is damaged, truncated, has 16 bits a pixel or is no PGM, PNG or JPEG.
    """
    if data.startswith(PGM_MAGIC):
        return _decode_pgm(data)
    if data.startswith((PNG_MAGIC, JPEG_MAGIC)):
        return _decode_compressed(data, name)
    raise UserError("not a PGM, PNG or JPEG image")


def encode_pgm(frame: np.ndarray) -> bytes:
    """The bytes of a binary PGM file that holds a 2-D uint8 array."""
    height, width = frame.shape
    return b"P5\n%d %d\n255\n" % (width, height) + frame.tobytes()
