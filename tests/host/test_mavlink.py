"""The bytes that the real MicroPython writes as MAVLink are what pymavlink reads; also through the outbox."""

import math
import os
import pathlib
import subprocess

import pytest

from larics.device.outbox import Uptime
from larics.wire import messages as m
from larics.wire.codec import Decoder
from larics.wire.mavlink import MavlinkEncoder
from tests.host.test_dual import unix_port
from tests.host.waiting import PATIENCE_S
from wire_values import message_values

mavlink = pytest.importorskip("pymavlink.dialects.v20.common")

ROOT = pathlib.Path(__file__).resolve().parents[2]

DEVICE = """
import sys
from larics.wire import messages as m
from larics.device.outbox import Outbox, Uptime
from larics.wire.mavlink import MavlinkEncoder
from larics.wire.nmea import NmeaEncoder
from larics.wire.codec import Encoder

class Sink:
    def free(self):
        return 1024
    def send(self, buffer, count):
        sys.stdout.buffer.write(bytes(buffer[:count]))

class Answers:
    values = [77, m.PING]
    left = 1
    def next(self):
        self.left -= 1
        return m.ACK if self.left == 0 else 0
    def busy(self):
        return False

class Nothing:
    def next(self):
        return 0

uptime = Uptime()
measurements = NmeaEncoder() if "%s" == "nmea" else MavlinkEncoder(uptime, 5, 197, "ardupilot")
sources = (Answers(), Nothing())
outbox = Outbox(Sink(), Encoder(), sources, 921600, lambda new, old: new - old, measurements, uptime=uptime)
now = 0
for frame in range(3):
    outbox.begin()
    outbox.add(m.MARKER, %s[frame])
    outbox.add(m.POSE, %s[frame])
    outbox.commit(now)
    for _ in range(4):
        outbox.poll(now)
        now += 500000
outbox.status(m.STATUS, %s)
outbox.poll(now)
"""


def marker(frame, **given):
    return message_values(m.MARKER, frame=frame, age_us=20000, **given)


def pose(frame, **given):
    return message_values(m.POSE, frame=frame, age_us=20000, **given)


NEAR = {"x_mm10": 123456, "y_mm10": -789, "heading_cdeg": 9000, "sigma_x_mm10": 15, "sigma_cdeg": 120}
NEAR |= {"sigma_y_mm10": 300, "correlation_q14": 8192}
FAR = {"x_mm10": -m.COUNT_MAX, "y_mm10": m.COUNT_MAX, "heading_cdeg": 27000}
MARKERS = [
    marker(1, flags=m.MARKER_TRACKED, id=3, count=1, x_mm10=1234, y_mm10=-567, z_mm10=25000,
           heading_cdeg=9005, margin=200, radius_q8=7745),
    marker(2, flags=m.MARKER_NONE, id=m.ID_NONE),
    marker(3, id=3583, count=1, x_mm10=-1000000, y_mm10=1000000, z_mm10=-1, heading_cdeg=35999),
]  # fmt: skip
POSES = [
    pose(1, state=m.TRACKING, id=3, **NEAR),
    pose(2, state=m.COASTING, id=3, **NEAR),
    pose(3, state=m.TRACKING, id=3, sigma_x_mm10=m.SIGMA_UNKNOWN, sigma_cdeg=m.SIGMA_UNKNOWN, **FAR),
]
STATUS = message_values(m.STATUS, state=m.TRACKING)


