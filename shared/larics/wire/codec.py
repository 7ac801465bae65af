"""The wire: `Encoder` and streaming `Decoder` of the messages that `larics.wire.messages` defines.

A frame is COBS(version, type, sequence, payload, CRC-32) and a final 0; see `larics.wire.framing`. Both
classes own fixed buffers and allocate nothing per byte or per message but the first of a type.
"""

import struct
from array import array

try:
    from micropython import const

    from larics.kernels.stream import unpack, unstuff
except ImportError:
    from larics._cpython import const, unstuff

    unpack = None

from larics.wire.framing import CRC_TABLE, LIMIT, OVERHEAD, seal
from larics.wire.layouts import CODES, HIGHS, LAYOUTS, LOWS, SIZES
from larics.wire.messages import *  # noqa: F403  (this module is the entry to the wire: type numbers and codes)
from larics.wire.messages import COUNT_MAX, FIRST_COMMAND, INFO, STATUS, VERSION

# generated: begin indices (tools/make_protocol.py)
_INFO_BOOT = const(1)
_STATUS_BOOT = const(3)
# generated: end indices

LATE = const(8)
_HEADER = const(4)
_CRC = const(4)
MAX_FRAME = const(130)  # bytes of the longest frame: LIMIT, COBS byte and final 0

_FORMATS = {66: "<B", 98: "<b", 72: "<H", 104: "<h", 73: "<I", 105: "<i"}  # by the ASCII of a field's code
_BYTES = const(115)  # "s"
_LOWER = const(97)  # codes from here on are signed
_BODY = const(0)  # items as in layouts
_KINDS = const(1)
_PLACE = const(0)  # items as in kernels.stream
_WHOLE = const(3)
_WELL = const(1)
_EMPTY = const(2)
_OVER_LONG = const(3)
_COBS = const(4)
_SHORT = const(5)
_WRONG_CRC = const(6)
_OTHER_VERSION = const(7)

_named = {}  # type: (name, fields), for people and messages to them


def _described(number):
    if not _named:
        from larics.wire.messages import MESSAGES  # a board does without, unless something is wrong

        for title, kind, _, described in MESSAGES:
            _named[kind] = title, described
    return _named[number]


def fields(number):
    """The fields of a type: tuples (name, code, unit, min, max, meaning). KeyError for unknown types."""
    return _described(number)[1]


def name(number):
    """The name of a type; KeyError for unknown types."""
    return _described(number)[0]


def frame_size(number):
    """Bytes of a type's frame on the line, always the same."""
    return LAYOUTS[number][_BODY] + _HEADER + OVERHEAD


def ranges_of(layout):
    """The fields of a layout without byte fields as kernels.stream.unpack wants them."""
    ranges = array("i", [0] * (4 * (len(layout) - _KINDS)))
    for k in range(len(layout) - _KINDS):
        kind = layout[_KINDS + k]
        ranges[4 * k] = SIZES[kind]
        ranges[4 * k + 1] = int(CODES[kind] >= _LOWER)
        ranges[4 * k + 2], ranges[4 * k + 3] = abs(LOWS[kind]), HIGHS[kind]  # only signed ones are negative
    return ranges


