"""The closed loop: vehicle, field, firmware as a process, scores; and one short drive of everything."""

import json
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from larics.marker.far_apart import FAR_APART_IDS
from larics.settings import Settings
from larics.wire import messages as m
from larics.wire.codec import Decoder
from larics_host import cli
from larics_host.calibration import mounting
from larics_host.connection.records import record_of
from larics_host.drive import c_controller, command, encoders, field, score
from larics_host.drive.firmware import Firmware
from larics_host.drive.simulation import Frame, Sight, Simulation, Trace, judge, wheel_controller
from larics_host.drive.vehicle import STEP_S, Drivetrain, Vehicle
from larics_host.errors import UserError
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.view import render_view
from larics_vehicle.approach import CENTER
from tests.host.camera_model import DEFAULT_MOUNTING, angle_difference, rotation

SILENT = Drivetrain(bias=0.0, noise=0.0)

# ------------------------------------------------------------------ vehicle


def test_without_noise_the_vehicle_does_as_told_after_its_delay():
    vehicle = Vehicle(Pose(0, 0, 90), np.random.default_rng(1), SILENT)
    for _ in range(round(SILENT.delay_s / STEP_S)):
        vehicle.step(300.0, 0.0)
        assert vehicle.way_mm == 0
    for _ in range(round(3 / STEP_S)):
        vehicle.step(300.0, 0.0)
    assert vehicle.pose.x_mm == pytest.approx(0, abs=1e-6)
    assert vehicle.pose.y_mm == pytest.approx(900 - 300 * SILENT.lag_s, rel=0.01)
    for _ in range(round(2 / STEP_S)):
        vehicle.step(0.0, 45.0)
    assert vehicle.motion.turn_deg_s == pytest.approx(45.0)
    assert abs(vehicle.motion.forward_mm_s) < 1e-6


def test_wheel_noise_makes_it_stray_and_a_push_moves_it():
    ends = []
    for seed in range(30):
        vehicle = Vehicle(Pose(0, 0, 0), np.random.default_rng(seed))
        for _ in range(round(10 / STEP_S)):
            vehicle.step(200.0, 0.0)
        ends.append(vehicle.pose.y_mm)
    assert 10 < np.std(ends) < 200  # millimetres aside after 2 m
    vehicle = Vehicle(Pose(100, 0, 90), np.random.default_rng(1), SILENT)
    vehicle.push(10, 20, -30)
    assert (vehicle.pose.x_mm, vehicle.pose.y_mm) == pytest.approx((80, 10))
    assert vehicle.pose.heading_deg == pytest.approx(60)


def test_encoders_see_all_but_the_bias_and_commands_see_less():
    ways = {}
    for name, train in (("bias", replace(SILENT, bias=0.01)), ("noise", replace(SILENT, noise=0.05))):
        vehicle, ways[name] = Vehicle(Pose(), np.random.default_rng(4), train), np.zeros(3)
        for _ in range(400):
            before_mm = vehicle.way_mm
            vehicle.step(200.0, 0.0)
            told = (vehicle.way_mm - before_mm, vehicle.rolled_mm.mean(), vehicle.commanded_mm.mean())
            ways[name] += told
    assert abs(ways["bias"][1] - ways["bias"][0]) > 0.5 and ways["bias"][1] == pytest.approx(ways["bias"][2])
    assert ways["noise"][1] == pytest.approx(ways["noise"][0]) and abs(np.diff(ways["noise"])[1]) > 0.5


# ------------------------------------------------------------------ odometry


