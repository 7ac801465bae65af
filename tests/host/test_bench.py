"""The bench's own logic: matching, counting, statistics, tags, runs on MicroPython."""

import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from larics_host.validation import scoring
from larics_host.validation.scoring import Expected, Found, Tally

pytest.importorskip("pupil_apriltags", reason="pupil_apriltags has no wheel for this Python")
from tools import family_record
from tools.benchmark import (
    earlier,
    evaluate,
    frames,
    interpreter,
    methods,
    page,
    plan,
    plots,
    report,
    targets,
)

TRUTH = Expected(marker_id=5, x_px=100.0, y_px=80.0, heading_deg=10.0, radius_px=30.0, visible=1.0)


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


def test_a_least_margin_trades_reads_for_wrong_ids():
    margins = [(20, True), (70, False), (90, True), (200, True)]
    assert scoring.by_least_margin(margins, 5, (16, 64, 80, 201)) == [
        (16, 60.0, 1), (64, 40.0, 1), (80, 40.0, 0), (201, 0.0, 0)
    ]  # fmt: skip


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


def test_the_jobs_of_a_sweep_tell_the_detector_the_tilt_it_must_allow():
    todo = plan.sweep_jobs("tilt", 5001, 30, ["larics"])
    assert {job.group[1] for job in todo} == set(plan.SWEEPS["tilt"].values)
    for job in todo:
        assert dict(job.overrides) == {"tilt_deg": job.group[1]} and job.max_tilt_deg == job.group[1]
    for key in ("blur", "radius"):
        assert all(job.max_tilt_deg == 0 for job in plan.sweep_jobs(key, 5001, 30, ["larics"]))


def test_detectors_are_kept_by_all_that_they_are_told():
    level, tilted = (evaluate.detector("larics", 30.0, tilt) for tilt in (0, 40))
    assert level is evaluate.detector("larics", 30.0, 0)
    assert tilted.detector.memory() > level.detector.memory()  # smaller rings need finer cells
    assert level.detector.blur_reader is not None
    assert evaluate.detector("larics_sharp", 30.0, 0).detector.blur_reader is None


def test_every_stress_that_is_to_be_borne_is_a_point_of_500_frames():
    assert plan.frames_a_point(2000) == 500
    limits = {key: (sweep.must, sweep.aim) for key, sweep in plan.SWEEPS.items() if sweep.must is not None}
    assert limits == {
        "contrast": (8, 5),
        "blur": (8, 12),
        "defocus": (2.5, 3.5),
        "radius": (8, 6),
        "tilt": (25, 35),
    }
    for key, values in limits.items():
        assert set(values) <= set(plan.SWEEPS[key].values)


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
    text = "platform %s\nloop %d %d\nmemory 60000\nframe 1300 1 5 0\nframe 900 0 - 1\n"
    counted = interpreter.parse(text % ("qemu", 110, 110))
    assert interpreter.counts_instructions(counted)
    assert counted["frames"] == [(1300, 1, 5, False), (900, 0, None, True)] and counted["memory"] == 60000
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
        "micropython": {"given": {"search": {"unit": "Minsn", "frames": 9, "mean": 1.5, "max": 4.0}}},
    }
    verdicts = {target.label: target.verdict() for target in targets.targets(results)}
    assert verdicts["sunny: detected, %"] == "MISSED"
    assert verdicts["sunny: centre median px"] == "aim reached"
    assert verdicts["negative: false positives"] == "aim reached"
    assert verdicts["blur 8: found, %"] == "reached"
    assert verdicts["blur 12: found, %"] == "aim missed"
    assert verdicts["times faster than aruco"] == "aim reached"
    assert verdicts["search: mean, Minsn"] == "reached" and verdicts["search: max, Minsn"] == "MISSED"


def swept(key, row_at):
    """Results of one sweep of our detector: {value: row} where given, else found in every frame."""
    values = plan.SWEEPS[key].values
    perfect = tally_of(*[[found(0.1)]] * 20).row()
    rows = [row_at.get(value, perfect) for value in values]
    return {key: {"values": list(values), "methods": {"larics": rows, "larics_sharp": rows}}}


