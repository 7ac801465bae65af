"""larics.locate.localizer and larics_vehicle.approach against plain floating-point motion."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from larics.locate.camera_model import Measurement
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.wire.messages import COASTING, ID_NONE, LOST, MARKER, MARKER_NONE, TRACKING
from larics_vehicle.approach import Approach
from tests.host.camera_model import angle_difference, rotation
from tests.host.small_int import Small
from wire_values import message_values

MARKERS = [(3, 0, 0, 90), (4, 2500, 0, 210), (7, 1250, 2165, 330), (5, 200, 900, 17)]


def measure(vehicle, marker, small=False):
    """What an exact camera measures of a marker from a vehicle (x, y in mm, heading in degrees)."""
    offset = rotation("z", -vehicle[2]) @ [marker[1] - vehicle[0], marker[2] - vehicle[1], 0]
    out = Measurement()
    kind = Small if small else int
    out.marker_id = marker[0]
    out.offset_x_mm10, out.offset_y_mm10 = kind(round(offset[0] * 10)), kind(round(offset[1] * 10))
    out.heading_cdeg = kind(round((marker[3] - vehicle[2]) * 100) % 36000)
    out.height_mm10 = out.ring_height_mm10 = kind(30000)
    return out


def localizer():
    return Localizer(MarkerMap([(m[0], m[1], m[2], m[3] * 100) for m in MARKERS]))


def in_view(vehicle, reach_mm=800):
    return [m for m in MARKERS if math.dist(m[1:3], vehicle[:2]) < reach_mm]


@settings(max_examples=60)
@given(x=st.floats(-500, 500), y=st.floats(-500, 500), heading=st.floats(0, 360), speed=st.floats(-400, 1500),
       turn=st.floats(-60, 60), period_us=st.sampled_from([16667, 33333, 357000]))  # fmt: skip
def test_poses_follow_an_arc(x, y, heading, speed, turn, period_us):
    """Tracked poses are exact to what the rounding of the measurement allows; coasting stays on the arc."""
    found, vehicle, last = localizer(), [x, y, heading], 0
    for k in range(60):
        step = period_us * 1e-6
        middle = math.radians(vehicle[2] + turn * step / 2)
        vehicle = [vehicle[0] + speed * step * math.cos(middle), vehicle[1] + speed * step * math.sin(middle),
                   vehicle[2] + turn * step]  # fmt: skip
        markers = in_view(vehicle)
        state = found.update([measure(vehicle, m) for m in markers], len(markers), k * period_us)
        assert found.fault == 0
        off = math.dist(vehicle[:2], (found.x_mm10 / 10, found.y_mm10 / 10))
        aside = abs(angle_difference(found.heading_cdeg / 100, vehicle[2]))
        if state == TRACKING:
            assert off < 0.45 and aside < 0.02
            # at few frames a second the first curves between them count as scatter
            assert found.sigma_mm10 <= (50 if period_us < 100000 else 600) and found.age_us == 0
        elif state == COASTING:
            # two markers in one frame give a pose, but no speed yet: sigma says so
            assert off < max(3 + 0.1 * abs(speed) * found.age_us * 1e-6, 0.3 * found.sigma_mm10)
            assert found.sigma_mm10 >= last
        else:
            assert found.sigma_mm10 == 65535
        last = found.sigma_mm10 if state != LOST else 0


@settings(max_examples=100)
@given(data=st.data())
def test_a_wrong_marker_never_moves_a_tracked_pose(data):
    """One or two frames in a row that put the vehicle elsewhere are refused, whatever they say."""
    found, vehicle = localizer(), [300.0, 300.0, 40.0]
    good = [measure(vehicle, MARKERS[0])]
    for k in range(10):
        found.update(good, 1, k * 50000)
    frames = data.draw(st.integers(1, 2))
    elsewhere = [data.draw(st.floats(low, high)) for low, high in ((-3e3, 3e3), (-3e3, 3e3), (0, 360))]
    wrong = measure(elsewhere, data.draw(st.sampled_from(MARKERS)))
    for k in range(frames):
        found.update([wrong], 1, (10 + k) * 50000)
        near = math.dist(vehicle[:2], (found.x_mm10 / 10, found.y_mm10 / 10))
        assert near < 150  # the gate: 50 mm, 6 sigma and what 5 m/s2 can do in a tenth of a second
        assert near < 1 or found.state == TRACKING or found.fault


@settings(max_examples=100)
@given(data=st.data())
def test_every_intermediate_is_a_small_integer(data):
    whole = lambda low, high: Small(data.draw(st.integers(low, high)))  # noqa: E731
    found = Localizer(MarkerMap([(1, -9999999, 9999999, 0), (2, 9999999, -9999999, 35999), (3, 0, 0, 0)]))
    time_us = Small(data.draw(st.integers(0, 1 << 29)))
    for _ in range(12):
        out = Measurement()
        out.marker_id = data.draw(st.integers(-1, 4))
        out.offset_x_mm10, out.offset_y_mm10 = whole(-(1 << 19), 1 << 19), whole(-(1 << 19), 1 << 19)
        out.heading_cdeg, out.height_mm10 = whole(0, 35999), whole(1, 262143)
        out.ring_height_mm10 = out.height_mm10 + whole(0, 1)
        for _ in range(data.draw(st.integers(1, 4))):
            time_us = time_us + whole(100, 1200000)
            found.update([out], 1, time_us)
            for name, value in vars(found).items():
                assert type(value) is not int or abs(value) < 1 << 30, name


def test_the_reference_behaviour_drives_a_triangle():
    """Three markers whose lines point to the next one, exact measurements 50 ms late: no search is needed,
    every marker is centred and left in turn."""
    marks = {3: (0, 0, 0), 4: (2500, 0, 120), 7: (1250, 2165, 240)}
    controller = Approach(stale_ms=300)
    vehicle, history, visits, states = [-400.0, 150.0, 75.0], [], [], set()
    for k in range(6000):
        history.append(list(vehicle))
        if k % 2 == 0 and k >= 3:
            then = history[k - 3]
            seen = [(i, m) for i, m in marks.items() if math.dist(m[:2], then[:2]) < 700]
            for i, m in seen:
                x, y, _ = rotation("z", -then[2]) @ [m[0] - then[0], m[1] - then[1], 0]
                heading = round((m[2] - then[2]) * 100) % 36000
                place = {"x_mm10": round(x * 10), "y_mm10": round(y * 10), "heading_cdeg": heading}
                values = message_values(MARKER, frame=k, age_us=50000, id=i, count=1, margin=255, **place)
                controller.on_message(MARKER, 0, values)
            if not seen:
                values = message_values(MARKER, frame=k, age_us=50000, flags=MARKER_NONE, id=ID_NONE)
                controller.on_message(MARKER, 0, values)
        before = controller.state
        state = controller.step(17)
        states.add(state)
        if state == 4 and before == 3:
            visits.append(controller.left_id)
            assert math.dist(vehicle[:2], marks[controller.left_id][:2]) < 40
        vehicle[2] += controller.turn_cdeg_s / 100 * 0.017
        vehicle[0] += controller.speed_mm_s * 0.017 * math.cos(math.radians(vehicle[2]))
        vehicle[1] += controller.speed_mm_s * 0.017 * math.sin(math.radians(vehicle[2]))
    assert len(visits) >= 5
    assert visits == [(3, 4, 7)[(k + (3, 4, 7).index(visits[0])) % 3] for k in range(len(visits))]
