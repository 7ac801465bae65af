"""The exposure control in closed loop with the renderer: frames lost at each change of light."""

import numpy as np
import pytest

from exposure import Exposure, gain_cdb, gain_q8
from larics.marker.detection import Detection
from larics.settings import Settings
from tools.exposure_loop import recovery, run


@pytest.fixture(scope="module")
def steps():
    lights = [1.0] * 12 + [0.1] * 12 + [1.0] * 12 + [10.0] * 12 + [1.0] * 12
    rows, _ = run(lights)
    return rows, recovery(rows)


def test_steps_of_ten_in_light_cost_at_most_three_frames(steps):
    rows, found = steps
    assert len(found) == 4
    for index, before, after, lost, off in found:
        assert lost <= 3 and off <= 4, (index, before, after, lost, off)


def test_nothing_is_changed_while_a_marker_is_tracked_in_steady_light(steps):
    rows, _ = steps
    for first in (8, 20, 32, 44, 56):
        exposures = {row[4:] for row in rows[first : first + 4]}
        assert len(exposures) == 1


def test_a_lamp_in_the_picture_changes_nothing():
    lights = [1.0] * 20
    rows, control = run(lights, [0.0] * 10 + [0.25] * 10)
    assert all(row[2] for row in rows)
    assert len({row[4:] for row in rows[8:]}) == 1


def test_the_blur_limit_comes_before_gain_and_gain_before_a_longer_exposure():
    values = {"radius_min_px": 24, "radius_max_px": 36, "max_speed_mm_s": 1000, "focal_q8": 500 * 256}
    settings = Settings(dict(values, ceiling_mm10=25000))
    rows, control = run([0.05] * 16, settings=settings)
    assert control.blur_limit_us == 10000  # 2 px of 5 mm at 1 m/s
    assert rows[-1][4] <= 10100 and rows[-1][5] > 0 and rows[-1][2]
    settings = Settings(dict(values, ceiling_mm10=25000, gain_max_db10=60))
    rows, control = run([0.05] * 16, settings=settings)
    assert rows[-1][5] == 600 and rows[-1][4] > 10000
    settings = Settings(dict(values, ceiling_mm10=25000, gain_max_db10=60, exposure_max_us=20000))
    rows, control = run([0.002] * 16, settings=settings)
    assert rows[-1][4:] == (20000, 600)  # all there is


class Still:
    """A camera that keeps what it is told."""

    def __init__(self, exposure_us, cdb=0):
        self.us, self.cdb = exposure_us, cdb

    def exposure(self, us=None):
        self.us = self.us if us is None else us
        return self.us

    def gain(self, cdb=None):
        self.cdb = self.cdb if cdb is None else cdb
        return self.cdb


def settle(camera, grey, found=(), frames=12, **values):
    control = Exposure(camera, Settings(values))
    frame = np.full(320 * 240, grey, np.uint8)
    for _ in range(frames):
        control.update(frame, 320, 240, list(found))
    return control


def test_black_and_white_frames_go_to_the_limits_and_stay_in_them():
    camera = Still(5000)
    settle(camera, 0, frames=60)
    assert camera.us == 33000 and camera.cdb == 2400
    settle(camera, 255, frames=60)
    assert camera.us == 10 and camera.cdb == 0


def test_a_dark_plate_is_brightened_and_a_white_one_darkened():
    detection = Detection()
    detection.marker_id, detection.x_q8, detection.y_q8, detection.radius_q8 = 3, 160 << 8, 120 << 8, 30 << 8
    camera = Still(5000)
    settle(camera, 90, [detection])
    assert (camera.us, camera.cdb) == (5000, 0)  # good enough: locked
    settle(camera, 50, [detection], frames=3)
    assert camera.us > 15000 or camera.cdb > 0
    camera = Still(5000)
    settle(camera, 255, [detection], frames=3)
    assert camera.us < 1000


def test_gain_in_decibels_and_as_a_factor():
    for cdb in range(0, 4801, 50):
        assert abs(gain_q8(cdb) / 256 / 10 ** (cdb / 2000) - 1) < 0.01
        assert gain_cdb(gain_q8(cdb)) == cdb
    assert gain_cdb(255) == 0 and gain_cdb(1 << 20) == 4800


@pytest.mark.parametrize("width, height", [(80, 60), (320, 240), (1024, 1024)])
def test_any_size_of_frame(width, height):
    camera = Still(5000)
    control = Exposure(camera, Settings())
    detection = Detection()
    detection.marker_id, detection.x_q8, detection.y_q8 = 1, (width - 1) << 8, (height - 1) << 8
    detection.radius_q8 = 300 << 8
    frame = np.full(width * height, 30, np.uint8)
    for _ in range(4):
        control.update(frame, width, height, [detection])
    assert camera.us > 5000