def test_a_stress_is_borne_with_95_of_100_found_and_nothing_wrong():
    once_missed = tally_of(*[[found()]] * 19, []).row()
    twice_missed = tally_of(*[[found()]] * 18, [], []).row()
    misread = tally_of(*[[found()]] * 19, [found(marker_id=1)]).row()
    beside = tally_of(*[[found()]] * 19, [found(), found(100.0)]).row()

    def verdicts(must, aim):
        rows = list(targets.stresses(swept("tilt", {25: must, 35: aim})))
        assert [row.label for row in rows] == ["tilt 25: found, %", "tilt 35: found, %"]
        assert all(row.frames == 20 for row in rows)
        return [row.verdict() for row in rows]

    assert verdicts(once_missed, once_missed) == ["reached", "aim reached"]
    assert verdicts(twice_missed, twice_missed) == ["MISSED", "aim missed"]
    assert verdicts(misread, misread) == ["MISSED", "aim missed"]
    assert verdicts(beside, beside) == ["MISSED", "aim missed"]


def cost(each, asked, memory):
    return {
        "unit": "Minsn",
        "each": each,
        "asked": asked,
        "frames": 3,
        "found": 2,
        "memory": memory,
        "mean": 1.0,
    }


def test_the_second_opinion_costs_what_it_adds_where_it_was_asked():
    costs = {
        "search, blur 8": cost([1.0, 9.5, 7.0], [False, True, True], 5000),
        "search, blur 8, blur-model reader off": cost([1.0, 1.5, 2.0], [False] * 3, 4000),
    }
    added = targets.second_opinion(costs)["search, blur 8"]
    assert (added["asked"], added["median"], added["max"]) == (2, 6.5, 8.0)
    assert added["memory"] == (4000, 5000)
    (row,) = targets.targets({"micropython": {"given": costs}})
    assert (row.label, row.frames, row.verdict()) == ("blur-model reader, blur 8: most, Minsn", 2, "reached")


@pytest.fixture
def pages(tmp_path):
    """A copy of the two pages that take figures."""
    for name in ("stress.md", "peers.md"):
        (tmp_path / name).write_text((interpreter.ROOT / "docs" / name).read_text())
    return tmp_path


def test_the_page_is_brought_up_to_date_by_what_was_measured(pages):
    path = pages / "stress.md"
    misread = tally_of(*[[found()]] * 19, [found(marker_id=1)]).row()
    results = {"sweeps": swept("blur", {16: misread})}
    sweep, rows_of = plan.SWEEPS["blur"], results["sweeps"]["blur"]["methods"]
    plots.sweep(sweep, rows_of, pages / "sweep_blur.png")
    before, peers = path.read_text(), (pages / "peers.md").read_text()
    assert page.write(results, pages, pages) == ["targets", "sweeps"]
    text = path.read_text()
    assert "| blur 12 | 100.0 | 0 | 20 | aim reached |" in text
    assert "| LARICS | " + "100.0 | " * 7 + "100.0 / 95.0 (1) |" in text
    assert cv2.imread(str(pages / "stress_blur.png")) is not None
    assert "stress_contrast.png" not in text
    costs = before.partition("<!-- costs:begin -->")[2]
    assert costs and text.partition("<!-- costs:begin -->")[2] == costs  # not measured: as it was
    assert (pages / "peers.md").read_text() == peers
    path.write_text("no marks")
    with pytest.raises(ValueError, match="targets:begin"):
        page.write(results, pages, pages)
    assert path.read_text() == "no marks"


def test_the_peers_stand_beside_us_on_their_page(pages):
    row = tally_of(*[[found(0.1)]] * 19, [found(marker_id=1)]).row()
    nothing, empty = tally_of([], []).row(), tally_of([found()], [], truths=[]).row()
    quality = {"harsh": {"larics": row, "aruco": nothing, "hough": row}}
    quality["negative"] = {"larics": empty, "aruco": tally_of([], [], truths=[]).row(), "hough": empty}
    assert page.write({"quality": quality}, pages, pages) == ["quality"]
    text = (pages / "peers.md").read_text()
    assert "| preset | LARICS | ArUco |" in text and "cv2.HoughCircles |" not in text  # it reads no ID
    assert "| harsh | 95.0 (1) | 0.0 |" in text
    assert "| negative, 2 frames | (1) | (0) |" in text
    assert "| harsh | 0.100 / 0.100 | - |" in text
    sizes = swept("radius", {6: nothing, 7: nothing})
    plots.sweep(plan.SWEEPS["radius"], sizes["radius"]["methods"], pages / "sweep_radius.png")
    assert page.write({"sweeps": sizes}, pages, pages) == ["targets", "sweeps", "sizes"]
    assert "| LARICS | 8 |" in (pages / "peers.md").read_text()


