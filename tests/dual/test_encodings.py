"""NMEA-style text and MAVLink: what the bytes say, exact floats from integers, no allocation."""

import struct

from larics.arith.float32 import put_float32, put_nan32
from larics.device.outbox import Uptime
from larics.settings import Settings
from larics.wire import codec as p
from larics.wire import messages as m
from larics.wire.encodings import measurement_encoder
from larics.wire.mavlink import MavlinkEncoder
from larics.wire.nmea import LONGEST, NmeaEncoder
from wire_values import at, changed, message_values

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

MARKER = message_values(
    m.MARKER, frame=7, age_us=16650, flags=m.MARKER_TRACKED, id=3, count=1, x_mm10=1234, y_mm10=-56,
    z_mm10=25000, heading_cdeg=9005, margin=200, radius_q8=7745, sigma_q12=41, sigma_mdeg=8,
)  # fmt: skip
NOTHING = {"id": m.ID_NONE, "sigma_q12": m.SIGMA_UNKNOWN, "sigma_mdeg": m.SIGMA_UNKNOWN}
NONE = message_values(m.MARKER, frame=8, age_us=100, flags=m.MARKER_NONE, **NOTHING)
POSE = message_values(
    m.POSE, frame=7, age_us=16650, marker_age_ms=17, state=m.TRACKING, id=3583, x_mm10=-10000005, y_mm10=20,
    heading_cdeg=35999, sigma_x_mm10=15, sigma_y_mm10=300, correlation_q14=-8192, sigma_cdeg=120,
    way_mm=m.WAY_UNKNOWN, route_position=m.ROUTE_NONE, next_cdeg=m.DIRECTION_NONE,
)  # fmt: skip


def limits(number, which):
    return [field[which] for field in p.fields(number)]


def text(encoder, number, values):
    line = bytes(encoder.buffer[: encoder.encode(number, values)]).decode()
    body, check = line[1:].split("*")
    expected = 0
    for character in body:
        expected ^= ord(character)
    assert line[0] == "$" and check == "%02X\r\n" % expected
    return body


def test_lines_of_text():
    encoder = NmeaEncoder()
    assert (
        text(encoder, m.MARKER, MARKER) == "PLRCM,7,16.6,4,3,0,1,123.4,-5.6,2500.0,90.05,200,30.2,0.010,0.008"
    )
    assert text(encoder, m.MARKER, NONE) == "PLRCM,8,0.1,32,,0,0,,,,,,,,"
    no_offset = changed(m.MARKER, MARKER, flags=m.MARKER_NO_OFFSET)
    assert text(encoder, m.MARKER, no_offset) == "PLRCM,7,16.6,64,3,0,1,,,,90.05,200,30.2,0.010,0.008"
    place = "-1000000.5,2.0,359.99"
    assert text(encoder, m.POSE, POSE) == "PLRCP,7,16.6,17,T,3583," + place + ",1.5,30.0,-0.500,1.20,,,"
    unsure = {"sigma_x_mm10": 65535, "sigma_cdeg": 65535, "marker_age_ms": 65535, "id": m.ID_NONE}
    full = changed(m.POSE, POSE, state=m.CARRIED, route_position=4, next_cdeg=5, way_mm=70, **unsure)
    assert text(encoder, m.POSE, full) == "PLRCP,7,16.6,,O,," + place + ",,,,,70,4,0.05"
    motion = message_values(
        m.MOTION, frame=7, state=1, epoch=9, x_mm10=-15, y_mm10=7, heading_cdeg=9005, way_mm10=70,
        turn_cdeg=5, odometry_age_us=1900,
    )  # fmt: skip
    assert text(encoder, m.MOTION, motion) == "PLRCO,7,1,9,-1.5,0.7,90.05,7.0,0.05,1.9"
    status = list(range(1, 1 + len(p.fields(m.STATUS))))
    status[at(m.STATUS, "state")] = 1
    assert text(encoder, m.STATUS, status) == (
        "PLRCS,1.2.3,5,6,7,8,9,10,11,12,13,14,15,C,17,0.18,19,0.20,21,22,23,24,25,26,27,28,29,30"
    )
    assert encoder.encode(m.ACK, [1, 2]) == 0


def test_what_is_unknown_stays_empty():
    encoder = NmeaEncoder()
    lost = message_values(
        m.POSE, frame=7, age_us=9000, marker_age_ms=m.AGE_UNKNOWN, state=m.LOST, id=m.ID_NONE,
        x_mm10=m.PLACE_UNKNOWN, y_mm10=m.PLACE_UNKNOWN, heading_cdeg=m.HEADING_UNKNOWN,
        sigma_x_mm10=m.SIGMA_UNKNOWN, sigma_y_mm10=m.SIGMA_UNKNOWN, sigma_cdeg=m.SIGMA_UNKNOWN,
        way_mm=m.WAY_UNKNOWN, route_position=m.ROUTE_NONE, next_cdeg=m.DIRECTION_NONE,
    )  # fmt: skip
    assert text(encoder, m.POSE, lost) == "PLRCP,7,9.0,,L" + 11 * ","
    status = message_values(
        m.STATUS, grey_mean=m.GREY_UNKNOWN, rate_chz=m.RATE_UNKNOWN, frame_us=m.TIME_UNKNOWN,
        detect_us=m.TIME_UNKNOWN, latency_us=m.TIME_UNKNOWN, free_bytes=9,
    )  # fmt: skip
    assert ",0,0.00,,,,,,9,0,0" in text(encoder, m.STATUS, status)


