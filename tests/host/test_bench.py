"""The bench's own logic: matching, counting, statistics, tags, runs on MicroPython."""

import cv2
import numpy as np
import pytest

from larics_host import scoring
from larics_host.scoring import Found, Tally, Truth
from tools.benchmark import evaluate, frames, interpreter, methods, report, targets

TRUTH = Truth(marker_id=5, x_px=100.0, y_px=80.0, heading_deg=10.0, radius_px=30.0, visible=1.0)


def found(dx=0.0, dy=0.0, marker_id=5, heading_deg=10.0, margin=100):
    return Found(marker_id, TRUTH.x_px + dx, TRUTH.y_px + dy, heading_deg, margin)


def tally_of(*frames_of_founds, truths=(TRUTH,)):
    tally = Tally()
    for number, founds in enumerate(frames_of_founds):
        tally.add(list(truths), list(founds), number)
    return tally


def test_a_detection_belongs_to_the_nearest_marker_within_half_a_radius():
    near, far = TRUTH, TRUTH._replace(x_px=120.0)
    assert scoring.match([near, far], [found(18.0), found(1.0)]) == [(0, 1), (1, 0)]
    assert scoring.match([near], [found(15.1)]) == []
    assert scoring.match([near], [found(9.0, 12.0)]) == [(0, 0)]


def test_each_marker_and_each_detection_is_used_once():
    tally = tally_of([found(), found(2.0)])
    assert (tally.detected, tally.false_positives) == (1, 1)
    assert tally.centre_px == [0.0]


def test_row_counts_what_a_user_cares_for():
    tally = tally_of(
        [found(0.3, 0.4)],
        [found(marker_id=4)],
        [found(marker_id=None)],
        [],
        [found(200.0)],
    )
    row = tally.row()
    assert row["markers"] == 5
    assert row["detected_pct"] == pytest.approx(60.0)
    assert row["read_pct"] == pytest.approx(20.0)
    assert (row["wrong"], row["wrong_pct"], row["uncertain"]) == (1, pytest.approx(20.0), 1)
    assert row["false_positives"] == 1
    assert row["centre_p95_px"] == pytest.approx(np.percentile([0.5, 0, 0], 95))
    assert tally.misses == [3, 4] and tally.wrongs == [1] and tally.false_keys == [4]


def test_a_marker_cut_off_by_the_border_may_be_missed_but_not_misread():
    cut = TRUTH._replace(visible=0.7)
    assert tally_of([], truths=[cut]).row()["detected_pct"] is None
    row = tally_of([found(marker_id=1)], truths=[cut]).row()
    assert (row["markers"], row["wrong"], row["false_positives"]) == (0, 1, 0)


@pytest.mark.parametrize("a, b, error", [(359.0, 2.0, 3.0), (10.0, 350.0, 20.0), (180.0, 0.0, 180.0)])
def test_heading_error_wraps(a, b, error):
    assert scoring.heading_error(a, b) == pytest.approx(error)


def test_merged_tallies_equal_one_over_all_frames():
    first, second = tally_of([found(0.1)]), tally_of([found(marker_id=2)], [])
    first.merge(second)
    whole = tally_of([found(0.1)], [found(marker_id=2)], [])
    assert first.row() == whole.row()


def test_risk_by_margin_and_its_order():
    margins = [(10, False), (20, True), (200, True), (210, True)]
    assert scoring.risk_by_margin(margins, [0, 16, 64, 256]) == [(0, 1, 1), (16, 1, 0), (64, 2, 0)]
    assert scoring.ordering(margins) == 1.0
    assert scoring.ordering([(5, True), (5, False)]) == 0.5
    assert scoring.ordering([(5, True)]) is None


def test_jobs_cover_every_frame_once():
    todo = evaluate.jobs("g", "sunny", 5000, 57, 30.0, {}, ["aruco"])
    indices = [job.start + i for job in todo for i in range(job.count)]
    assert indices == list(range(57))