def device(kind):
    script = DEVICE % (kind, MARKERS, POSES, STATUS)
    environment = dict(os.environ, MICROPYPATH="shared:.frozen")
    command = [*unix_port(), "-c", script]
    result = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, timeout=PATIENCE_S)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_pymavlink_reads_it():
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    everything = parser.parse_buffer(device("mavlink"))
    found = [message for message in everything if message.get_type() != "BAD_DATA"]
    assert [message.get_type() for message in found] == [
        "LANDING_TARGET",
        "VISION_POSITION_ESTIMATE",
        "LANDING_TARGET",
        "VISION_POSITION_ESTIMATE",
        "HEARTBEAT",
    ]
    assert [message.get_seq() for message in found] == [0, 1, 2, 3, 4]
    assert {(message.get_srcSystem(), message.get_srcComponent()) for message in found} == {(5, 197)}
    target, pose, far, unsure, heartbeat = found

    assert target.target_num == 3 and target.frame == mavlink.MAV_FRAME_BODY_FRD
    assert target.type == mavlink.LANDING_TARGET_TYPE_VISION_FIDUCIAL and target.position_valid == 1
    # a camera that looks down: its left is the vehicle's right, its up is down
    assert (target.x, target.y, target.z) == pytest.approx((0.1234, -0.0567, 2.5), rel=1e-7)
    assert target.distance == pytest.approx(math.hypot(0.1234, 0.0567, 2.5), rel=1e-3)
    assert target.angle_x == pytest.approx(math.atan2(-0.0567, 2.5), abs=4e-4)
    assert target.angle_y == pytest.approx(math.atan2(-0.1234, 2.5), abs=4e-4)
    half = math.radians(90.05) / 2
    sign = 1 if target.q[0] * math.cos(half) > 0 else -1  # q and -q are the same rotation
    assert [sign * item for item in target.q] == pytest.approx(
        [math.cos(half), 0, 0, math.sin(half)], abs=2e-4
    )
    assert target.time_usec == 0  # younger than the start: 20 ms before it
    assert far.time_usec == 4000000 - 20000
    assert (far.target_num, far.x, far.y) == (255, -100, 100) and far.z == pytest.approx(0.0001)
    assert (far.angle_x, far.angle_y) == pytest.approx((math.pi / 2, math.pi / 2), abs=2e-4)

    assert (pose.x, pose.y, pose.z) == pytest.approx((12.3456, 0.0789, 0), rel=1e-7)
    assert (pose.roll, pose.pitch) == (0, 0) and pose.yaw == pytest.approx(-math.pi / 2, abs=1e-6)
    variances = [pose.covariance[k] for k in (0, 6, 11, 15, 18, 20)]
    expected = [0.0015**2, 0.03**2, 0.03**2] + [math.radians(1.2) ** 2] * 3
    assert pose.covariance[1] == pytest.approx(-0.5 * 0.0015 * 0.03, rel=0.02)
    assert variances == pytest.approx(expected, rel=0.02)
    assert sum(map(bool, pose.covariance)) == 7
    assert (unsure.x, unsure.y) == pytest.approx((-107374.1823, -107374.1823), rel=1e-7)
    assert math.isnan(unsure.covariance[0]) and unsure.yaw == pytest.approx(math.pi / 2, abs=1e-6)

    assert heartbeat.type == mavlink.MAV_TYPE_ONBOARD_CONTROLLER
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_INVALID
    assert heartbeat.system_status == mavlink.MAV_STATE_ACTIVE and heartbeat.mavlink_version == 3


@pytest.mark.parametrize("kind", ["mavlink", "nmea"])
def test_answers_to_commands_are_found_among_other_encodings(kind):
    answers = []
    decoder = Decoder(lambda number, sequence, values: answers.append((number, list(values))))
    data = device(kind)
    decoder.feed(data, len(data))
    assert answers == [(m.ACK, [77, m.PING])]


def test_lines_stay_whole_beside_answers():
    lines = [line for line in device("nmea").split(b"\r\n") if b"$PLR" in line]
    assert len(lines) == 7
    for line in lines:
        body, check = line[line.index(b"$") + 1 :].split(b"*")
        expected = 0
        for byte in body:
            expected ^= byte
        assert int(check, 16) == expected


# ------------------------------------------------------------------ what the autopilots make of it
# formulas as in the sources named in docs/autopilots.md

POS_M_NSE, YAW_M_NSE = 0.2, 0.2  # ArduPilot's defaults of VISO_POS_M_NSE and VISO_YAW_M_NSE


def ardupilot_errors(message):
    """[(position error, angle error)] that older and newer versions give the EKF, m and rad."""
    c, found = message.covariance, []
    for combine in (
        lambda *variances: math.cbrt(sum(v * v for v in variances)),
        lambda *variances: math.sqrt(sum(variances)),
    ):
        position = angle = 0.0
        if not math.isnan(c[0]):
            position, angle = combine(c[0], c[6], c[11]), combine(c[15], c[18], c[20])
        found.append((min(max(position, POS_M_NSE), 100), min(max(angle, YAW_M_NSE), 1.5)))
    return found