@pytest.mark.parametrize("sender", ["c", "python"])
def test_what_the_vehicle_sends(sender):
    if sender == "c" and c_controller.compiler() is None:
        pytest.skip("no C compiler: apt-get install gcc")
    made = wheel_controller(field.CONDITIONS["steady"]) if sender == "c" else encoders.PythonSender()
    options = encoders.Encoders(rate_hz=50, clock_ppm=10000, ahead_us=(1 << 30) - 500_000, delay_s=0.1)
    talk = encoders.Talk(made, options, np.random.default_rng(2), 115200, 300.0)
    vehicle = Vehicle(Pose(), np.random.default_rng(1), SILENT)
    for k in range(400):
        vehicle.step(500.0, 30.0)
        talk.step(vehicle, (k + 1) * STEP_S)
    assert not talk.until(0.1)  # what is sent takes a while
    found, arrived_us = [], []
    decoder = Decoder(lambda number, _, values: found.append(record_of(number, values)))
    for time_us, data in talk.until(2.2):
        decoder.feed(data, len(data))
        arrived_us.append(time_us)
    assert len(found) == len(arrived_us) == 101 and not talk.until(3.0)
    for message, time_us in zip(found, arrived_us, strict=True):
        sent_us = (message.time_us + message.age_us + 500_000) % (1 << 30) / 1.01
        assert 0 <= message.age_us < 4100 and time_us - sent_us == pytest.approx(102_604, abs=2)
    last = found[-1]
    assert last.x_mm10 / 10 == pytest.approx(vehicle.pose.x_mm, abs=0.5)
    assert last.y_mm10 / 10 == pytest.approx(vehicle.pose.y_mm, abs=0.5)
    assert last.heading_cdeg / 100 == pytest.approx(vehicle.pose.heading_deg, abs=0.02)


# ------------------------------------------------------------------ field


def test_the_published_field():
    places = field.triangle(2000.0)
    assert sorted(places) == [3, 4, 7]
    assert field.draw_field("sunny", 1).markers == places
    assert set(field.draw_field("sunny-coded", 1).markers) == set(field.CODED_IDS) <= set(FAR_APART_IDS)
    ids = list(places)
    for here, there in zip(ids, ids[1:] + ids[:1], strict=True):
        x, y, heading = places[here]
        dx, dy = places[there][0] - x, places[there][1] - y
        assert math.hypot(dx, dy) == pytest.approx(2000, abs=2)
        assert abs(angle_difference(math.degrees(math.atan2(dy, dx)), heading)) < 0.05


@pytest.mark.parametrize("name", field.CONDITIONS)
def test_every_condition_has_valid_settings_and_draws_the_same_twice(name):
    first, second = field.draw_field(name, 3), field.draw_field(name, 3)
    Settings(first.settings)
    assert first.settings == second.settings and first.start == second.start
    assert len(first.scene.plates) == (2 if first.condition.missing else 3)
    times = [event.at_s for event in first.events]
    assert times == sorted(times) and bool(times) == (name in ("pushed", "lights"))


def test_light_can_be_switched():
    lit = field.draw_field("lights", 3)
    assert lit.light(12.0).contrast < 0.3 * lit.light(9.0).contrast
    assert lit.light(21.0).contrast > 3 * lit.light(19.0).contrast
    longer, louder = lit.light(12.0, 3 * lit.camera.exposure_us), lit.light(12.0, gain=3.0)
    assert longer.contrast == pytest.approx(3 * lit.light(12.0).contrast) == louder.contrast
    assert longer.read_noise == lit.sensor.read_noise < louder.read_noise


def test_what_was_not_measured_is_null_in_json():
    values = {"a": float("nan"), "b": [1, float("nan"), {"c": (0.5,)}]}
    assert command._without_nan(values) == {"a": None, "b": [1, None, {"c": [0.5]}]}


def test_names_of_the_command_are_those_of_the_field():
    assert tuple(field.CONDITIONS) == command.CONDITION_NAMES


def test_the_renderers_lean_in_the_angles_of_the_settings():
    for tilt, towards, turned in ((0, 0, 30), (1, 77, 0), (12, 200, 140), (20, 315, -60)):
        camera = Camera(tilt_deg=tilt, tilt_direction_deg=towards, mounting_deg=turned)
        mount, forward, left = mounting.angles(camera.rotation)
        ours = rotation("y", forward) @ rotation("x", -left) @ rotation("z", mount) @ DEFAULT_MOUNTING
        assert np.allclose(ours, camera.rotation, atol=1e-9)
        assert np.allclose(mounting.rotation(mount, forward, left), camera.rotation, atol=1e-9)


# ------------------------------------------------------------------ firmware


def frames_of_a_field():
    drawn = field.draw_field("steady", 1100)
    x, y, heading = drawn.markers[3]
    for index in range(6):
        pose = Pose(x - 200 + 20 * index, y + 30, heading + 5 * index)
        yield (
            drawn,
            render_view(drawn.scene, pose, Motion(200.0), drawn.camera, drawn.light(0.0), drawn.noise)[0],
            pose,
        )


