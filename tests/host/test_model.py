"""The blur-model reader on rendered stress: what it adds, what it leaves, and the same on all executors."""

import math
from pathlib import Path

import pytest
import skimage.data
from PIL import Image

from larics.detect.detector import Detector
from larics.marker.detection import FLAG_BLUR_MODEL, FLAG_ID_UNCERTAIN
from larics_host.render import render_frame
from tests.host.test_kernels import execute

COUNT = 16
STRESSES = {
    "blur": (30, {"blur_px": 8}, 0),
    "defocus": (30, {"defocus_px": 3}, 0),
    "tiny": (8, {}, 0),
    "tilt": (30, {"tilt_deg": 25}, 25),
    "faint": (30, {"contrast": 8}, 0),
}


def read(found, truths, radius_px):
    """Right and wrong IDs near the one marker, and those of the model among them."""
    right = wrong = model = 0
    for one in found:
        assert math.hypot(one.x_q8 / 256 - truths[0].x_px, one.y_q8 / 256 - truths[0].y_px) < radius_px / 2
        if not one.flags & FLAG_ID_UNCERTAIN:
            right += one.marker_id == truths[0].id
            wrong += one.marker_id != truths[0].id
            model += bool(one.flags & FLAG_BLUR_MODEL)
    return right, wrong, model


@pytest.mark.parametrize("stress", STRESSES)
def test_stressed_markers_are_read(stress):
    radius_px, overrides, tilt_deg = STRESSES[stress]
    low, high = max(6, radius_px * 85 // 100), math.ceil(radius_px * 1.15)
    detector = Detector(360, 296, low, high, max_tilt_deg=tilt_deg)
    total = [0, 0, 0]
    for index in range(COUNT):
        frame, truths = render_frame("sunny", 1300, index, radius_px=radius_px, **overrides)
        for item, value in enumerate(read(detector.detect(frame), truths, radius_px)):
            total[item] += value
    right, wrong, model = total
    assert wrong == 0 and right >= COUNT - 3, total
    assert model >= 1 or stress in ("faint", "tilt")


def test_sharp_rules_alone_read_little_of_it():
    """Or the blur-model reader would be dead weight."""
    alone = Detector(360, 296, 6, 10, second_opinion=False)
    frames = [render_frame("sunny", 1300, index, radius_px=8) for index in range(COUNT)]
    assert sum(read(alone.detect(frame), truths, 8)[0] for frame, truths in frames) <= COUNT // 2


def test_what_is_faint_is_left_to_the_second_opinion():
    """In noise as strong as the lines the direct reader read wrong IDs now and then."""
    detector = Detector(360, 296, 25, 35)
    alone = Detector(360, 296, 25, 35, second_opinion=False)
    sharp = 0
    for index in range(COUNT):
        frame, truths = render_frame("cloudy", 1300, index, contrast=7)
        right, wrong, model = read(detector.detect(frame), truths, 30)
        assert wrong == 0 and right == model
        sharp += read(alone.detect(frame), truths, 30)[0]
    assert sharp >= 3


def test_clutter_gets_no_second_chance():
    detectors = (Detector(360, 296, 25, 35), Detector(360, 296, 6, 10))
    for index in range(30):
        frame, _ = render_frame("negative", 1300, index)
        for detector in detectors:
            assert not [one for one in detector.detect(frame) if one.flags & FLAG_BLUR_MODEL]
    folder = Path(skimage.data.__file__).parent
    for name in ("brick.png", "coins.png", "page.png", "camera.png"):
        pixels = Image.open(folder / name).convert("L").resize((360, 296)).tobytes()
        for detector in detectors:
            assert not [one for one in detector.detect(pixels) if one.flags & FLAG_BLUR_MODEL]


def test_all_executors_give_the_same_second_opinion(tmp_path):
    frames = (
        render_frame("sunny", 1300, 3, width=128, height=120, radius_px=24, blur_px=7),
        render_frame("sunny", 1300, 4, width=128, height=120, radius_px=24, defocus_px=2.6),
        render_frame("negative", 1300, 5, width=128, height=120, radius_px=24),
    )
    paths = []
    for index, (frame, _) in enumerate(frames):
        path = tmp_path / ("stress%d_r24_.pgm" % index)
        path.write_bytes(b"P5 128 120 255\n" + frame.tobytes())
        paths.append(str(path))
    expected = execute("numba", "golden.py", *paths).stdout
    assert expected.count("flags=16") + expected.count("flags=24") >= 1, expected
    for executor in ("plain", "strict", "micropython"):
        assert execute(executor, "golden.py", *paths).stdout == expected, executor
