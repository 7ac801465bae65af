"""The pieces of `make demo`: its drive, its scores and its picture."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import cv2
import matplotlib.pyplot as plt
import numpy as np
import pytest

from larics.settings import Settings
from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host.render.scene import Scene
from larics_host.render.view import truth_of
from tools.demo import __main__ as demo
from tools.demo import compare, drive, picture


@pytest.fixture(scope="module")
def truths():
    """The truth of the whole drive."""
    found = []
    scene, camera = Scene(drive.CEILING_MM, plates=drive.plates()), drive.camera()
    for index in range(drive.frame_count()):
        pose, motion, since = drive.leg_at(index / drive.FPS)
        where = motion.pose_after(pose, since)
        name, time_us = drive.name_of(index), round(index * 1e6 / drive.FPS)
        found += truth_of(scene, where, motion, camera, name, time_us)
    return found


def marker(frame, truth, marker_id=None, **changes):
    heading = (truth.marker_heading_deg - truth.vehicle_heading_deg) % 360
    record = {
        "message": "MARKER",
        "frame": frame,
        "flags": 0,
        "id": truth.id if marker_id is None else marker_id,
        "x_mm10": round(truth.offset_x_mm * 10),
        "y_mm10": round(truth.offset_y_mm * 10),
        "z_mm10": 30000,
        "heading_cdeg": round(heading * 100) % 36000,
        "margin": 200,
    }
    return dict(record, **changes)


def test_the_way_is_continuous_and_the_settings_are_valid():
    poses = [drive.pose_at(k / 100) for k in range(int(100 * drive.frame_count() / drive.FPS))]
    steps = [math.dist((a.x_mm, a.y_mm), (b.x_mm, b.y_mm)) for a, b in zip(poses, poses[1:], strict=False)]
    assert max(steps) < 4.01 and min(steps) > 3.99
    settings = Settings(dict(drive.settings(), width=drive.WIDTH, height=drive.HEIGHT))
    assert len(settings.map) == len(drive.MARKERS)


def test_what_is_drawn_lies_where_the_truth_is(truths):
    seen = [truth for truth in truths if truth.id is not None and truth.visible == 1]
    assert len(seen) > 100
    for truth in seen:
        x, y, angle_deg, radius = picture.to_image(marker(0, truth))
        assert math.hypot(x - truth.x_px, y - truth.y_px) < 0.5
        assert abs((angle_deg - truth.heading_deg + 180) % 360 - 180) < 0.1
        assert abs(radius - truth.radius_px) < 0.3


def test_score_counts_right_wrong_spurious_and_lost(tmp_path, truths):
    by_index = {}
    for truth in truths:
        if truth.id is not None and compare.is_whole(truth):
            by_index.setdefault(int(truth.frame[6:12]), truth)
    good, wrong, unsure, astray, *_ = sorted(by_index)
    records = [
        marker(good, by_index[good]),
        marker(wrong, by_index[wrong], marker_id=by_index[wrong].id ^ 1),
        dict(marker(unsure, by_index[unsure]), id=None),
        marker(astray, by_index[astray], x_mm10=9000, y_mm10=-8000),
        {"message": "MARKER", "frame": 20, "flags": m.MARKER_NONE, "id": None},
    ]
    path = tmp_path / "run.jsonl"
    path.write_text("".join(json.dumps(record) + "\n" for record in records))
    frames, _ = compare.read_run(path, truths)
    total = compare.score(frames)
    assert (total.reported, total.wrong, total.spurious, total.found) == (5, 1, 1, 1)
    assert max(total.offsets_mm) < 0.1 and 4 <= total.whole <= 8
    assert compare.line_bytes(path) == 5 * protocol.frame_size(m.MARKER)


def test_frames_that_were_not_taken_are_no_lost_ones(tmp_path, truths, capsys):
    nothing = {"message": "MARKER", "flags": m.MARKER_NONE, "id": None}
    told = [(0, 7), (4, 8), (6, 10), (7, 11)]  # frame, sequence: 1 to 3 were not taken, 5 was lost
    lines = [json.dumps(dict(nothing, frame=frame, sequence=sequence)) for frame, sequence in told]
    path = tmp_path / "run.jsonl"
    path.write_text("\n".join(lines) + "\n")
    frames, statuses = compare.read_run(path, truths)
    assert [frame.index for frame in frames if frame.lost] == [5]
    total = compare.score(frames)
    assert (total.reported, total.not_taken) == (4, len(frames) - 5)
    demo.print_summary(total, statuses, 100)
    summary = capsys.readouterr().out
    assert "late                      %d: this machine was too slow" % (len(frames) - 5) in summary
    assert "lost on the line          1" in summary
    demo.print_table(frames)
    table = capsys.readouterr().out
    assert "late" in table and "lost" not in table


def test_the_picture_is_drawn_and_reduced(tmp_path, truths):
    lines = []
    for truth in truths:
        if truth.id is not None:
            lines.append(marker(int(truth.frame[6:12]), truth))
    path = tmp_path / "run.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    frames, _ = compare.read_run(path, truths)
    for frame in picture.choose(frames):
        grey = np.full((drive.HEIGHT, drive.WIDTH), 90, np.uint8)
        cv2.imwrite(str(tmp_path / drive.name_of(frame.index)), grey)
    picture.draw(frames, tmp_path, compare.score(frames), tmp_path / "demo.png")
    picture.reduce(tmp_path / "demo.png", tmp_path / "small.png")
    small = cv2.imread(str(tmp_path / "small.png"))
    assert small.shape[1] == 1350 and (tmp_path / "small.png").stat().st_size < 400000
    green = (abs(small.astype(int) - (92, 163, 0)).sum(axis=2) < 60).sum()
    assert green > 1000  # what was reported is drawn in


def test_a_home_that_cannot_be_written_is_no_matter():
    done = subprocess.run(
        [sys.executable, "-c", "import tools.demo.picture"],
        cwd=Path(__file__).parents[2],
        env=dict(os.environ, HOME="/dev/null", PYTHONPATH="shared:host"),
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_plates_on_the_map_show_what_hangs_there():
    """Against the ink that the renderer samples: rings, lines and cells, seen from above."""
    figure, axes = plt.subplots(figsize=(6, 6), dpi=100)
    axes.set_position((0, 0, 1, 1))
    plate = next(plate for plate in drive.plates() if plate.marker_id > 7)
    x_mm, y_mm = plate.pose.x_mm, plate.pose.y_mm
    picture.draw_plate(axes, plate)
    axes.set_xlim(x_mm - 250, x_mm + 250)
    axes.set_ylim(y_mm - 250, y_mm + 250)
    axes.axis("off")
    figure.canvas.draw()
    grey = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3].mean(axis=2)
    plt.close(figure)

    def dark(turn_deg, radius_mm):
        """Whether it is dark that far counterclockwise as seen from below."""
        angle = math.radians(plate.pose.heading_deg - turn_deg)
        column, row = (300 + 1.2 * radius_mm * part for part in (math.cos(angle), math.sin(angle)))
        return grey[round(row), round(column)] < 100

    middles = [90 * q + angle for q in range(4) for angle in (18.5, 27.5, 36.5, 53.5, 62.5, 71.5)]
    cells = sum(dark(angle, 232) << k for k, angle in enumerate(middles))
    assert cells == plate.family.cells(plate.marker_id)
    bits = [dark(angle, 50) for angle in (90, 180, 270)]
    assert bits == [bit == 1 for bit in plate.family.bits(plate.marker_id)]
    assert dark(0, 190) and dark(45, 150) and dark(45, 100) and not dark(45, 125)
