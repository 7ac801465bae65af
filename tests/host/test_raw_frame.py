"""Raw frames: packed by the board's side, put together by the host's, whatever is lost or damaged."""

import pathlib
import random

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from larics.device.raw_frame import RawSender
from larics.device.sensor import Sensor
from larics.marker.detection import Detection
from larics.settings import Settings
from larics.wire import messages as m
from larics_host.connection.raw_frame import RawAssembly, unpacked
from larics_host.connection.records import RawChunk, RawHeader

ROOT = pathlib.Path(__file__).resolve().parents[2]


def transfer(frame, window=None):
    """The RawHeader and the RawChunks of a (height, width) uint8 frame."""
    sender = RawSender()
    height, width = frame.shape
    sender.start(9, frame.tobytes(), width, height, 70, window)
    assert sender.next() == m.RAW_HEADER
    header, chunks = RawHeader(*sender.values), []
    while sender.next():
        *numbers, data = sender.values
        chunks.append(RawChunk(*numbers, bytes(data)))
    return header, chunks


@st.composite
def frames(draw):
    width, height = draw(st.integers(1, 70)), draw(st.integers(1, 40))
    noise = np.random.default_rng(draw(st.integers(0, 1 << 20)))
    kind, strength = draw(st.integers(0, 3)), draw(st.integers(0, 60))
    if kind == 0:
        frame = np.full((height, width), draw(st.integers(0, 255)))
    elif kind == 1:
        frame = noise.integers(0, 2, (height, width)) * 255
    else:
        frame = np.add.outer(np.arange(height) * kind, np.arange(width)) + noise.normal(
            0, strength, (height, width)
        )
    left, top = draw(st.integers(0, width - 1)), draw(st.integers(0, height - 1))
    window = left, top, draw(st.integers(1, width - left)), draw(st.integers(1, height - top))
    return frame.clip(0, 255).astype(np.uint8), draw(st.sampled_from([None, window]))


@settings(max_examples=150)
@given(frames(), st.randoms())
def test_every_frame_comes_as_it_was_in_any_order_with_any_loss(made, order):
    frame, window = made
    header, chunks = transfer(frame, window)
    left, top, columns, rows = window or (0, 0, frame.shape[1], frame.shape[0])
    assert len(chunks) <= columns * rows // 64 + (columns + 15) // 16 + 1  # it never grows
    raw = RawAssembly(header)
    order.shuffle(chunks)
    lost = order.randrange(len(chunks))
    for chunk in chunks[:lost] + chunks[lost + 1 :] + chunks[: lost // 2]:
        assert raw.add(chunk) and raw.frame() is None
    assert raw.missing() == (chunks[lost].first, chunks[lost].count)
    assert raw.add(chunks[lost]) and raw.missing() is None
    whole = raw.frame()
    assert whole.frame == 70 and whole.window == (left, top, columns, rows)
    assert (
        whole.array()[top : top + rows, left : left + columns]
        == frame[top : top + rows, left : left + columns]
    ).all()


def test_pixels_asked_for_again_come_in_chunks_of_their_own():
    frame = cv2.imread(str(ROOT / "tests/frames/sunny_r10_1010_0.pgm"), cv2.IMREAD_GRAYSCALE)
    sender = RawSender()
    sender.start(9, frame.tobytes(), 160, 120, 70)
    sender.next()
    raw = RawAssembly(RawHeader(*sender._header))
    lossy = random.Random(4)
    rounds = 0
    while raw.missing() is not None:
        while sender.next():
            *numbers, data = sender.values
            if lossy.random() < 0.6:
                assert raw.add(RawChunk(*numbers, bytes(data)))
        if raw.missing() is not None:
            assert sender.again(*raw.missing())
        rounds += 1
    assert (raw.frame().array() == frame).all() and rounds > 20


@settings(max_examples=300)
@given(
    st.binary(min_size=64, max_size=64), st.integers(0, 8), st.integers(1, 505), st.integers(1, 16), st.data()
)
def test_damaged_bytes_are_pixels_or_nothing(data, coding, count, width, rest):
    found = unpacked(data, coding, count, rest.draw(st.integers(0, width - 1)), width)
    assert found is None or (len(found) == count and all(0 <= pixel <= 255 for pixel in found))


def test_what_does_not_belong_to_the_frame_is_refused():
    frame = np.arange(40 * 10, dtype=np.int32).reshape(10, 40).astype(np.uint8)
    header, chunks = transfer(frame)
    raw = RawAssembly(header)
    first = chunks[0]
    for wrong in (
        first._replace(token=8),
        first._replace(first=400),
        first._replace(first=m.COUNT_MAX),
        first._replace(count=161),  # beyond its strip
        first._replace(count=first.count - 1),  # bits are left over
        first._replace(coding=m.RAW_PLAIN),
        first._replace(data=first.data[:-1]),
    ):
        assert not raw.add(wrong), wrong
    assert raw.received == 0 and raw.missing() == (0, 400)
    huge = RawAssembly(header._replace(columns=65535, rows=65535))
    assert not huge.add(first) and huge.missing() is not None and huge.frame() is None
    outside = RawAssembly(header._replace(left=1))
    damaged = RawAssembly(header._replace(crc_low=header.crc_low ^ 1))
    for raw in (outside, damaged):
        assert all([raw.add(chunk) for chunk in chunks]) and raw.frame() is None


@pytest.mark.parametrize(
    ("name", "most"),
    [("harsh_r30_1004_0.pgm", 0.6), ("cloudy_r45_1024_0.pgm", 0.35), ("sunny_r30_1000_0.pgm", 0.7)],
)
def test_rendered_frames_take_far_fewer_bytes(name, most):
    frame = cv2.imread(str(ROOT / "tests/frames" / name), cv2.IMREAD_GRAYSCALE)
    assert len(transfer(frame)[1]) * 64 < most * frame.size


def test_a_window_holds_the_plates_of_all_markers():
    sensor = Sensor(Settings(), (360, 296))
    assert sensor.window(360, 296) is None
    three = (30, 30, 15), (200, 100, 30), (350, 140, 20)
    for places in (three, three[:1], three[1:2]):
        sensor.found = [Detection() for _ in places]
        for one, (x, y, radius) in zip(sensor.found, places, strict=True):
            one.x_q8, one.y_q8, one.radius_q8 = 256 * x + 200, 256 * y + 200, 256 * radius + 200
        left, top, columns, rows = sensor.window(360, 296)
        assert 0 <= left < left + columns <= 360 and 0 <= top < top + rows <= 296
        for x, y, radius in places:
            plate = (radius + 1) * 5 / 3
            assert left <= max(0, x - plate) and min(360, x + 2 + plate) <= left + columns
            assert top <= max(0, y - plate) and min(296, y + 2 + plate) <= top + rows
    assert columns < 140 and rows < 140  # and not much more than that
    sensor.found[0].x_q8 = -20000  # an estimate may lie outside
    assert sensor.window(360, 296) is None