def ardupilot_target(message):
    """The unit vector to the target, forward, right, down, or None when it is dropped."""
    if message.position_valid == 1:
        if message.frame != mavlink.MAV_FRAME_BODY_FRD or message.distance <= 0:
            return None
        vector = [value / message.distance for value in (message.x, message.y, message.z)]
    else:
        vector = [-math.tan(message.angle_y), math.tan(message.angle_x), 1.0]
        vector = [value / math.hypot(*vector) for value in vector]
    # AC_PrecLand takes only what lies below
    return vector if vector[2] > 0 else None


EVP_NOISE, EVA_NOISE = 0.1, 0.1  # newer defaults of EKF2_EVP_NOISE and EKF2_EVA_NOISE, m and rad


def px4_variances(message):
    """(of x, y, z; of roll, pitch, yaw) that EKF2 takes while EKF2_EV_NOISE_MD is 0."""
    found = []
    for places, noise in (((0, 6, 11), EVP_NOISE), ((15, 18, 20), EVA_NOISE)):
        told = [message.covariance[place] for place in places]
        known = all(map(math.isfinite, told))
        found.append([max(noise * noise, value if known else 0.0) for value in told])
    return found


class JitterCorrection:
    """ArduPilot's time of a message from its `usec` and its arrival, both in us."""

    def __init__(self, max_lag_ms=500, loops=100):
        self.max_lag_us, self.loops = max_lag_ms * 1000, loops
        self.offset = self.least = None
        self.count = 0

    def correct(self, offboard_us, local_us):
        lag = local_us - offboard_us
        if self.offset is None or lag < self.offset:
            self.offset = lag
        estimate = offboard_us + self.offset
        if estimate + self.max_lag_us < local_us:
            estimate = local_us - self.max_lag_us
            self.offset = estimate - offboard_us
        self.least = lag if self.count == 0 else min(self.least, lag)
        self.count += 1
        if self.count == self.loops:
            self.offset, self.count = self.least, 0
        return estimate


def px4_target(message):
    """ "pose", "critical" for a message to the pilot, or an IR-LOCK report's angles: right, back."""
    if message.position_valid and message.frame == mavlink.MAV_FRAME_LOCAL_NED:
        return "pose"
    if message.position_valid:
        return "critical"
    return message.angle_x, message.angle_y


def sent(target, *rows):
    """Messages as pymavlink reads them."""
    encoder = MavlinkEncoder(Uptime(), target=target)
    data = b""
    for number, values in rows:
        data += bytes(encoder.buffer[: encoder.encode(number, values)])
    return mavlink.MAVLink(None).parse_buffer(data) or []


def test_both_autopilots_believe_the_covariance():
    near, unsure = [message for message in sent("none", (m.POSE, POSES[0]), (m.POSE, POSES[2]))]
    for position, angle in ardupilot_errors(near):  # it was 10 to 21 m of position error
        assert (position, angle) == (POS_M_NSE, YAW_M_NSE)
    for position, angle in ardupilot_errors(unsure):
        assert (position, angle) == (POS_M_NSE, YAW_M_NSE)  # unknown: its own parameters
    wide = {"sigma_x_mm10": 5000, "sigma_y_mm10": 5000, "sigma_cdeg": 2000}
    (lost,) = sent("none", (m.POSE, pose(1, state=m.TRACKING, id=3, **(NEAR | wide))))
    for position, angle in ardupilot_errors(lost):  # half a metre is told as such
        assert 0.4 < position < 1.0 and 0.2 < angle < 0.7
    assert px4_variances(near) == px4_variances(unsure) == [[EVP_NOISE**2] * 3, [EVA_NOISE**2] * 3]
    position, angle = px4_variances(lost)
    assert position == pytest.approx([0.25] * 3, rel=0.02)
    assert angle == pytest.approx([math.radians(20) ** 2] * 3, rel=0.02)
    for index in (0, 6, 11, 15, 18, 20):  # a variance of 0 would be taken for certainty
        assert 0 < near.covariance[index] < 0.01


def test_the_reset_counter_counts_what_was_found_again():
    track, lost = pose(1, state=m.TRACKING, id=3, **NEAR), pose(2, state=m.LOST, id=m.ID_NONE, **NEAR)
    coast = pose(3, state=m.COASTING, id=3, **NEAR)
    rows = [(m.POSE, values) for values in (track, coast, track, lost, lost, track, lost, coast, track)]
    assert [message.reset_counter for message in sent("none", *rows)] == [0, 0, 1, 2]


