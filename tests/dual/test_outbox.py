"""The outbox: the newest measurement wins, raw chunks only in leftover line time, nothing allocated."""

from larics.device.measurements import MARKERS_MOST
from larics.device.outbox import Outbox, Uptime
from larics.device.raw_frame import RawSender
from larics.device.tracking import Sighting
from larics.locate.camera_model import Measurement
from larics.marker.detection import FLAG_UNCONFIRMED, NO_ID
from larics.wire import codec as p
from larics.wire import messages as m
from larics.wire.mavlink import MavlinkEncoder
from wire_values import at, changed, message_values, named

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

FRAME_US = 16667


class Answers:
    def __init__(self):
        self.queue = []
        self.values = None

    def busy(self):
        return bool(self.queue)

    def next(self):
        if not self.queue:
            return 0
        number, self.values = self.queue.pop(0)
        return number


class Line:
    """A UART with a large transmit buffer that sends so many bits a second."""

    def __init__(self, baud, room=1024):
        self.byte_us = 10000000 // baud
        self.room = room
        self.now_us = 0
        self.free_at_us = 0
        self.sent = []  # (end us, bytes)

    def free(self):
        held_us = max(0, self.free_at_us - self.now_us)
        return self.room - (held_us + self.byte_us - 1) // self.byte_us

    def send(self, buffer, count):
        assert count <= self.free()
        self.free_at_us = max(self.now_us, self.free_at_us) + count * self.byte_us
        self.sent.append((self.free_at_us, bytes(buffer[:count])))

    def messages(self):
        """(type, when its last byte has been sent, values) of everything on the line."""
        found = []
        end_us = [0]
        decoder = p.Decoder(
            lambda number, _, values: found.append((number, end_us[0], named(number, values)))
        )
        for end_us[0], data in self.sent:
            decoder.feed(data, len(data))
        assert decoder.counters.messages == len(found) == len(self.sent)
        return found


def make(baud, line=None, **options):
    line = line or Line(baud)
    answers = Answers()
    raw = RawSender()
    outbox = Outbox(line, p.Encoder(clamp=True), (answers, raw), baud, lambda new, old: new - old, **options)
    return line, outbox, answers, raw


MARKER = message_values(
    m.MARKER, age_us=1000, id=3, count=1, x_mm10=100, y_mm10=-100, z_mm10=25000, heading_cdeg=9000,
    margin=200, radius_q8=7680,
)  # fmt: skip
POSE = message_values(
    m.POSE, age_us=1000, state=m.TRACKING, id=3, x_mm10=100000, y_mm10=200000, route_position=1
)


def run(line, outbox, frames, polls=8, markers=1, frame_us=FRAME_US):
    """So many frames with a MARKER for each marker and a POSE, and `polls` polls between frames."""
    for frame in range(frames):
        start = line.now_us
        pose = changed(m.POSE, POSE, frame=frame)
        if outbox.begin():
            for index in range(markers):
                outbox.add(m.MARKER, changed(m.MARKER, MARKER, frame=frame, index=index, count=markers))
            outbox.add(m.POSE, pose)
            outbox.commit(line.now_us)
        for k in range(polls):
            line.now_us = start + k * frame_us // polls
            outbox.poll(line.now_us)
        line.now_us = start + frame_us