def test_photographs_are_repeatable_frames_without_a_marker():
    frame = frames.photograph(7, 3)
    assert frame.shape == (frames.HEIGHT, frames.WIDTH) and frame.dtype == np.uint8
    assert np.array_equal(frame, frames.photograph(7, 3))
    results = evaluate.run_all(evaluate.jobs("g", evaluate.PHOTOGRAPHS, 7, 2, 30.0, {}, ["apriltag"]))
    row = results["g"]["apriltag"].row()
    assert (row["frames"], row["markers"], row["false_positives"]) == (2, 0, 0)


def test_a_known_radius_is_known_within_fifteen_per_cent():
    assert methods.radius_range(30.0) == (25, 35)
    low, high = methods.radius_range(10.0)
    assert low <= 8.5 and high >= 11.5


@pytest.mark.parametrize(
    "name, dictionary", [("aruco_subpix", cv2.aruco.DICT_4X4_50), ("apriltag", cv2.aruco.DICT_APRILTAG_36h11)]
)
def test_a_tag_as_rendered_is_reported_in_our_conventions(name, dictionary):
    tag = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(dictionary), 5, 64)
    frame = np.full((frames.HEIGHT, frames.WIDTH), 255, np.uint8)
    frame[100:164, 150:214] = tag
    turn = cv2.getRotationMatrix2D((181.5, 131.5), 30, 1)  # counterclockwise as seen
    frame = cv2.warpAffine(frame, turn, (frames.WIDTH, frames.HEIGHT), borderValue=255)
    (seen,) = methods.make(name, frames.WIDTH, frames.HEIGHT, 30.0)(frame)
    assert seen.marker_id == 5
    assert np.hypot(seen.x_px - 181.5, seen.y_px - 131.5) < 0.2
    assert scoring.heading_error(seen.heading_deg, 30.0) < 0.5


def test_an_instruction_counter_is_told_from_a_clock():
    text = "platform %s\nloop %d %d\nmemory 60000\nframe 1300 1 5\nframe 900 0 -\n"
    counted = interpreter.parse(text % ("qemu", 110, 110))
    assert interpreter.counts_instructions(counted)
    assert counted["frames"] == [(1300, 1, 5), (900, 0, None)] and counted["memory"] == 60000
    assert not interpreter.counts_instructions(interpreter.parse(text % ("linux", 110, 110)))
    assert not interpreter.counts_instructions(interpreter.parse(text % ("qemu", 30, 110)))


def test_comparison_lists_what_changed():
    before = {"a": {"rate": 99.0, "n": 5}, "list": [1, 2], "gone": 1}
    after = {"a": {"rate": 98.5, "n": 5}, "list": [1, 3]}
    assert report.comparison(before, after) == ["a / rate: 99 -> 98.5", "list[1]: 2 -> 3"]


def test_targets_are_held_against_the_results():
    row = tally_of([found()], [found()], [found()], []).row()
    results = {
        "quality": {"sunny": {"larics": row}, "negative": {"larics": tally_of([], truths=[]).row()}},
        "sweeps": {"blur": {"values": [8, 12], "methods": {"larics": [tally_of([found()]).row(), row]}}},
        "host_time": {"larics": (0.5, 1.0), "aruco": (1.0, 2.0)},
        "micropython": {"given": {"search": {"unit": "Minsn", "mean": 1.5, "max": 4.0}}},
    }
    verdicts = {target.label: target.verdict() for target in targets.targets(results)}
    assert verdicts["sunny: detected, %"] == "MISSED"
    assert verdicts["sunny: centre median px"] == "aim reached"
    assert verdicts["negative: false positives"] == "aim reached"
    assert verdicts["blur 8: found (0: a wrong ID), %"] == "aim reached"
    assert verdicts["blur 12: found (0: a wrong ID), %"] == "aim missed"
    assert verdicts["times faster than aruco"] == "aim reached"
    assert verdicts["search: mean, Minsn"] == "reached" and verdicts["search: max, Minsn"] == "MISSED"
