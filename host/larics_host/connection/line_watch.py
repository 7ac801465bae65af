"""What came over a line on which no message could be read: nothing, noise, text, or another language.

The causes differ, and so does what to do: the wrong port or no power, the wrong baud rate, the board's USB
console in place of its UART, the setting `output`, or bytes that a console has turned into text.
"""

from __future__ import annotations

import functools
import operator
import re
from typing import TYPE_CHECKING

from larics_host.files import encoding_of
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics.wire.codec import Counters

_SAMPLE_BYTES = 4096
_TEXT_BYTES = 256
_ENOUGH = 2  # sentences or frames of another language, less is chance
_NMEA = re.compile(rb"\$([A-Z]{2}[A-Z0-9]{1,6})((?:,[^$*\r\n]{0,80})*)\*([0-9A-Fa-f]{2})")
_MARK = (b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf")
_TAKEN = "for larics replay, larics monitor --input, larics log --convert as"
_TEXTS = (  # how files of text begin that are no bytes of a line
    (re.compile(r"\s*\{"), "JSON lines, %s .jsonl" % _TAKEN),
    (re.compile(r'\s*(?:sep=.\s+)?"?time_s"?\s*[,;\t|]'), "a table of larics log, %s .csv" % _TAKEN),
)
_FILES = (  # and others
    (
        b"\x89MCAP",
        "an MCAP file, for larics replay, larics monitor --input, larics log --convert as .mcap",
    ),
    (b"OMV IMG STR", "an ImageIO stream: larics record --input takes it"),
    (b"P5", "an image: larics detect takes it"),
    (b"\x89PNG", "an image: larics detect takes it"),
    (b"\xff\xd8\xff", "an image: larics detect takes it"),
    (b"\x1f\x8b", "a compressed file: unpack it first"),
    (b"PK\x03\x04", "a compressed file: unpack it first"),
)
_CONSOLE = (b">>>", b"MicroPython", b"Traceback", b"OpenMV", b"larics ", b"MPY:")


class LineWatch:
    """Keeps what is needed to tell the kinds apart: how many bytes came, the first and the last of them."""

    def __init__(self) -> None:
        self.total = 0
        self._first = bytearray()
        self._last = bytearray()

    def feed(self, data: bytes) -> None:
        """Takes bytes as they come."""
        self.total += len(data)
        room = _SAMPLE_BYTES - len(self._first)
        if room > 0:
            self._first += data[:room]
            data = data[room:]
        if data:
            self._last += data[-_SAMPLE_BYTES:]
            del self._last[:-_SAMPLE_BYTES]

    def explain(self, counters: Counters, baud: int | None = None) -> str:
        """What came and what to do, for a sentence; counters of the decoder that was fed the same.

        baud: speed of the port, None for bytes that come from a file."""
        if not self.total:
            if baud is None:
                return "it is empty"
            if not baud:
                return "not a byte: is it the address of larics camera, and does its camera deliver?"
            return "not a byte: check the power, the wiring (its TX to this RX) and the name of the port"
        return "%s: %s" % (counted(self.total, "byte"), self._kind(counters, baud))

    def explain_rest(self, counters: Counters, message_bytes: int, baud: int | None = None) -> str | None:
        """What most of the bytes are, where messages are the lesser part of them; None where they are not.

        message_bytes: of all messages that were received."""
        rest = self.total - message_bytes
        if 2 * rest < self.total or rest < _SAMPLE_BYTES:
            return None
        kind = self._known(counters, baud) or "noise, or messages that were damaged"
        return "%d of %s belong to no message: %s" % (rest, counted(self.total, "byte"), kind)

    def _kind(self, counters, baud):
        known = self._known(counters, baud)
        if known:
            return known
        if baud is None:
            return "noise, no message among it; it takes the bytes of larics log --raw"
        if not baud:
            return "noise, no message among it: is it the address of larics camera?"
        return "noise: most likely the wrong baud rate (%d here, the camera has its setting baud)" % baud

    def _known(self, counters, baud):
        """What it is for sure; None for noise."""
        sample = bytes(self._first + self._last)
        others = counters.version + counters.length + counters.unknown  # whole, and none of this version's
        if others > counters.crc + counters.cobs + counters.over_long:
            return "messages of another version: both need the same larics, which larics flash brings"
        if baud is None:
            if not sample.strip(b"\0"):
                return "nothing but zeros: the disk or the power failed before it was written"
            text = sample[:_TEXT_BYTES].decode(encoding_of(sample[:_TEXT_BYTES]), "replace")
            for begin, what in _TEXTS:
                if begin.match(text.lstrip("\ufeff")):
                    return what
            if sample.startswith(_MARK) or sample[1:40:2].strip(b"\0") == b"":
                return "text in another encoding: a console changed the bytes; larics log --raw keeps them"
            for head, text in _FILES:
                if sample.startswith(head):
                    return text
        sentences = [name for name, right in _sentences(sample) if right]
        if len(sentences) >= _ENOUGH:
            name = sentences[0].decode()
            if name.startswith("PLR"):
                return "lines of text ($%s): the camera's setting output is nmea, %s" % (name, _SET_OUTPUT)
            return "NMEA lines ($%s) of another device, such as a GPS: give the camera's port" % name
        if _mavlink_frames(sample) >= _ENOUGH:
            return "MAVLink: the camera's setting output is mavlink, or it is another port; %s" % _SET_OUTPUT
        if len(set(sample)) == 1 and len(sample) > 8:
            return "all of them 0x%02x: TX hangs loose or inverted, or the baud rate is wrong" % sample[0]
        printable = sum(byte in b"\t\r\n" or 32 <= byte < 127 for byte in sample)
        if printable > 0.9 * len(sample):
            begins = re.sub(rb"[^ -~]+", b" ", sample[:60]).decode().strip()
            if any(word in sample for word in _CONSOLE):
                return "text of the board's console (%s): that is its USB, take the port of its UART" % begins
            return "text (%s): another device, or another baud rate" % begins
        ended = counters.crc + counters.cobs + counters.length + counters.over_long + counters.out_of_range
        if counters.crc > _ENOUGH and 2 * counters.crc > ended:
            return "frames like the camera's, but no checksum is right: check ground, cable and its length"
        return None


_SET_OUTPUT = "larics settings set output=larics --save and larics settings restart change that"


def _sentences(sample):
    """(name, whether its checksum is right) of each NMEA sentence."""
    for match in _NMEA.finditer(sample):
        body = match.group(1) + match.group(2)
        yield match.group(1), functools.reduce(operator.xor, body, 0) == int(match.group(3), 16)


def _mavlink_frames(sample):
    """Frames of MAVLink 1 or 2 that are followed by another one, or by the end; none where they are so few
    that noise may look like them."""
    count = covered = 0
    for magic, overhead in ((0xFD, 12), (0xFE, 8)):
        place = sample.find(magic)
        while 0 <= place < len(sample) - 1:
            end = place + overhead + sample[place + 1]
            signed = magic == 0xFD and place + 2 < len(sample) and sample[place + 2] & 1
            end += 13 if signed else 0
            if end == len(sample) or (end < len(sample) and sample[end] == magic):
                count += 1
                covered += end - place
                place = end
            else:
                place += 1
            place = sample.find(magic, place)
    return count if 4 * covered > len(sample) else 0