def test_the_longest_lines_fit():
    encoder = NmeaEncoder()
    for number in (m.MARKER, m.POSE, m.MOTION, m.STATUS):
        for which in (3, 4):
            values = limits(number, which)
            if number == m.MARKER:
                values = changed(number, values, flags=0, id=65534, sigma_q12=65534, sigma_mdeg=65534)
            if number == m.POSE:
                values = changed(number, values, route_position=65534, next_cdeg=35999, id=65534)
                values = changed(number, values, marker_age_ms=65534, way_mm=65534, sigma_cdeg=65534)
                values = changed(number, values, sigma_x_mm10=65534, sigma_y_mm10=65534)
            assert encoder.encode(number, values) <= LONGEST


def as_float(numerator, denominator):
    buffer = bytearray(4)
    put_float32(buffer, 0, numerator, denominator)
    return bytes(buffer)


def test_floats_are_those_of_struct():
    for denominator in (1, 7, 10000, 16384, 1000000, 1562500, 12500000, 16777215):
        numbers = [0, 1, 2, 3, 5, 9999, 10001, 16777215, 16777217, 16777219, 33554433, (1 << 30) - 1]
        state = 12345
        for _ in range(60):
            state = (state * 69069 + 1) % 4294967296
            numbers.append(state >> 2 + state % 29)
        for numerator in numbers:
            for value in (numerator, -numerator):
                if value == 0:
                    expected = bytes(4)
                else:
                    expected = struct.pack("<f", value / denominator)
                assert as_float(value, denominator) == expected, (value, denominator)
    buffer = bytearray(4)
    put_nan32(buffer, 0)
    nan = struct.unpack("<f", buffer)[0]
    assert nan != nan


def test_mavlink_leaves_out_what_it_cannot_say():
    encoder = MavlinkEncoder(Uptime())
    assert encoder.encode(m.MARKER, MARKER) == 0  # the camera looks up: there is nothing to land on
    encoder = MavlinkEncoder(Uptime(), target="ardupilot")
    for flag in (1, 2, 32, 64):
        assert encoder.encode(m.MARKER, changed(m.MARKER, MARKER, flags=flag)) == 0
    for state in (m.LOST, m.COASTING):
        assert encoder.encode(m.POSE, changed(m.POSE, POSE, state=state)) == 0
    assert encoder.encode(m.ACK, [1, 2]) == 0
    assert encoder.sequence == 0
    size = encoder.encode(m.MARKER, MARKER)
    assert size == 72 and encoder.buffer[0] == 0xFD and encoder.sequence == 1
    assert encoder.encode(m.MARKER, MARKER) == 0  # one target a frame


def test_the_settings_reach_the_encoder():
    chosen = {"output": "mavlink", "mavlink_target": "px4", "max_speed_mm_s": 1234, "mavlink_system": 9}
    encoder = measurement_encoder(Settings(chosen), Uptime())
    encoder.encode(m.MARKER, MARKER)
    assert encoder._max_speed_mm_s == 1234 and encoder.buffer[5] == 9 and encoder.sequence == 1
    assert isinstance(measurement_encoder(Settings({"output": "nmea"}), Uptime()), NmeaEncoder)
    assert measurement_encoder(Settings({}), Uptime()) is None


def test_nothing_is_allocated():
    uptime = Uptime()
    uptime.s = 100000000
    status = [1] * len(p.fields(m.STATUS))
    low, high = [], []
    for limit, found in ((3, low), (4, high)):
        pose = changed(m.POSE, limits(m.POSE, limit), state=m.TRACKING)
        pose = changed(m.POSE, pose, sigma_x_mm10=65534, sigma_y_mm10=65534, sigma_cdeg=65534)
        found.extend([changed(m.MARKER, limits(m.MARKER, limit), flags=0), pose])
    pairs = (
        (m.MARKER, low[0]),
        (m.MARKER, high[0]),
        (m.POSE, low[1]),
        (m.POSE, high[1]),
        (m.STATUS, status),
        (m.MARKER, MARKER),
        (m.POSE, POSE),
    )
    for encoder in (NmeaEncoder(), MavlinkEncoder(uptime, target="px4")):
        for number, values in pairs:
            encoder.encode(number, values)
        total = 0
        heap_lock()
        try:
            for number, values in pairs:
                total += encoder.encode(number, values)
        finally:
            heap_unlock()
        assert total > 300