def test_a_fast_line_sends_every_frame():
    for polls in (1, 8):
        line, outbox, _, _ = make(115200)
        run(line, outbox, 60, polls)
        found = line.messages()
        assert [number for number, _, _ in found] == [m.MARKER, m.POSE] * 60
        assert [values["frame"] for _, _, values in found] == [k // 2 for k in range(120)]
        assert outbox.drops == 0
        assert outbox.uptime.us in range(59 * FRAME_US - FRAME_US, 60 * FRAME_US)


def test_on_a_slow_line_the_newest_wins_and_drops_are_counted():
    line, outbox, _, _ = make(9600)
    run(line, outbox, 120)
    found = line.messages()
    frames = [values["frame"] for number, _, values in found if number == m.MARKER]
    assert frames == sorted(set(frames))
    assert 20 <= len(frames) <= 30 and frames[-1] >= 112
    assert outbox.drops + len(frames) in (118, 119, 120)  # one may be on its way, one wait
    for number, end_us, values in found:
        if number != m.MARKER:
            continue
        age_at_start = end_us - p.frame_size(number) * line.byte_us - values["frame"] * FRAME_US + 1000
        assert (
            abs(values["age_us"] - age_at_start) <= 2 * line.byte_us
        )  # told: the age at the start of sending
        assert values["age_us"] < 2 * FRAME_US + 17000
    ages = [values["age_us"] for number, _, values in found if number == m.MARKER]
    assert outbox.worst_age_us == max(ages)


def test_a_line_slower_than_its_baud_rate_does_not_queue():
    slow = Line(9600)
    line, outbox, _, _ = make(115200, slow)
    run(line, outbox, 120)
    found = [(end, values) for number, end, values in line.messages() if number == m.MARKER]
    ages = [values["age_us"] for _, values in found]
    late = [end - values["frame"] * FRAME_US for end, values in found]
    three_frames_us = 3 * (p.frame_size(m.MARKER) + p.frame_size(m.POSE)) * slow.byte_us
    assert len(ages) > 10 and max(late) < three_frames_us and outbox.drops > 60


def test_the_divider_leaves_frames_out_without_counting_drops():
    line, outbox, _, _ = make(115200, divider=3)
    run(line, outbox, 30)
    frames = [values["frame"] for number, _, values in line.messages() if number == m.MARKER]
    assert frames == list(range(0, 30, 3)) and outbox.drops == 0


def test_answers_and_status_pass_between_measurements():
    for baud in (9600, 115200):
        line, outbox, answers, _ = make(baud)
        status = [0] * len(p.fields(m.STATUS))
        for token in range(4):
            answers.queue.append((m.ACK, [token, m.PING]))
        outbox.status(m.STATUS, status)
        run(line, outbox, 120, markers=3)
        found = [number for number, _, _ in line.messages()]
        assert found.count(m.ACK) == 4 and found.count(m.STATUS) == 1
        assert not answers.busy()


def test_a_raw_frame_does_not_hold_up_markers():
    for baud, polls in ((57600, 8), (115200, 1), (115200, 8), (921600, 1), (921600, 8)):
        quiet, outbox, _, _ = make(baud)
        run(quiet, outbox, 80, polls)
        line, outbox, _, raw = make(baud)
        pixels = bytearray([k * k * 403 % 65521 >> 7 & 255 for k in range(16 * 1500)])  # cannot be packed
        raw.start(5, pixels, 16, 1500, 0)
        run(line, outbox, 80, polls)
        chunks = [values["first"] for number, _, values in line.messages() if number == m.RAW_CHUNK]
        assert chunks == [64 * k for k in range(len(chunks))] and len(chunks) >= (3 if baud == 57600 else 15)
        if baud == 921600:
            assert len(chunks) >= (79 if polls == 1 else 300)
        without = {values["frame"]: end for number, end, values in quiet.messages() if number == m.MARKER}
        with_raw = {values["frame"]: end for number, end, values in line.messages() if number == m.MARKER}
        assert sorted(with_raw) == list(range(80)) and outbox.drops == 0
        for frame in with_raw:
            assert with_raw[frame] - without[frame] < FRAME_US


def test_a_poll_gives_four_chunks_at_most_however_fast_the_line():
    line, outbox, _, raw = make(10000000)
    raw.start(5, bytearray(64 * 64), 64, 64, 0)
    for polls in (1, 2, 3):
        outbox.poll(line.now_us)
        assert len(line.sent) == 4 * polls
        line.now_us += 16000


def test_uptime_in_seconds_and_microseconds():
    uptime = Uptime()
    for elapsed_us, expected in ((999999, (0, 999999)), (1, (1, 0)), (2500000, (3, 500000))):
        uptime.advance(elapsed_us)
        assert (uptime.s, uptime.us) == expected


def test_a_marker_is_in_sight_coasts_and_is_lost():
    marker = Measurement()
    for seen, ms, state in (
        (1, 999, m.TRACKING),  # no frame since
        (1, 1000, m.LOST),
        (2, 499, m.COASTING),  # frames without it
        (2, 500, m.LOST),
    ):
        sighting = Sighting()
        for frame in range(seen):
            marker.marker_id = NO_ID if frame else 3
            sighting.update([marker], 1, 7000)
        assert sighting.state(7000 + ms) == state, (seen, ms)
    sighting = Sighting()
    for marker_id, flags, state in ((3, FLAG_UNCONFIRMED, m.LOST), (NO_ID, 0, m.LOST), (3, 0, m.TRACKING)):
        marker.marker_id, marker.flags = marker_id, flags
        sighting.update([marker], 1, 7000)
        assert sighting.state(7000) == state, (marker_id, flags)


def test_all_markers_that_a_frame_can_have_fit_beside_the_pose():
    line, outbox, _, _ = make(921600)
    run(line, outbox, 1, markers=MARKERS_MOST)
    found = line.messages()
    assert [values["index"] for number, _, values in found if number == m.MARKER] == list(range(MARKERS_MOST))
    assert found[-1][0] == m.POSE and len(found) == MARKERS_MOST + 1


def times_us(line):
    """The times in the MAVLink 2 messages that tell one."""
    found = []
    for _, data in line.sent:
        if data[0] == 0xFD and data[7] in (149, 102):  # LANDING_TARGET, VISION_POSITION_ESTIMATE
            found.append(sum([data[10 + k] << 8 * k for k in range(8)]))
    return found


def test_mavlink_messages_of_a_frame_have_its_one_time():
    for polls in (4, 8):
        uptime = Uptime()
        line, outbox, _, _ = make(
            115200, uptime=uptime, measurements=MavlinkEncoder(uptime, target="ardupilot")
        )
        line.now_us = 5000000
        outbox.poll(line.now_us)
        uptime.s, uptime.us = 5, 0
        run(line, outbox, 12, polls, markers=3, frame_us=100000)
        found = times_us(line)
        assert len(found) == 2 * 12  # one target, and the position
        for frame in range(12):
            taken_us = 5000000 + 100000 * frame - MARKER[at(m.MARKER, "age_us")]
            assert found[2 * frame : 2 * frame + 2] == [taken_us] * 2, (polls, frame)


def test_idle_tells_when_a_restart_is_possible():
    line, outbox, answers, _ = make(115200)
    answers.queue.append((m.ACK, [1, m.RESTART]))
    assert not outbox.idle()
    outbox.poll(0)
    assert outbox.idle() and line.messages()[0][0] == m.ACK


class Nowhere:
    def __init__(self):
        self.count = 0

    def free(self):
        return 1024

    def send(self, buffer, count):
        self.count += count


def test_nothing_is_allocated_for_a_frame():
    line = Nowhere()
    line, outbox, _, raw = make(115200, line)
    raw.start(5, bytearray(6400), 80, 80, 0)
    marker, pose = list(MARKER), list(POSE)

    def work(now):
        for _ in range(10):
            now += FRAME_US
            if outbox.begin():
                outbox.add(m.MARKER, marker)
                outbox.add(m.POSE, pose)
                outbox.commit(now)
            outbox.poll(now)
            outbox.poll(now + 5000)
        return now

    now = work(0)
    before = line.count
    heap_lock()
    try:
        work(now)
    finally:
        heap_unlock()
    assert line.count - before > 10 * 80
