"""The detector on rendered and photographed frames: truth, invariances, executors, hostile content."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from larics.detect.centre_votes import CENTRES
from larics.detect.detector import Detector
from larics_host.images.frame_sources import open_frames
from larics_host.render import render_frame
from larics_host.truth import read_truth
from tests.host.test_dual import interpreter

ROOT = Path(__file__).resolve().parents[2]
FRAMES = ROOT / "tests" / "frames"
LINES = Path(__file__).with_name("detector_lines.py")


def turned(degrees):
    return (degrees + 180) % 360 - 180


def match(found, truth):
    """The detection within 4 px of a marker, or None."""
    for one in found:
        if math.hypot(one.x_q8 / 256 - truth.x_px, one.y_q8 / 256 - truth.y_px) < 4:
            return one
    return None


def frames(preset, count, seed=1100, **settings):
    for index in range(count):
        yield render_frame(preset, seed, index, **settings)


@pytest.fixture(scope="module")
def detector():
    return Detector(360, 296, 25, 35)


@pytest.mark.parametrize("preset", ["sunny", "double", "fast", "cloudy"])
def test_rendered_markers_are_found_and_right(detector, preset):
    centre, heading = [], []
    for frame, truths in frames(preset, 40):
        found = detector.detect(frame)
        assert len(found) == len(truths)
        for truth in truths:
            one = match(found, truth)
            assert one is not None and one.marker_id == truth.id
            centre.append(math.hypot(one.x_q8 / 256 - truth.x_px, one.y_q8 / 256 - truth.y_px))
            heading.append(abs(turned(one.heading_cdeg / 100 - truth.heading_deg)))
    limits = (0.05, 0.12, 0.07, 0.25) if preset == "cloudy" else (0.02, 0.06, 0.025, 0.1)
    reached = (*np.percentile(centre, (50, 95)), *np.percentile(heading, (50, 95)))
    assert all(value <= limit for value, limit in zip(reached, limits, strict=True)), reached


def test_several_markers_in_a_frame(detector):
    seen = total = 0
    for frame, truths in frames("multi", 15):
        found = detector.detect(frame)
        for truth in truths:
            if truth.id is None or truth.visible < 1:
                continue
            total += 1
            one = match(found, truth)
            if one is not None:
                assert one.marker_id == truth.id
                seen += 1
    assert total > 20 and seen >= total - 1


def test_golden_frames_have_no_wrong_id():
    truths = {}
    for truth in read_truth(FRAMES / "truth.csv"):
        truths.setdefault(truth.frame, []).append(truth)
    read = visible = 0
    for name, markers in truths.items():
        _, frame = next(iter(open_frames([str(FRAMES / name)])))
        radius = int(name.split("_r")[1].split("_")[0])
        low, high = max(6, radius * 85 // 100), min(72, radius * 115 // 100 + 1)
        found = Detector(frame.shape[1], frame.shape[0], low, high).detect(frame)
        markers = [truth for truth in markers if truth.id is not None]
        for one in found:
            assert any(match([one], truth) for truth in markers), name
        for truth in markers:
            visible += truth.visible == 1
            one = match(found, truth)
            if one is not None:
                assert one.marker_id in (truth.id, -1), name
                read += one.marker_id == truth.id
    assert read >= visible * 0.8


def shared_marker():
    frame, truths = render_frame("sunny", 1101, 3, width=240, height=240, marker_ids=(3,))
    return frame, truths[0]


def poses(frame):
    height, width = frame.shape
    found = Detector(width, height, 25, 35).detect(np.ascontiguousarray(frame))
    return [(one.marker_id, one.x_q8 / 256, one.y_q8 / 256, one.heading_cdeg / 100) for one in found]


def test_quarter_turns_turn_the_pose():
    frame, _ = shared_marker()
    ((marker_id, x, y, heading),) = poses(frame)
    for turns in (1, 2, 3):
        ((other_id, other_x, other_y, other_heading),) = poses(np.rot90(frame, turns))
        size = frame.shape[0] - 1
        expected = (x, y)
        for _ in range(turns):
            expected = (expected[1], size - expected[0])
        assert other_id == marker_id
        assert math.hypot(other_x - expected[0], other_y - expected[1]) < 0.03
        assert abs(turned(other_heading - heading - 90 * turns)) < 0.1


def test_a_shift_shifts_the_pose():
    frame, _ = shared_marker()
    ((marker_id, x, y, heading),) = poses(frame)
    for dx, dy in ((1, 0), (0, 1), (7, -5), (-13, 11)):
        ((other_id, other_x, other_y, other_heading),) = poses(np.roll(frame, (dy, dx), (0, 1)))
        assert other_id == marker_id
        assert math.hypot(other_x - x - dx, other_y - y - dy) < 0.03
        assert abs(turned(other_heading - heading)) < 0.1


def test_a_mirrored_marker_has_its_bits_reversed():
    # the mirror image of ID 3 (011) is a valid marker: 6 (110), so that a mirrored sensor must be a setting
    frame, _ = shared_marker()
    ((marker_id, x, y, heading),) = poses(frame)
    ((other_id, other_x, other_y, other_heading),) = poses(frame[:, ::-1])
    assert (marker_id, other_id) == (3, 6)
    assert math.hypot(other_x - (frame.shape[1] - 1 - x), other_y - y) < 0.03
    assert abs(turned(other_heading - (180 - heading))) < 0.1


def test_an_inverted_marker_is_not_a_marker():
    frame, _ = shared_marker()
    assert poses(255 - frame) == []


@pytest.mark.parametrize("gain, offset", [(0.3, 0), (0.6, 20), (0.5, 90), (1.0, -10), (0.35, 150)])
def test_brightness_and_contrast_do_not_matter(gain, offset):
    frame, truth = shared_marker()
    scaled = np.clip(frame * gain + offset, 0, 255).astype(np.uint8)
    ((marker_id, x, y, heading),) = poses(scaled)
    assert marker_id == 3
    assert math.hypot(x - truth.x_px, y - truth.y_px) < 0.08
    assert abs(turned(heading - truth.heading_deg)) < 0.25


@pytest.mark.parametrize("line_mm, setting", [(15, None), (20, None), (8, 8), (12, 12), (25, 25), (28, 28)])
def test_line_widths(line_mm, setting):
    finder = Detector(360, 296, 25, 35, line_mm=setting)
    right = 0
    for frame, truths in frames("sunny", 12, line_mm=line_mm):
        one = match(finder.detect(frame), truths[0])
        assert one is None or one.marker_id in (truths[0].id, -1)
        right += one is not None and one.marker_id == truths[0].id
    assert right >= 11


def test_an_unknown_radius_is_found():
    finder = Detector(360, 296, 10, 66)
    for radius in (15, 24, 38, 60):
        for frame, truths in frames("sunny", 4, radius_px=radius):
            one = match(finder.detect(frame), truths[0])
            assert one is not None and one.marker_id == truths[0].id
            assert abs(one.radius_q8 / 256 - truths[0].radius_px) < 0.15


def test_clutter_is_not_a_marker(detector):
    for frame, _ in frames("negative", 60):
        assert detector.detect(frame) == []


def test_photographs_have_no_markers():
    data = pytest.importorskip("skimage.data")
    known, unknown = Detector(256, 200, 25, 35), Detector(256, 200, 10, 60)
    crops = 0
    for name in ("brick", "camera", "coins", "grass", "gravel", "moon", "page", "text", "checkerboard"):
        picture = getattr(data, name)()
        picture = picture if picture.dtype == np.uint8 else (picture * 255).astype(np.uint8)
        for top in range(0, picture.shape[0] - 199, 100):
            for left in range(0, picture.shape[1] - 255, 128):
                crop = np.ascontiguousarray(picture[top : top + 200, left : left + 256])
                assert known.detect(crop) == [] and unknown.detect(crop) == [], (name, top, left)
                crops += 1
    assert crops > 50


def hostile():
    y, x = np.mgrid[:296, :360]
    cells = np.hypot(x % 72 - 36, y % 74 - 37)
    generator = np.random.default_rng(4)
    return {
        "black": np.zeros((296, 360)),
        "white": np.full((296, 360), 255),
        "noise": generator.integers(0, 256, (296, 360)),
        "binary noise": generator.integers(0, 2, (296, 360)) * 255,
        "checkerboard": ((x // 4 + y // 4) & 1) * 255,
        "rings everywhere": ((cells / 5).astype(int) & 1) * 255,
        "markers' rings everywhere": ((abs(cells - 30) > 2) & (abs(cells - 20) > 2)) * 255,
        "stripes": (x // 3 & 1) * 255,
    }


def test_hostile_content_is_capped():
    for finder in (Detector(360, 296, 25, 35), Detector(360, 296, 10, 66)):
        scales = len(finder._scales)
        for name, frame in hostile().items():
            assert finder.detect(np.ascontiguousarray(frame.astype(np.uint8))) == [], name
            counts = finder.statistics
            assert counts.candidates <= CENTRES * scales
            assert counts.crossings <= CENTRES * scales * 700


def run_lines(executor, arguments):
    if executor == "micropython":
        command = interpreter()
        environment = dict(os.environ, MICROPYPATH="shared:.frozen")
    else:
        command = [sys.executable]
        environment = dict(os.environ, PYTHONPATH="shared", LARICS_KERNELS=executor)
    command += [str(LINES), *arguments]
    result = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr + result.stdout
    return result.stdout.splitlines()


def test_all_executors_report_the_same():
    pytest.importorskip("numba")
    small = [str(path) for path in sorted(FRAMES.glob("*_r15_*.pgm"))]
    large = [str(path) for path in sorted(FRAMES.glob("*_r30_*.pgm"))]
    assert len(small) > 5 and len(large) > 5
    for limits, names in (("12:18", small), ("25:35", large)):
        expected = run_lines("numba", [limits, *names])
        assert run_lines("micropython", [limits, *names]) == expected
        assert run_lines("plain", [limits, *names]) == expected
        assert run_lines("strict", [limits, *names[:: len(names) // 3]]) == expected[:: len(names) // 3]