def test_both_interpreters_report_the_same_over_the_wire():
    shots = list(frames_of_a_field())
    reports = {}
    for interpreter in command.INTERPRETERS:
        with Firmware(shots[0][0].settings, interpreter) as firmware:
            reports[interpreter] = [
                (number, values)
                for index, (_, picture, _) in enumerate(shots)
                for number, _, values in firmware.exchange(picture, index, index * 100000)
                if number in (m.MARKER, m.POSE)
            ]
            assert firmware.line_errors == 0
    assert reports["micropython"] == reports["cpython"]
    poses = [values for number, values in reports["cpython"] if number == m.POSE]
    assert [pose.frame for pose in poses] == list(range(6))
    assert poses[-1].state == m.TRACKING
    true = shots[-1][2]
    assert math.hypot(poses[-1].x_mm10 / 10 - true.x_mm, poses[-1].y_mm10 / 10 - true.y_mm) < 3
    assert abs((poses[-1].heading_cdeg / 100 - true.heading_deg + 180) % 360 - 180) < 0.3


def test_a_firmware_that_cannot_start_says_why():
    with pytest.raises(UserError, match="map has marker 3 twice"):
        Firmware({"map": [[3, 0, 0, 0, 0, 0], [3, 5, 0, 0, 0, 0]]}, "micropython")


def test_a_firmware_that_is_ended_from_outside_says_so():
    drawn = field.draw_field("steady", 1100)
    with Firmware(drawn.settings, "micropython") as firmware:
        firmware._process.kill()
        firmware._process.wait()
        with pytest.raises(UserError, match="the firmware stopped: ended by signal 9"):
            firmware.exchange(np.zeros((296, 360), np.uint8), 0, 0)


# ------------------------------------------------------------------ scores


def test_judging_a_frame():
    places = [(3, 100.0, 100.0, True), (4, 10.0, 10.0, False)]
    assert judge([(3, 101, 99)], places, 15) == Sight(right=1)
    assert judge([(7, 101, 99)], places, 15) == Sight(wrong=1)
    assert judge([(-1, 101, 99), (m.ID_NONE, 99, 99)], places, 15) == Sight(unsure=2)
    assert judge([(4, 12, 9), (5, 200, 200)], places, 15) == Sight(cut=1, false=1)
    assert judge([(5, 12, 9)], places, 15) == Sight(cut=1, cut_wrong=1)
    assert judge([], places, 15) == Sight()


def recorded(visits, pushes=(), name="steady"):
    trace = Trace(field.draw_field(name, 3))
    trace.visits = [(10.0 * k, marker_id, 1.0) for k, marker_id in enumerate(visits)]
    trace.pushes = list(pushes)
    return trace


def test_laps():
    for visits, expected in (
        ((), (0, 0)),
        ((3, 4), (0, 0)),
        ((3, 4, 7, 3), (1, 1)),
        ((4, 7, 3, 4, 7, 3, 4, 7, 3), (2, 2)),
        ((3, 7, 3, 4, 7, 3), (2, 1)),
        ((3, 4, 3, 4, 7), (1, 0)),
    ):
        assert score.laps(recorded(visits)) == expected, visits
    assert score.laps(recorded((3, 7, 3, 7, 3), name="missing")) == (2, 2)  # 4 does not hang there


def test_recovery_is_timed_from_a_push():
    trace = recorded((3, 4, 7), pushes=(12.0,))
    for time_s, state, off in ((11.0, m.TRACKING, 0.1), (13.0, m.TRACKING, 300.0), (15.0, m.TRACKING, 2.0)):
        trace.frames.append(
            Frame(time_s, 0, 0, 0, 1, state, (0, 0, 0), (off, 0.1), 1.0, 3, 0, 0, {"wire": Sight(right=1)})
        )
    assert score.recoveries(trace) == ([3.0], [8.0])
    result = score.score(trace)
    assert result.tracking_mm.max == 300.0 and result.methods["wire"].right_share == 1.0
    assert score.recoveries(recorded((3, 4, 3))) == ([], [10.0])


# ------------------------------------------------------------------ everything together


