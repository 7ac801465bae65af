"""The published method against independent float implementations, drawn markers and bad input."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from larics.detect.paper import PaperDetector
from larics.kernels import paper as kernels
from larics.marker import CODE_ANGLES_CDEG, LARICS3, LINE, Family, detection
from larics_host.images.frame_sources import open_frames
from larics_host.truth import read_truth

WIDTH, HEIGHT = 120, 90
RANDOM = np.random.default_rng(1000)


def draw(
    marker_id, width=WIDTH, height=HEIGHT, radius=18.0, x=60.3, y=44.6, heading=30.0, family=LARICS3, noise=0
):
    """A level marker, anti-aliased, as an array; dark 40 on a plate of 220, background 150."""
    scale, shift = 8, 4
    size = (height * scale, width * scale)
    image = np.full(size, 150, np.uint8)
    mm10 = radius * scale / family.outer_mm10
    centre = np.array([(x + 0.5) * scale, (y + 0.5) * scale]) - 0.5

    def fixed_point(point):
        return tuple(int(round(v * (1 << shift))) for v in point)

    def disc(radius_mm10, grey):
        cv2.circle(
            image, fixed_point(centre), round(radius_mm10 * mm10 * (1 << shift)), grey, -1, cv2.LINE_8, shift
        )

    disc(family.plate_mm10, 220)
    for kind, *numbers in family.strokes(marker_id):
        if kind == LINE:
            angle_cdeg, start, end, line = numbers
            angle = math.radians(heading + angle_cdeg / 100)
            along = np.array([math.cos(angle), -math.sin(angle)]) * mm10
            across = np.array([along[1], -along[0]]) * line / 2
            corners = [
                along * start + across,
                along * end + across,
                along * end - across,
                along * start - across,
            ]
            points = np.array([fixed_point(centre + corner) for corner in corners], np.int32)
            cv2.fillPoly(image, [points], 40, cv2.LINE_8, shift)
        else:
            ring, line = numbers
            cv2.circle(
                image,
                fixed_point(centre),
                round(ring * mm10 * (1 << shift)),
                40,
                round(line * mm10),
                cv2.LINE_8,
                shift,
            )
    image = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA).astype(float)
    image += RANDOM.normal(0, noise, image.shape) if noise else 0
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def gradient_band(frame, floor=1):
    """gx, gy and magnitude of every inner row, from the kernel, as float arrays."""
    height, width = frame.shape
    rows = height - 2
    band = [np.zeros(rows * width, np.uint16) for _ in range(3)]
    kernels.sobel(frame.reshape(-1), *band, width, 1, rows, floor * floor)
    gx, gy, magnitude = (items.reshape(rows, width)[:, 1:-1].astype(float) for items in band)
    return gx - 1024, gy - 1024, magnitude / 16


def noise_frame(seed):
    return np.random.default_rng(seed).integers(0, 256, (HEIGHT, WIDTH), dtype=np.uint8)


@pytest.mark.parametrize("frame", [draw(5), noise_frame(1), np.full((HEIGHT, WIDTH), 255, np.uint8)])
def test_sobel_is_that_of_opencv(frame):
    gx, gy, magnitude = gradient_band(frame)
    inner = np.s_[1:-1, 1:-1]
    expected_x = cv2.Sobel(frame, cv2.CV_64F, 1, 0)[inner]
    expected_y = cv2.Sobel(frame, cv2.CV_64F, 0, 1)[inner]
    assert np.array_equal(gx, expected_x) and np.array_equal(gy, expected_y)
    root = np.hypot(expected_x, expected_y)
    assert np.all(magnitude <= root + 1e-9) and np.all(magnitude > root - 1 / 16)


def test_the_root_is_skipped_below_the_floor():
    frame = noise_frame(2)
    _, _, all_of_it = gradient_band(frame)
    _, _, above = gradient_band(frame, floor=200)
    assert np.array_equal(above, np.where(all_of_it >= 200, all_of_it, 0))


def float_votes(frame, threshold, ranges):
    """Equations 1 to 3 in floating point, written as loops over radii, not pixels."""
    gx = cv2.Sobel(frame, cv2.CV_64F, 1, 0)
    gy = cv2.Sobel(frame, cv2.CV_64F, 0, 1)
    magnitude = np.hypot(gx, gy)
    edges = magnitude >= threshold
    edges[[0, -1]] = False
    edges[:, [0, -1]] = False
    y, x = np.nonzero(edges)
    cos, sin = gx[y, x] / magnitude[y, x], gy[y, x] / magnitude[y, x]
    votes = np.zeros(frame.shape)
    for first, last in ranges:
        for r in range(first, last + 1):
            for side in (1, -1):
                vx = np.floor(x + side * r * cos + 0.5).astype(int)
                vy = np.floor(y + side * r * sin + 0.5).astype(int)
                inside = (vx >= 0) & (vx < frame.shape[1]) & (vy >= 0) & (vy < frame.shape[0])
                np.add.at(votes, (vy[inside], vx[inside]), 1)
    return votes


@pytest.mark.parametrize("radii", [(16, 20), (10, 30)])
def test_votes_are_those_of_the_equations(radii):
    frame = draw(3, noise=4)
    detector = PaperDetector(WIDTH, HEIGHT, *radii, edge_threshold=100)
    (found,) = detector.detect(frame)
    low, high = radii
    outer = (math.floor(low * 14 / 15), math.ceil(high * 16 / 15))
    inner = (math.floor(low * 9 / 15), math.ceil(high * 11 / 15))
    ranges = [inner, outer] if inner[1] + 1 < outer[0] else [(inner[0], outer[1])]
    expected = float_votes(frame, 100, ranges)
    votes = np.array(detector.accumulator, float).reshape(HEIGHT, WIDTH)
    # a vote may fall into the next cell where rounding is close to one half
    assert abs(votes.sum() - expected.sum()) <= 0.001 * expected.sum()
    assert np.abs(votes - expected).sum() <= 0.01 * expected.sum()
    assert detector.votes == votes.max()
    assert (found.y_q8 >> 8, found.x_q8 >> 8) == np.unravel_index(votes.argmax(), votes.shape)


def float_window(frame, x0, y0, half, box, share):
    """Local threshold with plain means over clipped squares."""
    height, width = frame.shape
    window = np.zeros((2 * half + 1, 2 * half + 1), np.uint8)
    for y in range(max(0, y0 - half), min(height, y0 + half + 1)):
        for x in range(max(0, x0 - half), min(width, x0 + half + 1)):
            square = frame[max(0, y - box) : y + box + 1, max(0, x - box) : x + box + 1]
            window[y - y0 + half, x - x0 + half] = frame[y, x] < square.mean() * (1 - share) - 1e-9
    return window


@settings(max_examples=40)
@given(
    x0=st.integers(0, WIDTH - 1),
    y0=st.integers(0, HEIGHT - 1),
    half=st.integers(0, 20),
    box=st.integers(0, 25),
    share=st.sampled_from([0, 36, 64, 128]),
    seed=st.integers(0, 1000),
)
def test_the_window_is_that_of_local_means(x0, y0, half, box, share, seed):
    frame = noise_frame(seed) if seed % 3 else draw(6)
    window = bytearray((2 * half + 1) ** 2)
    columns = np.full(WIDTH, 12345, np.int32)
    kernels.binarise(frame.reshape(-1), window, columns, WIDTH, HEIGHT, x0, y0, half, box, share)
    expected = float_window(frame, x0, y0, half, box, share / 256)
    assert np.array_equal(np.frombuffer(window, np.uint8).reshape(expected.shape), expected)


def float_sums(window):
    """Equation 7 in floating point; the second array is True where no sample is near a pixel's border."""
    half = len(window) // 2
    angles = np.radians(np.arange(360))[:, None]
    r = np.arange(half + 1)[None, :]
    x, y = half + r * np.cos(angles), half - r * np.sin(angles)
    clear = np.abs(np.stack([x, y]) % 1 - 0.5).min(axis=0) > 0.01
    return window[np.floor(y + 0.5).astype(int), np.floor(x + 0.5).astype(int)].sum(axis=1), clear.all(axis=1)


