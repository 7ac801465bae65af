"""Frames and rings larger than a board takes: found all the same, in original pixels, and said once."""

import json

import cv2
import numpy as np
import pytest

from larics.marker.detection import NO_ID
from larics_host import cli
from larics_host.detection.detectors import DEFAULT_RADIUS_PX, make_detector
from larics_host.detection.reduced import levels_of, shrunk, unknown_levels
from larics_host.render import render_frame


def scene(width, height, radius_px, index=3):
    """(frame, truth of its marker) of seed 5201."""
    frame, truths = render_frame("sunny", 5201, index, width=width, height=height, radius_px=radius_px)
    return frame, truths[0]


def only(found, truth, near_px):
    (one,) = found
    assert one.marker_id == truth.id
    assert abs(one.x_q8 / 256 - truth.x_px) < near_px and abs(one.y_q8 / 256 - truth.y_px) < near_px
    assert abs(one.radius_q8 / 256 / truth.radius_px - 1) < 0.02
    assert abs((one.heading_cdeg / 100 - truth.heading_deg + 180) % 360 - 180) < 1.5


@pytest.mark.parametrize(
    "size, radius_px, options",
    [
        ((1920, 1080), 80, [None, (70, 90), (20, 400), (12, 82)]),
        ((640, 480), 120, [None, (100, 140), (20, 200)]),
        ((1600, 1200), 400, [None, (300, 500), (10, 550)]),
        ((1100, 700), 30, [None, (25, 35)]),
        ((901, 1031), 200, [None, (150, 250)]),
    ],
)
def test_what_is_larger_than_a_board_takes_is_found_in_original_pixels(size, radius_px, options):
    frame, truth = scene(*size, radius_px)
    for radius in options:
        only(make_detector("larics", *size, radius).detect(frame), truth, 0.01 * radius_px)


def test_the_published_method_reads_large_frames_too():
    frame, truth = scene(1920, 1080, 80, 1)
    only(make_detector("paper", 1920, 1080, (70, 90)).detect(frame), truth, 2)


def test_a_place_keeps_its_coordinates_through_a_reduction():
    base, truth = scene(360, 296, 30)
    (plain,) = make_detector("larics", 360, 296, (25, 35)).detect(base)
    for factor in (3, 4, 5):
        large = np.repeat(np.repeat(base, factor, axis=0), factor, axis=1)
        assert (shrunk(large, factor) == base).all()
        radius = (25 * factor, 35 * factor)
        (one,) = make_detector("larics", 360 * factor, 296 * factor, radius).detect(large)
        expected = plain.x_q8 / 256 * factor + (factor - 1) / 2, plain.y_q8 / 256 * factor + (factor - 1) / 2
        # a level may be finer than this factor, and then sees other noise
        assert abs(one.x_q8 / 256 - expected[0]) < 0.05 * factor
        assert abs(one.y_q8 / 256 - expected[1]) < 0.05 * factor
        assert abs(one.radius_q8 / plain.radius_q8 - factor) < 0.01 * factor


def test_levels_cover_the_range_and_stay_within_the_limits():
    for size in ((64, 64), (360, 296), (1024, 1024), (1025, 60), (1920, 1080), (8000, 6000), (6307, 6425)):
        for low, high in ((6, 72), (6, 400), (25, 35), (60, 73), (100, 101), (7, 9999), (1000, 9999)):
            levels = levels_of(*size, low, high)
            limit = min(high, *size)
            assert levels[-1].factor * levels[-1].high_px >= limit or levels == [(1, low, high)]
            assert levels[0].factor * levels[0].low_px <= max(low, 6 * levels[0].factor)
            for level in levels:
                assert max(size) // level.factor <= 1024
                assert 6 <= level.low_px < level.high_px <= 72 or low == high
            for fine, coarse in zip(levels[:-1], levels[1:], strict=True):
                assert fine.factor * fine.high_px >= coarse.factor * coarse.low_px
    assert (
        levels_of(360, 296, 25, 35) == [(1, 25, 35)]
        and len(unknown_levels(120, 120, *DEFAULT_RADIUS_PX)) == 1
    )
    for size in ((360, 296), (1920, 1080), (6307, 6425)):
        levels = unknown_levels(*size, *DEFAULT_RADIUS_PX)
        assert levels[-1].factor * levels[-1].high_px >= 0.95 * min(size) / 2 - levels[-1].factor
        for fine, coarse in zip(levels[:-1], levels[1:], strict=True):
            assert fine.factor * fine.high_px >= coarse.factor * coarse.low_px


def test_a_coarse_look_finds_nothing_where_there_is_no_marker():
    detector = make_detector("larics", 360, 296)
    assert len(detector.levels) == 2
    for index in range(40):
        frame, truths = render_frame("negative", 5202, index, radius_px=30)
        assert all(one.marker_id == NO_ID for one in detector.detect(frame)), index


def test_our_own_print_is_read(tmp_path, capsys):
    for dpi in (40, 100):
        path = tmp_path / ("m%d.png" % dpi)
        assert cli.main(["marker", "6", "-o", str(path), "--dpi", str(dpi)]) == 0
        capsys.readouterr()
        assert cli.main(["detect", "--json", str(path)]) == 0
        record = json.loads(capsys.readouterr().out)
        (one,) = record["detections"]
        assert one["id"] == 6 and abs(one["radius"] - 150 / 25.4 * dpi) < 1
        assert abs(one["x"] - (record["width"] - 1) / 2) < 2


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_reduction_is_said_once(tmp_path, capsys, jobs):
    frame, _ = scene(1920, 1080, 80)
    for k in range(3):
        cv2.imwrite(str(tmp_path / ("f%d.png" % k)), frame)
    for _ in range(2):  # once in each run
        assert cli.main(["detect", "--json", str(tmp_path), "--jobs", jobs]) == 0
        out, err = capsys.readouterr()
        assert [json.loads(line)["detections"][0]["id"] for line in out.splitlines()] == [1] * 3
        said = [line for line in err.splitlines() if "reduced" in line]
        assert len(said) == 1 and "frames of 1920 x 1080 px are reduced 2 times" in said[0]


def test_the_limits_of_a_board_stand_in_the_help(capsys):
    with pytest.raises(SystemExit):
        cli.main(["detect", "--help"])
    assert "a board takes 6:72 in frames up to 1024 x 1024" in " ".join(capsys.readouterr().out.split())