class Encoder:
    """Puts one message at a time into `buffer`, numbered by `sequence` (the next number, 0..65535).

    A value outside its range raises ValueError; with clamp=True, for a device that must not stop, it is
    set to the nearest allowed value and counted in `clamped`.
    """

    def __init__(self, clamp=False):
        self.buffer = bytearray(MAX_FRAME)
        self.sequence = 0
        self.clamped = 0
        self._clamp = clamp

    def encode(self, number, values):
        """Encodes the values, in field order, as a message of this type; returns n: send buffer[:n].

        An item of a byte field ("64s") is a buffer of exactly that length; a reused list of values may
        be longer than the fields. ValueError for an unknown type, too few values, or one out of range.
        """
        layout = LAYOUTS.get(number)
        if layout is None:
            raise ValueError("message type %d is unknown" % number)
        count = len(layout) - _KINDS
        if len(values) < count:
            raise ValueError("%s has %d fields, got %d values" % (name(number), count, len(values)))
        buffer = self.buffer
        buffer[1] = VERSION
        buffer[2] = number
        buffer[3] = self.sequence & 0xFF
        buffer[4] = self.sequence >> 8
        place = 1 + _HEADER
        codes, lows, highs = CODES, LOWS, HIGHS
        for k in range(count):
            value = values[k]
            kind = layout[_KINDS + k]
            if codes[kind] == _BYTES:
                self._put_bytes(number, k, value, place)
            else:
                if not lows[kind] <= value <= highs[kind]:
                    value = self._refuse(number, k, value)
                struct.pack_into(_FORMATS[codes[kind]], buffer, place, value)
            place += SIZES[kind]
        self.sequence = (self.sequence + 1) & 0xFFFF
        return seal(buffer, place)

    def _put_bytes(self, number, k, data, place):
        size = SIZES[LAYOUTS[number][_KINDS + k]]
        if len(data) != size:
            place = "%s.%s" % (name(number), fields(number)[k][0])
            raise ValueError("%s has %d bytes, got %d" % (place, size, len(data)))
        self.buffer[place : place + size] = data

    def _refuse(self, number, k, value):
        kind = LAYOUTS[number][_KINDS + k]
        low, high = LOWS[kind], HIGHS[kind]
        if not self._clamp:
            place = "%s.%s" % (name(number), fields(number)[k][0])
            raise ValueError("%s = %d is outside %d..%d" % (place, value, low, high))
        self.clamped = (self.clamped + 1) & COUNT_MAX
        return low if value < low else high


class Counters:
    """What a Decoder met. Each frame that ends counts in exactly one of the first nine.

    messages   delivered                         crc       wrong checksum
    cobs       ended in the middle of a block    length    too short, or not as long as its type
    version    of another version                unknown   of an unknown type
    over_long  longer than any message           empty     a 0 right after a 0
    out_of_range  a field outside its range
    gaps       messages missing by their sequence numbers      repeats  the number before once more
    restarts   times that the sender began to count anew
    """

    NAMES = (
        "messages",
        "crc",
        "cobs",
        "length",
        "version",
        "unknown",
        "over_long",
        "empty",
        "out_of_range",
        "gaps",
        "repeats",
        "restarts",
    )
    __slots__ = NAMES

    def __init__(self):
        for counter in self.NAMES:
            setattr(self, counter, 0)

    def as_dict(self):
        return {counter: getattr(self, counter) for counter in self.NAMES}