def test_the_reset_counter_counts_a_pose_that_leaps():
    """A vehicle that is carried to another place is tracked there after a few frames, without being LOST."""

    def reset_counter(before, after, passed_us, max_speed_mm_s=500):
        uptime = Uptime()
        encoder = MavlinkEncoder(uptime, max_speed_mm_s=max_speed_mm_s)
        data = bytes(encoder.buffer[: encoder.encode(m.POSE, pose(1, state=m.TRACKING, id=3, **before))])
        uptime.advance(passed_us)
        encoder.encode(m.POSE, pose(2, state=m.COASTING, id=3, **before))
        data += bytes(encoder.buffer[: encoder.encode(m.POSE, pose(3, state=m.TRACKING, id=3, **after))])
        first, last = mavlink.MAVLink(None).parse_buffer(data)
        assert first.reset_counter == 0
        return last.reset_counter

    here = {"x_mm10": 1000, "y_mm10": -500, "heading_cdeg": 35900}
    for change, jumps in (
        ({"x_mm10": 2900}, 0),
        ({"x_mm10": 4000}, 1),
        ({"y_mm10": -3500}, 1),
        ({"heading_cdeg": 3000}, 0),
        ({"heading_cdeg": 9000}, 1),
    ):
        assert reset_counter(here, here | change, 50_000) == jumps, change
    assert reset_counter(here, here | {"x_mm10": 21_000}, 2_000_000) == 0  # 1 m/s for two seconds
    assert reset_counter(here, here | {"x_mm10": 30_000}, 2_000_000) == 1
    assert reset_counter(here, here | {"x_mm10": 30_000}, 2_000_000, max_speed_mm_s=2000) == 0
    far = {"x_mm10": -m.COUNT_MAX, "y_mm10": m.COUNT_MAX}
    assert reset_counter(far, {"x_mm10": m.COUNT_MAX, "y_mm10": m.COUNT_MAX}, 1000) == 1


def test_ardupilot_finds_the_time_of_exposure_but_for_the_least_way():
    """`usec` is the exposure: what jitters on the way is taken out, its least is left for VISO_DELAY_MS."""
    uptime, lag = Uptime(), JitterCorrection()
    encoder = MavlinkEncoder(uptime)
    boot_us, worst = 7_000_000_000, 0
    for frame in range(400):
        uptime.advance(16_667)
        age_us = 15_000 + frame * 7919 % 9000  # from the exposure to sending
        values = message_values(m.POSE, frame=frame, age_us=age_us, state=m.TRACKING, id=3, **NEAR)
        (message,) = mavlink.MAVLink(None).parse_buffer(
            bytes(encoder.buffer[: encoder.encode(m.POSE, values)])
        )
        now_us = boot_us + uptime.s * 1_000_000 + uptime.us
        found_us = lag.correct(message.usec, now_us + 11_000)  # the line
        if frame > 100:
            worst = max(worst, abs(found_us - (now_us - age_us) - (15_000 + 11_000)))
    assert worst < 500  # of 9 ms


def test_landing_targets_of_a_camera_that_looks_down():
    values = marker(5, id=3, count=1, x_mm10=1000, y_mm10=-2000, z_mm10=20000)
    assert sent("none", (m.MARKER, values)) == []
    (for_ardupilot,) = sent("ardupilot", (m.MARKER, values), (m.MARKER, values))  # one a frame
    forward, right, down = ardupilot_target(for_ardupilot)
    assert forward > 0 and right < 0 and down > 0.9
    (for_px4,) = sent("px4", (m.MARKER, values))
    image_x, image_y = px4_target(for_px4)
    assert math.tan(image_x) == pytest.approx(-0.1, abs=1e-3)
    assert math.tan(image_y) == pytest.approx(-0.05, abs=1e-3)
    # the same direction by both ways of ArduPilot
    assert ardupilot_target(for_px4) == pytest.approx([forward, right, down], abs=2e-3)
    for_ardupilot.z = -for_ardupilot.z  # what it was: above, and dropped
    assert ardupilot_target(for_ardupilot) is None
    assert px4_target(for_ardupilot) == "critical"