def test_peers_of_an_earlier_run_are_taken_only_over_the_same_frames(tmp_path):
    row = tally_of([found()]).row()
    path = tmp_path / "earlier.json"
    now = {"frames": 1, "seed": plan.FRESH_SEED, "renderer": frames.renderer_digest()}
    rows = {preset: {"apriltag": row} for preset in (*plan.presets(), *evaluate.NEGATIVES)}
    path.write_text(json.dumps({**now, "quality": rows}))
    words = ["--frames", "1", "--methods", "aruco", "--only", "quality", "--jobs", "1"]
    command = [sys.executable, "tools/bench.py", *words, "--with", str(path), "--output", str(tmp_path)]
    done = subprocess.run(command, cwd=interpreter.ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    sunny = json.loads((tmp_path / "results.json").read_text())["quality"]["sunny"]
    assert list(sunny) == ["aruco", "apriltag"] and sunny["apriltag"] == row
    for wrong in ({"frames": 2}, {"seed": 1}, {"renderer": "another"}):
        path.write_text(json.dumps({**now, **wrong}))
        with pytest.raises(ValueError, match="is of other frames"):
            earlier.load(path, now)
    path.write_text("[]")
    done = subprocess.run(command, cwd=interpreter.ROOT, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("bench: %s is no results.json" % path)


def test_tables_of_a_sweep_have_straight_columns():
    rows_of = swept("tilt", {40: tally_of([]).row()})["tilt"]["methods"]
    first, _, *lines = report.sweep(plan.SWEEPS["tilt"], rows_of).splitlines()
    assert "max_tilt_deg" in first
    for table in (lines[1:11], lines[13:]):
        assert len(table) == 10 and len({len(line) for line in table}) == 1


def test_coded_markers_stand_beside_plain_ones_and_have_targets():
    assert {"larics", "larics_coded", "apriltag", "aruco"} <= set(plan.QUALITY_METHODS)
    assert 12 in plan.SWEEPS["radius"].values and plan.SWEEPS["occlusion"].title == "Share covered"
    plain, _ = frames.render("sunny", 5, 0, "larics", 30.0, {})
    coded, (truth,) = frames.render("sunny", 5, 0, methods.target("larics_coded"), 30.0, {})
    assert truth.marker_id > 7 and np.any(plain != coded)
    assert [found.marker_id for found in methods.make("larics_coded", 360, 296, 30.0)(coded)] == [
        truth.marker_id
    ]
    row = {"read_pct": 90.0, "frames": 100, "wrong": 0}
    quality = {"quality": {"harsh": {"larics_coded": row}}}
    (target,) = targets._coded(quality)
    assert target.verdict() == "reached"
    (target,) = targets._coded({"quality": {"harsh": {"larics_coded": {**row, "wrong": 1}}}})
    assert target.verdict() == "MISSED"  # one wrong ID is too many
    rows = [row] * 6
    swept = {"occlusion": {"values": [0, 0.05, 0.1, 0.15, 0.2, 0.3], "methods": {"larics_coded": rows}}}
    assert [t.must for t in targets._coded({"sweeps": swept})] == [85, 80, 70]


def test_the_record_tells_wrong_ids_from_those_of_the_other_family(monkeypatch):
    job = evaluate.Job("", "sunny", 7, 0, 4, 30.0, (), ("larics",))
    frames_of = [([TRUTH], [found()]), ([TRUTH], [found(marker_id=4)]), ([TRUTH], [found(marker_id=13)])]
    frames_of.append(([], [found(marker_id=None), found(marker_id=2)]))
    monkeypatch.setattr(evaluate, "block", lambda job, target: [(fs, truths) for truths, fs in frames_of])
    record = family_record.Record()
    record.add(job, lambda founds: founds)
    assert record.tally.read == 1 and record.tally.wrongs == [("sunny", 7, 1), ("sunny", 7, 2)]
    assert record.crossed == [(("sunny", 7, 2), [5], 13)]
    assert record.told == [(("sunny", 7, 3), 2)]


def test_the_record_counts_what_was_chosen(tmp_path, capsys):
    words = ["--seed", "900", "--share", "0.004", "--only", "R 10", "--output", str(tmp_path)]
    counted = family_record.measure(family_record.arguments(words))
    assert counted["frames"] == 6 + 1 + 2
    assert counted["totals"]["coded"] == {"markers": 7, "wrong": 0, "crossed": 0}
    assert counted["totals"]["plain"]["markers"] == 2
    assert "no marker" not in " ".join(counted["conditions"])
    assert json.loads((tmp_path / "record.json").read_text()) == json.loads(json.dumps(counted))
    assert capsys.readouterr().out.count("coded: ") == 1
    with pytest.raises(SystemExit):
        family_record.arguments(["--only", "nothing of the kind"])