class Decoder:
    """Finds messages in a stream that comes in pieces of any size.

    `on_message(type, sequence, values)` is called for each; `values`, one item per field, is reused with
    the next message of that type, and so are the bytearrays in it that stand for byte fields. Whatever
    is not a message is counted in `counters`, costs at most the frame it is in, and has no other effect.

    A sequence number that goes back is a sender that began anew, or, by less than LATE, a message that was
    overtaken. Numbers alone do not always tell: that the boot number of INFO and STATUS has changed, or has
    not, corrects what was counted since it was heard before.
    """

    def __init__(self, on_message):
        self.counters = Counters()
        self._on_message = on_message
        self._values = {}  # of what a camera sends, once it comes: another camera does without
        self._ranges = {}  # of what a board receives, as kernels.stream.unpack wants them
        self._stream = array("i", (0, 0, 1, 0))
        for number, layout in LAYOUTS.items():
            if number >= FIRST_COMMAND:
                self._values[number] = array("i", [0] * (len(layout) - _KINDS))
                if unpack:
                    self._ranges[number] = ranges_of(layout)
        self._message = bytearray(LIMIT + 1)
        self._sequence = -1
        self._boot = -1
        self._doubtful = 0  # missing at the last step past 65535 since the boot number was heard
        self._went_back = False  # that step was counted as a restart

    def feed(self, buffer, count):
        """Takes buffer[:count]; the work per byte is bounded, and no byte is looked at twice."""
        message, stream = self._message, self._stream
        stream[_PLACE] = 0
        while stream[_PLACE] < count:
            found = unstuff(0, 0, buffer, message, stream, count, CRC_TABLE)
            if found == _WELL:
                self._deliver(stream[_WHOLE])
            elif found:
                self._count_bad(found)

    def _count_bad(self, found):
        counters = self.counters
        if found == _EMPTY:
            counters.empty = (counters.empty + 1) & COUNT_MAX
        elif found == _OVER_LONG:
            counters.over_long = (counters.over_long + 1) & COUNT_MAX
        elif found == _COBS:
            counters.cobs = (counters.cobs + 1) & COUNT_MAX
        elif found == _SHORT:
            counters.length = (counters.length + 1) & COUNT_MAX
        elif found == _WRONG_CRC:
            counters.crc = (counters.crc + 1) & COUNT_MAX
        else:
            counters.version = (counters.version + 1) & COUNT_MAX

    def _deliver(self, size):
        counters = self.counters
        message = self._message
        sequence = message[2] | message[3] << 8
        if sequence and sequence == self._sequence + 1:
            self._sequence = sequence
        else:
            self._count_gap(sequence)
        number = message[1]
        layout = LAYOUTS.get(number)
        if layout is None:
            counters.unknown = (counters.unknown + 1) & COUNT_MAX
            return
        if size != layout[_BODY] + _HEADER + _CRC:
            counters.length = (counters.length + 1) & COUNT_MAX
            return
        values = self._values_of(number, layout)
        ranges = self._ranges.get(number)
        if ranges is None:
            is_good = self._unpack(layout, values)
        else:
            is_good = unpack(message, 0, ranges, values, len(values), _HEADER)
        if not is_good:
            counters.out_of_range = (counters.out_of_range + 1) & COUNT_MAX
            return
        counters.messages = (counters.messages + 1) & COUNT_MAX
        if number == INFO:
            self._hear_boot(values[_INFO_BOOT], sequence)
        elif number == STATUS:
            self._hear_boot(values[_STATUS_BOOT], sequence)
        self._on_message(number, sequence, values)

    def _values_of(self, number, layout):
        values = self._values.get(number)
        if values is None:
            kinds = layout[_KINDS:]
            values = [bytearray(SIZES[k]) if CODES[k] == _BYTES else 0 for k in kinds]
            self._values[number] = values
        return values

    def _count_gap(self, sequence):
        counters = self.counters
        last = self._sequence
        self._sequence = sequence
        if last < 0:
            return
        step = (sequence - last) & 0xFFFF
        if step == 0:
            counters.repeats = (counters.repeats + 1) & COUNT_MAX
        elif step > 0x10000 - LATE:
            self._sequence = last
            if counters.gaps:  # it was counted as missing
                counters.gaps -= 1
        elif step > 0x7FFF:
            counters.restarts = (counters.restarts + 1) & COUNT_MAX
            self._doubtful = step - 1
            self._went_back = True
        else:
            counters.gaps = (counters.gaps + step - 1) & COUNT_MAX
            if sequence < last:
                self._doubtful = step - 1
                self._went_back = False

    def _hear_boot(self, boot, sequence):
        """A message told the boot number of its sender: what was a restart, and what only looked like one."""
        counters = self.counters
        if self._boot >= 0:
            if boot == self._boot:
                if self._went_back:
                    counters.restarts = (counters.restarts - 1) & COUNT_MAX
                    counters.gaps = (counters.gaps + self._doubtful) & COUNT_MAX
            else:
                self._sequence = sequence
                if not self._went_back:
                    counters.restarts = (counters.restarts + 1) & COUNT_MAX
                    counters.gaps = (counters.gaps - self._doubtful) & COUNT_MAX
        self._boot = boot
        self._doubtful = 0
        self._went_back = False

    def _unpack(self, layout, values):
        message = self._message
        codes, lows, highs = CODES, LOWS, HIGHS
        place = _HEADER
        for k in range(len(values)):
            kind = layout[_KINDS + k]
            size = SIZES[kind]
            if codes[kind] == _BYTES:
                data = values[k]
                for j in range(size):
                    data[j] = message[place + j]
                place += size
                continue
            place += size
            value = message[place - 1]  # the highest byte first, while it says whether 30 bits suffice
            if codes[kind] >= _LOWER:
                value = (value ^ 0x80) - 0x80
            if size == 4:
                if not -64 <= value < 64:
                    return False
                value = value << 8 | message[place - 2]
                value = value << 8 | message[place - 3]
            if size >= 2:
                value = value << 8 | message[place - size]
            if not lows[kind] <= value <= highs[kind]:
                return False
            values[k] = value
        return True
