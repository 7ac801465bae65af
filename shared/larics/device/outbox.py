"""What is to be sent, in order of urgency, on a line that may be slower than the frames.

The newest measurement wins: one that has not begun to be sent when the next is there is dropped and
counted; nothing queues up. Answers to commands and the status come between measurements, chunks of a
raw frame only in line time that nothing else needs. The outbox knows from the baud rate how much it
has given to the line, and never gives it more than `AHEAD_US` of work, so that what comes next starts
within one frame time whatever the driver buffers.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.device.measurements import MARKERS_MOST
from larics.wire.codec import MAX_FRAME, frame_size
from larics.wire.messages import AGE_UNKNOWN, COUNT_MAX, MARKER, POSE, RAW_CHUNK

# generated: begin indices (tools/make_protocol.py)
_MARKER_FIELDS = const(14)
_MARKER_AGE_US = const(1)
_POSE_FIELDS = const(15)
_POSE_AGE_US = const(1)
_POSE_MARKER_AGE_MS = const(2)
_MOTION_FIELDS = const(9)
# generated: end indices

AHEAD_US = const(16000)
_SECOND = const(1000000)
_CHUNKS_A_POLL = const(4)  # bounds the work of one call


class Uptime:
    """Time since start as seconds and microseconds, which never need a long integer. What is being encoded
    begins to be sent `ahead_us` later."""

    def __init__(self):
        self.s = 0
        self.us = 0
        self.ahead_us = 0

    def advance(self, elapsed_us):
        self.us += elapsed_us
        while self.us >= _SECOND:
            self.us -= _SECOND
            self.s += 1


class _Group:
    """The messages of one frame."""

    def __init__(self, size):
        self.numbers = [0] * size
        longest = max(_MARKER_FIELDS, _POSE_FIELDS, _MOTION_FIELDS)
        self.values = [[0] * longest for _ in range(size)]
        self.count = 0
        self.sent = 0
        self.ready = False
        self.commit_us = 0


class Outbox:
    """`poll` often; a frame's measurements go in by begin, add, commit.

    sink         object with free() -> bytes that fit, send(buffer, count); empty when given
    encoder      a larics.wire.codec.Encoder; answers are always sent by it
    measurements the encoder of measurements and status when that is another one (nmea, mavlink)
    sources      (answers, raw): objects with next() -> type number or 0, and `values`
    ticks_diff   difference of two clock readings in microseconds, as time.ticks_diff
    divider      send the measurements of every n-th frame
    uptime       an Uptime that poll advances, shared with encoders that tell the time

    `drops` counts the frames that were replaced before they began to be sent. `worst_age_us` is the largest
    age sent; set it to 0 to begin anew.
    """

    def __init__(
        self,
        sink,
        encoder,
        sources,
        baud,
        ticks_diff,
        measurements=None,
        divider=1,
        uptime=None,
    ):
        self.uptime = uptime or Uptime()
        self.divider = divider
        self.drops = 0
        self.worst_age_us = 0
        self._sink = sink
        self._encoder = encoder
        self._measurements = measurements or encoder
        self._answers, self._raw = sources
        self._ticks_diff = ticks_diff
        self._byte_us_q4 = 160000000 // baud
        self._chunk_us = (frame_size(RAW_CHUNK) * self._byte_us_q4) >> 4
        self._chunks = 0
        self._room = sink.free()
        self._largest = max(MAX_FRAME + 1, len(self._measurements.buffer))
        self._skipped = divider - 1
        self._waiting = _Group(MARKERS_MOST + 2)  # and POSE and MOTION
        self._sending = _Group(MARKERS_MOST + 2)
        self._status = None
        self._status_type = 0
        self._owed_us = 0  # line time of what was given to the sink and is not yet on the line
        self._now_us = None
        self._measured_last = False
        self._separator = b"\0"

    def begin(self):
        """Starts the measurements of a frame; False when the divider leaves this frame out."""
        self._skipped += 1
        if self._skipped < self.divider:
            return False
        self._skipped = 0
        if self._waiting.ready:
            self.drops = (self.drops + 1) & COUNT_MAX
        self._waiting.ready = False
        self._waiting.count = 0
        return True

    def add(self, number, values):
        """A MARKER, POSE or MOTION of this frame; values are copied, ages being those at commit. IndexError
        when a frame has more than MARKERS_MOST of the first and one of the others."""
        group = self._waiting
        place = group.count
        kept = group.values[place]
        for k in range(len(values)):
            kept[k] = values[k]
        group.numbers[place] = number
        group.count = place + 1

    def commit(self, now_us):
        self._waiting.commit_us = now_us
        self._waiting.ready = True

    def status(self, number, values):
        """A STATUS to send soon; `values` must stay unchanged until the next second."""
        self._status_type = number
        self._status = values

    def idle(self):
        """True when nothing urgent waits: the moment to restart."""
        group = self._sending
        return group.sent == group.count and not self._answers.busy()

    def empty(self):
        """True when the measurements of every frame so far were given to the sink."""
        return not self._waiting.ready and self.idle()

    def poll(self, now_us):
        """Gives the sink what the line can take now."""
        if self._now_us is not None:
            elapsed = max(0, self._ticks_diff(now_us, self._now_us))
            self._owed_us = max(0, self._owed_us - elapsed)
            self.uptime.advance(elapsed)
        self._now_us = now_us
        self._chunks = 0
        while self._ahead_us() <= AHEAD_US and self._sink.free() >= self._largest:
            if not self._send_one():
                break

    def _ahead_us(self):
        """Line time of what was given to the sink: by the clock, or what the sink still holds if more."""
        held = ((self._room - self._sink.free()) * self._byte_us_q4) >> 4
        return max(held, self._owed_us)

    def _send_one(self):
        group = self._sending
        if group.sent < group.count:
            self._send_measurement(group)
            return True
        if self._measured_last and self._send_answer():
            return True
        if self._waiting.ready:
            self._sending, self._waiting = self._waiting, group
            group.ready = False
            group.count = 0
            self._sending.sent = 0
            return True
        return self._send_answer() or self._send_chunk()

    def _send_measurement(self, group):
        place = group.sent
        values = group.values[place]
        number = group.numbers[place]
        self.uptime.ahead_us = self._ahead_us()
        waited = max(0, self._ticks_diff(self._now_us, group.commit_us) + self.uptime.ahead_us)
        if number == MARKER:
            values[_MARKER_AGE_US] = age = min(values[_MARKER_AGE_US], COUNT_MAX - waited) + waited
            self.worst_age_us = max(self.worst_age_us, age)
        elif number == POSE:
            values[_POSE_AGE_US] = min(values[_POSE_AGE_US], COUNT_MAX - waited) + waited
            age_ms = values[_POSE_MARKER_AGE_MS] + (waited + 999) // 1000
            values[_POSE_MARKER_AGE_MS] = min(age_ms, AGE_UNKNOWN)
        group.sent = place + 1
        self._measured_last = True
        count = self._measurements.encode(number, values)
        self._give(self._measurements.buffer, count)

    def _send_answer(self):
        """An answer or the status; False when none waits."""
        self._measured_last = False
        number = self._answers.next()
        if number:
            self._send_framed(number, self._answers.values)
            return True
        if self._status_type:
            number, self._status_type = self._status_type, 0
            self._give(self._measurements.buffer, self._measurements.encode(number, self._status))
            return True
        return False

    def _send_chunk(self):
        ahead = self._ahead_us()
        if self._chunks == _CHUNKS_A_POLL or (ahead and ahead + self._chunk_us > AHEAD_US):
            return False
        self._chunks += 1
        number = self._raw.next()
        if number:
            self._send_framed(number, self._raw.values)
        return number != 0

    def _send_framed(self, number, values):
        if self._measurements is not self._encoder:  # text may stand before it on the line
            self._give(self._separator, 1)
        self._give(self._encoder.buffer, self._encoder.encode(number, values))

    def _give(self, buffer, count):
        if count:
            self._sink.send(buffer, count)
            self._owed_us += (count * self._byte_us_q4) >> 4