def test_radial_sums_are_those_of_equation_7():
    detector = PaperDetector(WIDTH, HEIGHT, 15, 21)
    assert detector.detect(draw(6, heading=77, noise=3))
    side = detector.window_side
    window = np.frombuffer(detector.window, np.uint8)[: side * side].reshape(side, side)
    expected, clear = float_sums(window)
    sums = np.array(detector.radial_sums)
    assert clear.sum() > 100
    assert np.array_equal(sums[clear], expected[clear])
    assert np.abs(sums - expected).max() <= 2


def test_n_is_that_of_equation_8():
    """Scale times the outer radius plus the length of the orientation line: 46 at 2 px/cm."""
    detector = PaperDetector(360, 296, 30, 30)
    assert detector.detect(draw(3, 360, 296, 30.0, 180, 150))
    assert detector.window_side == 2 * 46 + 1


def test_bits_are_those_of_equation_9():
    for marker_id in LARICS3.ids():
        detector = PaperDetector(WIDTH, HEIGHT, 16, 20)
        (found,) = detector.detect(draw(marker_id, heading=120))
        sums = detector.radial_sums
        alpha0 = found.heading_cdeg // 100
        z = sum(sums[(alpha0 + 45 * n) % 360] for n in range(1, 8)) / 6
        assert detector.z6 == round(6 * z)
        bits = [sums[(alpha0 + angle // 100) % 360] > z for angle in CODE_ANGLES_CDEG]
        assert found.marker_id == sum(bit << 2 - i for i, bit in enumerate(bits)) == marker_id
        assert sums[alpha0] == max(sums)


@pytest.mark.parametrize(
    "radius, size, share",
    [(30.0, (360, 296), 0.9), (24.0, (160, 120), 0.8), (45.0, (320, 240), 0.9), (58.0, (640, 480), 0.9)],
)
def test_clean_markers_are_read(radius, size, share):
    """Centre and radius are always right. H of a coding line comes close to that of the orientation line, so
    that a few markers, more of the small ones, are read from a coding line."""
    width, height = size
    random = np.random.default_rng(1001)
    tried = read = 0
    for marker_id in LARICS3.ids() * 2:
        x, y = width / 2 + random.uniform(-2, 2), height / 2 + random.uniform(-2, 2)
        heading = random.uniform(0, 360)
        frame = draw(marker_id, width, height, radius, x, y, heading, noise=2)
        for low, high in ((int(radius * 0.9), int(radius * 1.1)), (10, 60)):
            (found,) = PaperDetector(width, height, low, high).detect(frame)
            assert math.hypot(found.x_q8 / 256 - x, found.y_q8 / 256 - y) < 1
            assert abs(found.radius_q8 / 256 - radius) < 0.04 * radius + 0.5
            off = (found.heading_cdeg / 100 - heading + 180) % 360 - 180
            assert abs((off + 45) % 90 - 45) < 12  # along one of the lines
            tried += 1
            if abs(off) < 4:
                assert found.marker_id == marker_id
                read += 1
    assert read >= share * tried


def test_golden_frames_in_good_light_are_read():
    folder = Path(__file__).resolve().parents[1] / "frames"
    found = read = 0
    truths = [truth for truth in read_truth(folder) if truth.frame.startswith(("sunny", "double", "fast"))]
    for truth in truths:
        ((_, frame),) = open_frames([folder / truth.frame])
        low, high = math.floor(0.85 * truth.radius_px), math.ceil(1.15 * truth.radius_px)
        detections = PaperDetector(frame.shape[1], frame.shape[0], low, high).detect(frame)
        for one in detections:
            if math.hypot(one.x_q8 / 256 - truth.x_px, one.y_q8 / 256 - truth.y_px) < 1.5:
                found += 1
                heading = (one.heading_cdeg / 100 - truth.heading_deg + 180) % 360 - 180
                read += one.marker_id == truth.id and abs(heading) < 6
    assert len(truths) >= 15
    assert found >= 0.9 * len(truths) and read >= 0.5 * len(truths)


@pytest.mark.parametrize("size", [(80, 60), (81, 61), (160, 120), (360, 296), (640, 480)])
@pytest.mark.parametrize("threshold", [None, 60])
def test_frames_without_a_marker(size, threshold):
    width, height = size
    detector = PaperDetector(width, height, 10, 25, edge_threshold=threshold)
    for grey in (0, 128, 255):
        assert detector.detect(np.full((height, width), grey, np.uint8)) == []
    ramp = np.tile(np.linspace(0, 255, width).astype(np.uint8), (height, 1))
    assert detector.detect(ramp) == []
    assert (
        len(detector.detect(np.random.default_rng(0).integers(0, 256, (height, width), dtype=np.uint8))) <= 1
    )


def test_a_marker_at_the_border_is_flagged():
    detector = PaperDetector(WIDTH, HEIGHT, 16, 20)
    (found,) = detector.detect(draw(7, x=22, heading=0))
    assert found.flags & detection.FLAG_BORDER
    (found,) = detector.detect(draw(7))
    assert not found.flags & detection.FLAG_BORDER


def test_an_id_that_is_not_in_use_is_uncertain():
    family = Family(allow_id0=True)
    frame = draw(0, radius=28.0, width=160, height=120, x=80, y=60, family=family)
    (found,) = PaperDetector(160, 120, 25, 31).detect(frame)
    assert (found.marker_id, found.flags) == (detection.NO_ID, detection.FLAG_ID_UNCERTAIN)
    (found,) = PaperDetector(160, 120, 25, 31, family=family).detect(frame)
    assert (found.marker_id, found.flags) == (0, 0)


def test_the_heading_is_the_middle_of_equal_maxima():
    detector = PaperDetector(WIDTH, HEIGHT, 16, 20)
    for first, last, middle in ((10, 14, 12), (0, 0, 0), (358, 2 + 360, 0), (100, 103, 101)):
        for angle in range(360):
            detector.radial_sums[angle] = 5
        for angle in range(first, last + 1):
            detector.radial_sums[angle % 360] = 9
        assert detector._orientation() == middle


def test_results_are_reused_and_frames_are_independent():
    detector = PaperDetector(WIDTH, HEIGHT, 16, 20)
    first = detector.detect(draw(5))
    kept = repr(first)
    assert detector.detect(np.zeros((HEIGHT, WIDTH), np.uint8)) == []
    again = detector.detect(draw(5))
    assert again is first and repr(again) == kept


def test_any_buffer_of_pixels_will_do():
    frame = draw(6)
    detector = PaperDetector(WIDTH, HEIGHT, 16, 20)
    results = {repr(detector.detect(kind(frame.tobytes()))) for kind in (bytes, bytearray, memoryview)}
    results.add(repr(detector.detect(frame)))
    assert len(results) == 1


@pytest.mark.parametrize("length", [0, 1, WIDTH * HEIGHT - 1, WIDTH * HEIGHT + 1])
def test_a_frame_of_another_size_is_refused(length):
    with pytest.raises(ValueError, match="a frame of %d bytes is not 120x90" % length):
        PaperDetector(WIDTH, HEIGHT, 16, 20).detect(bytes(length))


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((0, 90, 10, 20), "not within 16x16 and 1024x1024"),
        ((120, 2000, 10, 20), "not within 16x16 and 1024x1024"),
        ((120, 90, 20, 10), "no range of radii"),
        ((120, 90, 0, 10), "no range of radii"),
        ((80, 60, 30, 40), "smaller than a ring of radius 30"),
        ((640, 480, 20, 95), "radius of 95 px is too large"),
        ((120, 90, 10, 20, 0), "edge threshold of 0"),
        ((120, 90, 10, 20, 2000), "edge threshold of 2000"),
    ],
)
def test_impossible_settings_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        PaperDetector(*arguments)


def test_memory_is_stated():
    detector = PaperDetector(360, 296, 25, 35)
    memory = detector.memory()
    assert memory["accumulator"] == 2 * 360 * 296
    assert memory["window"] == (2 * 54 + 1) ** 2
    owned = [
        value
        for value in vars(detector).values()
        if hasattr(value, "itemsize") or isinstance(value, bytearray)
    ]
    assert sum(memoryview(value).nbytes for value in owned) == sum(memory.values())