def test_a_short_drive(tmp_path):
    folder = tmp_path / "drive"
    arguments = ["--condition", "steady", "--seconds", "9", "--seed", "1100", "-o", str(folder)]
    arguments += ["--odometry", "encoders", "--odometry-late-ms", "20", "--clock-ppm", "10000"]
    assert cli.main(["simulate", "--drive", "loop", *arguments]) == 0
    result = json.loads((folder / "score.json").read_text())
    wire = result["methods"]["wire"]
    assert wire["frames"] == 180 and wire["markers"] > 100
    assert wire["right"] >= 0.98 * wire["markers"] and wire["other"] == wire["cut_wrong"] == 0
    assert result["tracking_mm"]["median"] < 0.5 and result["tracking_mm"]["p95"] < 3
    assert result["tracking_deg"]["median"] < 0.1
    assert result["visits"] >= 1 and result["centred_mm"]["max"] < 40
    assert result["line_errors"] == 0
    assert result["states"]["carried"] > 0.1 and result["states"]["coasting"] == 0
    assert result["coasting_mm"]["max"] < 15 and result["faults"] == 0
    assert len((folder / "frames.csv").read_text().splitlines()) == 181
    for name in ("path.png", "strip.png"):
        picture = cv2.imread(str(folder / name))
        assert picture.shape[1] > 500 and picture.std() > 10


def test_the_firmware_proves_itself_to_the_vehicle_before_it_moves(monkeypatch):
    """The C supervision's challenges go to the real firmware over the vehicle's line, which answers them."""

    def driven(seconds):
        place = field.draw_field("steady", 1101)
        place.condition = replace(place.condition, seconds=seconds)
        simulation = Simulation(place, 1101, encoders=encoders.Encoders())
        return simulation, simulation.run()

    simulation, trace = driven(3.0)
    assert (
        set(trace.halts) <= {"waiting", "unproven", "stalled"} and sum(trace.halts.values()) < 25
    )  # of 20 ms
    assert trace.way_mm > 100 and simulation.controller.camera_state in ("good", "no marker")
    monkeypatch.setattr(c_controller.CController, "ask", lambda *_: b"")  # nobody asks, so nobody proves
    _, trace = driven(1.2)
    assert trace.way_mm < 1 and sum(trace.halts.values()) == 60


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--condition", "rainy"], "unknown condition rainy"),
        (["--on", "jython"], "unknown interpreter jython"),
        (["--method", "guess"], "unknown method guess"),
        (["--controller", "hand"], "unknown controller hand"),
        (["--odometry", "gps"], "unknown odometry gps"),
        (["--odometry-late-ms", "1000"], "--odometry-late-ms is 1000"),
        (["--clock-ppm", "-30000"], "--clock-ppm is -30000"),
        (["--seconds", "0"], "--seconds is 0"),
    ],
)
def test_bad_input_is_one_line(arguments, words, tmp_path, capsys):
    assert cli.main(["simulate", "--drive", "loop", *arguments, "-o", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1


@pytest.mark.skipif(c_controller.compiler() is None, reason="no C compiler: apt-get install gcc")
def test_the_c_library_drives_by_the_bytes_of_the_firmware():
    """As the reference does, but that it waits for the first frame and not for the first word."""
    drives = {}
    for kind in ("c", "python"):
        drawn = field.draw_field("steady", 1101)
        drawn.condition = replace(drawn.condition, seconds=2.0)
        simulation = Simulation(drawn, 1101, "cpython", controller=kind)
        for _ in simulation.frames():
            pass
        drives[kind] = simulation.trace.behaviours, simulation.trace.frames[-1], simulation.trace.halts
    (c_states, c_last, halts), (python_states, python_last, _) = drives["c"], drives["python"]
    assert [state for _, state in c_states][-1] == [state for _, state in python_states][-1] == CENTER
    assert abs(c_last.x_mm - python_last.x_mm) < 20 and abs(c_last.heading_deg - python_last.heading_deg) < 5
    assert set(halts) <= {"waiting", "stalled"} and sum(halts.values()) <= 2


def test_no_c_compiler_is_one_line(monkeypatch):
    c_controller.library.cache_clear()
    monkeypatch.setattr(c_controller.shutil, "which", lambda name: None)
    with pytest.raises(UserError, match="no C compiler: install gcc"):
        c_controller.library()


def test_no_interpreter_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setenv("MICROPYTHON", "")
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    drawn = field.draw_field("steady", 1100)
    with pytest.raises(UserError, match="no MicroPython interpreter"):
        Firmware(drawn.settings, "micropython")
