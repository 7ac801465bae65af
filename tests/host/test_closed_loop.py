"""How drives in closed loop are judged."""

import numpy as np

from larics.wire import messages as m
from tools import closed_loop


def drives(off_mm=1.0, sigma_mm=2.0, state=m.CARRIED, few_off=0.05):
    """Rows of 200 frames, of which a share is off by three sigma."""
    off = np.where(np.arange(200) < few_off * 200, 3 * sigma_mm, off_mm)
    column = np.full(200, sigma_mm)
    return np.column_stack([np.full(200, state), off, off, off, column, column, column])


def test_figures_are_judged():
    keeps = closed_loop.judged("1", drives(), np.array([40.0]))[1]
    assert keeps and closed_loop.judged("1", drives(state=m.TRACKING), np.array([]))[1]
    for rows, word in (
        (drives(few_off=0.0), "sigma between markers"),
        (drives(few_off=0.2), "sigma between markers"),
        (drives(few_off=0.2, state=m.TRACKING), "sigma tracking"),
        (drives(off_mm=41.0, sigma_mm=30.0), "error"),
        (drives(state=m.LOST), "lost"),
    ):
        line, keeps = closed_loop.judged("1", rows, np.array([40.0]))
        assert word in line and not keeps
    assert "no lap" in closed_loop.judged("missing", drives(), np.array([]))[0]


def test_settings_are_off_by_their_own_sigma():
    drawn = []
    for seed in range(200):
        settings = {"focal_q8": 100000, "ceiling_mm10": 30000, "map": [[1, 0, 0, 0]], "map_sigma_mm10": 50}
        settings |= {"tilt_forward_cdeg": 0, "tilt_left_cdeg": 0, "mount_cdeg": 0}
        settings |= {"camera_x_mm10": 0, "camera_y_mm10": 0}
        closed_loop.falsify(settings, seed)
        drawn.append([settings["focal_q8"], settings["ceiling_mm10"], settings["map"][0][1]])
    assert np.allclose(np.std(drawn, axis=0), (100, 30, 5), rtol=0.2)


def test_a_drive_may_be_shorter_than_its_kind():
    name, rows, laps = closed_loop.drive(("0.2", 3, 0.5, "cpython"))
    assert name == "0.2" and len(rows) <= 5 and not len(laps)
    assert {closed_loop.KINDS[kind].seconds for kind in ("1", "2", "1-unseen", "2-unseen")} == {60}
