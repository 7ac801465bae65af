"""Frames come out of every kind of source as they were put in, and bad sources give one clear line."""

import os
import struct

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from larics_host import errors
from larics_host.errors import UserError
from larics_host.images.frame_sources import open_frames
from larics_host.images.openmv_stream import BAYER, BINARY, GRAYSCALE, RGB565
from tests.host.mjpeg import tag_turn

FRAME = np.random.default_rng(7).integers(0, 256, (31, 45), dtype=np.uint8)


def pgm(frame, maximum=255):
    height, width = frame.shape
    return b"P5\n%d %d\n%d\n" % (width, height, maximum) + frame.tobytes()


def padded(data):
    return data + bytes(-len(data) % 16)


def stream_v2(*frames):
    """Frames are (pixel format, width, height, data, size)."""
    parts = [b"OMV IMG STR V2.0"]
    for pixel_format, width, height, data, size in frames:
        parts += [struct.pack("<5I12x", 33, width, height, pixel_format, size), padded(data)]
    return b"".join(parts)


def stream_v1(version, *frames):
    parts = [b"OMV IMG STR V" + version]
    for bpp, width, height, data in frames:
        parts += [struct.pack("<4I", 33, width, height, bpp), padded(data)]
    return b"".join(parts)


def encoded(extension, image=FRAME):
    return cv2.imencode(extension, image)[1].tobytes()


def write(path, data):
    path.write_bytes(data)
    return path


def read(path):
    return [frame for _, frame in open_frames([path])]


def one(path):
    (frame,) = read(path)
    assert frame.dtype == np.uint8 and frame.ndim == 2
    return frame


def failure(*paths):
    with pytest.raises(UserError) as caught:
        list(open_frames(paths))
    text = str(caught.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize("header", [b"P5\n45 31\n255\n", b"P5 # made by\n# two comments\n45\t31 255 "])
def test_pgm(tmp_path, header):
    assert (one(write(tmp_path / "a.pgm", header + FRAME.tobytes())) == FRAME).all()


def test_pgm_as_text(tmp_path):
    text = b"P2\n# c\n45 31\n255\n" + b"\n".join(b" ".join(b"%d" % v for v in row) for row in FRAME)
    assert (one(write(tmp_path / "a.pgm", text)) == FRAME).all()


def test_png_and_jpeg(tmp_path):
    assert (one(write(tmp_path / "a.png", encoded(".png"))) == FRAME).all()
    smooth = cv2.GaussianBlur(FRAME, (0, 0), 5)
    shades = one(write(tmp_path / "a.JPG", encoded(".jpg", smooth)))
    assert np.abs(shades.astype(int) - smooth).max() <= 4


def test_the_content_counts_not_the_extension(tmp_path):
    assert (one(write(tmp_path / "a.jpg", encoded(".png"))) == FRAME).all()
    assert (one(write(tmp_path / "noname", pgm(FRAME))) == FRAME).all()


def test_colour_becomes_grey(tmp_path):
    colour = np.zeros((20, 30, 3), np.uint8)
    colour[:] = (200, 100, 50)  # blue, green, red
    frame = one(write(tmp_path / "a.png", encoded(".png", colour)))
    assert frame.shape == (20, 30) and abs(int(frame[0, 0]) - 96.45) <= 1  # 0.114 B + 0.587 G + 0.299 R
    transparent = np.dstack([colour, np.full((20, 30), 255, np.uint8)])
    assert (one(write(tmp_path / "b.png", encoded(".png", transparent))) == frame).all()
    Image.fromarray(colour).quantize(4).save(tmp_path / "c.png")
    assert one(tmp_path / "c.png").shape == (20, 30)


def test_a_folder_in_natural_order_without_what_is_no_frame(tmp_path):
    for index in (10, 2, 1):
        write(tmp_path / ("f%d.pgm" % index), pgm(np.full((8, 8), index, np.uint8)))
    write(tmp_path / "truth.csv", b"frame\n")
    write(tmp_path / ".hidden.pgm", b"x")
    (tmp_path / "sub.png").mkdir()
    assert [int(frame[0, 0]) for frame in read(tmp_path)] == [1, 2, 10]
    assert [os.path.basename(name) for name, _ in open_frames([tmp_path])] == ["f1.pgm", "f2.pgm", "f10.pgm"]


def clip(path, levels):
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (64, 48))
    assert video.isOpened()
    for level in levels:
        video.write(np.full((48, 64, 3), level, np.uint8))
    video.release()
    return path


def test_video(tmp_path, capfd):
    path = clip(tmp_path / "clip.avi", (40, 120, 200))
    frames = list(open_frames([path]))
    assert [name for name, _ in frames] == ["%s#%d" % (path, index) for index in range(3)]
    assert [round(float(frame.mean()), -1) for _, frame in frames] == [40, 120, 200]
    assert all(frame.shape == (48, 64) for _, frame in frames)
    assert capfd.readouterr().err == ""


def test_motion_jpeg_without_a_container(tmp_path, capfd):
    data = b"".join(encoded(".jpg", np.full((48, 64), level, np.uint8)) for level in (40, 120, 200))
    frames = read(write(tmp_path / "clip.mjpeg", data))
    assert [round(float(frame.mean()), -1) for frame in frames] == [40, 120, 200]
    assert capfd.readouterr().err == ""


def test_a_video_cut_short_gives_the_frames_it_has_and_says_so(tmp_path, capfd):
    data = clip(tmp_path / "clip.avi", [100] * 200).read_bytes()
    path = write(tmp_path / "cut.avi", data[: len(data) * 7 // 10])
    count = len(read(path))
    assert 50 < count < 150
    line = "larics: %s: the video ends early: expected 200 frames, read %d\n" % (path, count)
    assert capfd.readouterr().err.endswith(line)


def test_openmv_stream_of_grey_frames(tmp_path):
    other = 255 - FRAME
    data = stream_v2((GRAYSCALE, 45, 31, FRAME.tobytes(), 0), (GRAYSCALE, 45, 31, other.tobytes(), 1395))
    first, second = read(write(tmp_path / "s.bin", data))
    assert (first == FRAME).all() and (second == other).all()
    for version in (b"1.0", b"1.1"):
        data = stream_v1(version, (1, 45, 31, FRAME.tobytes()), (1, 45, 31, other.tobytes()))
        first, second = read(write(tmp_path / "s.bin", data))
        assert (first == FRAME).all() and (second == other).all()


def test_openmv_streams_one_after_the_other(tmp_path):
    frames = [FRAME, FRAME[::-1].copy(), FRAME[:, ::-1].copy()]
    parts = [(GRAYSCALE, frame.shape[1], frame.shape[0], frame.tobytes(), frame.size) for frame in frames]
    path = write(tmp_path / "a.bin", stream_v2(*parts[:2]) + stream_v2(parts[2]))
    assert all((a == b).all() for a, b in zip(read(path), frames, strict=True))
    old = [(1, frame.shape[1], frame.shape[0], frame.tobytes()) for frame in frames]
    path = write(tmp_path / "b.bin", stream_v1(b"1.1", old[0]) + stream_v1(b"1.1", *old[1:]))
    assert all((a == b).all() for a, b in zip(read(path), frames, strict=True))


def test_openmv_stream_of_compressed_frames(tmp_path):
    data = encoded(".png")
    assert (one(write(tmp_path / "p.bin", stream_v2((0x06070000, 45, 31, data, len(data))))) == FRAME).all()
    data = encoded(".jpg")
    new = one(write(tmp_path / "n.bin", stream_v2((0x06060000, 45, 31, data, len(data)))))
    old = one(write(tmp_path / "o.bin", stream_v1(b"1.1", (len(data), 45, 31, data))))
    assert new.shape == (31, 45) and (new == old).all()


def test_openmv_stream_of_colour_frames(tmp_path):
    red, green, blue = 0xF800, 0x07E0, 0x001F
    pixels = np.array([[red, green, blue, 0xFFFF, 0]], np.uint16)
    grey = [[75, 149, 29, 255, 0]]  # 38, 75 and 15 parts of 128
    for name, data in (
        ("2.0", stream_v2((RGB565, 5, 1, pixels.astype("<u2").tobytes(), 0))),
        ("1.1", stream_v1(b"1.1", (2, 5, 1, pixels.astype("<u2").tobytes()))),
        ("1.0", stream_v1(b"1.0", (2, 5, 1, pixels.astype(">u2").tobytes()))),
    ):
        assert one(write(tmp_path / (name + ".bin"), data)).tolist() == grey, name
    yuv = np.dstack([FRAME, 255 - FRAME]).tobytes()
    assert (one(write(tmp_path / "y.bin", stream_v2((0x14050002, 45, 31, yuv, 0)))) == FRAME).all()


def test_openmv_stream_of_binary_frames(tmp_path):
    bits = (FRAME > 127).astype(np.uint8)
    words = np.zeros((31, 64), np.uint8)
    words[:, :45] = bits
    data = np.packbits(words, axis=1, bitorder="little").tobytes()
    assert (one(write(tmp_path / "b.bin", stream_v2((BINARY, 45, 31, data, 0)))) == bits * 255).all()


@pytest.mark.parametrize("pixel_format, pattern", BAYER.items())
def test_openmv_stream_of_bayer_frames(tmp_path, pixel_format, pattern):
    """A scene that is blue alone stays blue, whichever corner the pattern starts in."""
    mosaic = np.zeros((32, 48), np.uint8)
    for place, colour in enumerate(pattern):
        if colour == "B":
            mosaic[place // 2 :: 2, place % 2 :: 2] = 200
    frame = one(write(tmp_path / "b.bin", stream_v2((pixel_format, 48, 32, mosaic.tobytes(), 0))))
    assert np.abs(frame[4:-4, 4:-4].astype(int) - 0.114 * 200).max() <= 2


def test_what_is_missing_or_empty(tmp_path):
    assert "no such file" in failure(tmp_path / "nothing.pgm")
    assert "no frames in this folder" in failure(tmp_path)
    assert "empty file" in failure(write(tmp_path / "e.pgm", b""))
    assert "not a file" in failure("/dev/null")
    assert "not an image" in failure(write(tmp_path / "t.txt", b"hello"))
    assert "video" in failure(write(tmp_path / "v.mp4", b"hello" * 100))
    assert "strerror" not in failure(tmp_path / ("x" * 5000))


def test_what_is_truncated(tmp_path):
    assert "truncated" in failure(write(tmp_path / "a.pgm", pgm(FRAME)[:-1]))
    assert "truncated" in failure(write(tmp_path / "b.pgm", b"P5\n45"))
    assert "truncated" in failure(write(tmp_path / "c.png", encoded(".png")[:-200]))
    assert "truncated" in failure(write(tmp_path / "d.jpg", encoded(".jpg")[:-200]))
    stream = stream_v2((GRAYSCALE, 45, 31, FRAME.tobytes(), 0), (GRAYSCALE, 45, 31, FRAME.tobytes(), 0))
    assert "frame 1: truncated" in failure(write(tmp_path / "e.bin", stream[:-100]))
    assert "frame 1: truncated" in failure(write(tmp_path / "f.bin", stream[: 48 + 1408 + 10]))
    assert "no frame" in failure(write(tmp_path / "g.bin", stream[:16]))


def test_what_has_16_bits(tmp_path):
    deep = FRAME.astype(np.uint16) * 257
    wide = np.dstack([deep] * 3)
    for name, data in (
        ("a.png", encoded(".png", deep)),
        ("b.png", encoded(".png", wide)),
        ("c.pgm", b"P5 45 31 65535 " + deep.tobytes()),
    ):
        text = failure(write(tmp_path / name, data))
        assert "16-bit" in text and "8 bits" in text and name in text


def test_what_is_wrong_inside(tmp_path):
    assert "convert it to 255" in failure(write(tmp_path / "a.pgm", pgm(FRAME, 100)))
    assert "no pixels" in failure(write(tmp_path / "b.pgm", b"P5 0 10 255 "))
    assert "more than a frame" in failure(write(tmp_path / "c.pgm", b"P5 999999 999999 255 "))
    assert "bytes more" in failure(write(tmp_path / "d.pgm", pgm(FRAME) + b"zz"))
    assert "no number" in failure(write(tmp_path / "e.pgm", b"P2 2 1 255 1 x"))
    assert "outside" in failure(write(tmp_path / "f.pgm", b"P2 2 1 255 1 256"))
    assert "version" in failure(write(tmp_path / "g.bin", b"OMV IMG STR V3.0"))
    assert "pixel format" in failure(write(tmp_path / "h.bin", stream_v2((0x1234, 4, 4, bytes(16), 0))))
    huge = stream_v2((GRAYSCALE, 1 << 31, 1 << 31, b"", 0))
    assert "more than a frame" in failure(write(tmp_path / "i.bin", huge))
    data = encoded(".png")
    stream = stream_v2((0x06070000, 40, 31, data, len(data)))
    assert "another size" in failure(write(tmp_path / "j.bin", stream))


def test_one_bad_file_does_not_lose_the_others(tmp_path):
    write(tmp_path / "1.pgm", pgm(FRAME))
    write(tmp_path / "2.pgm", b"P5 broken")
    write(tmp_path / "3.pgm", pgm(FRAME))
    errors = []
    names = [name for name, _ in open_frames([tmp_path, tmp_path / "no"], errors.append)]
    assert [os.path.basename(name) for name in names] == ["1.pgm", "3.pgm"]
    assert len(errors) == 2 and "2.pgm" in str(errors[0]) and "no such" in str(errors[1])


SEEDS = (
    pgm(FRAME[:6, :9]),
    b"P2\n3 2\n255\n1 2 3 4 5 6\n",
    encoded(".png", FRAME[:8, :8]),
    encoded(".jpg", FRAME[:8, :8]),
    stream_v2((GRAYSCALE, 9, 6, FRAME[:6, :9].tobytes(), 0), (BINARY, 9, 6, bytes(24), 0)),
    stream_v2((0x06060000, 8, 8, encoded(".jpg", FRAME[:8, :8]), len(encoded(".jpg", FRAME[:8, :8])))),
    stream_v1(b"1.0", (2, 4, 4, bytes(32)), (3, 4, 4, bytes(16))),
)


@settings(max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(
    seed=st.sampled_from(SEEDS),
    changes=st.lists(st.tuples(st.integers(0, 10**6), st.binary(max_size=5), st.integers(0, 5)), max_size=4),
    length=st.integers(0, 10**6),
)
def test_no_bytes_lead_to_anything_but_frames_or_a_user_error(tmp_path, seed, changes, length):
    data = bytearray(seed)
    for place, new, removed in changes:
        place %= len(data) + 1
        data[place : place + removed] = new
    if changes and length % 3 == 0:
        del data[length % (len(data) + 1) :]
    path = write(tmp_path / "fuzz.bin", bytes(data))
    errors = []
    for _, frame in open_frames([path], errors.append):
        assert frame.dtype == np.uint8 and frame.ndim == 2 and frame.size
    assert len(errors) <= 1
    assert changes or not errors


def alpha_cases():
    """(mode, image, how to save it, expected frame): right half transparent, below it half so."""
    ink = np.full((20, 30), 40, np.uint8)
    alpha = np.full((20, 30), 255, np.uint8)
    alpha[:, 15:] = 0
    alpha[10:, 15:] = 128
    expected = np.where(alpha == 255, 40, np.where(alpha == 0, 255, 147)).astype(np.uint8)
    hard = np.where(alpha == 255, 40, 255).astype(np.uint8)
    yield "LA", Image.merge("LA", [Image.fromarray(ink), Image.fromarray(alpha)]), {}, expected
    yield "RGBA", Image.merge("RGBA", [Image.fromarray(ink)] * 3 + [Image.fromarray(alpha)]), {}, expected
    keyed = np.where(alpha == 255, ink, 0).astype(np.uint8)
    yield "L", Image.fromarray(keyed), {"transparency": 0}, hard
    yield "RGB", Image.fromarray(keyed).convert("RGB"), {"transparency": (0, 0, 0)}, hard
    entries = np.where(alpha == 255, 0, np.where(alpha == 0, 1, 2)).astype(np.uint8)
    palette = Image.fromarray(entries, "P")
    palette.putpalette([40, 40, 40, 0, 0, 0, 40, 40, 40])
    yield "P", palette, {"transparency": bytes([255, 0, 128])}, expected
    yield "1", Image.fromarray(keyed > 0), {"transparency": 0}, np.full((20, 30), 255, np.uint8)


@pytest.mark.parametrize("mode, image, options, expected", list(alpha_cases()))
def test_transparent_paper_is_white_in_every_mode(tmp_path, mode, image, options, expected):
    image.save(tmp_path / "a.png", **options)
    frame = one(tmp_path / "a.png")
    assert np.abs(frame.astype(int) - expected).max() <= 1


@pytest.mark.parametrize("extension", ["png", "jpg"])
def test_tags_that_turn_a_picture_are_named_and_not_obeyed(tmp_path, capsys, extension):
    smooth = Image.fromarray(cv2.GaussianBlur(FRAME, (0, 0), 5))
    smooth.save(tmp_path / ("plain." + extension))
    plain = one(tmp_path / ("plain." + extension))
    for orientation in range(10):
        errors.begin_run()
        exif = Image.Exif()
        exif[274] = orientation
        path = tmp_path / ("turned%d.%s" % (orientation, extension))
        smooth.save(path, exif=exif)
        assert (one(path) == plain).all()
        said = capsys.readouterr().err
        if 2 <= orientation <= 8:
            assert said.count("\n") == 1 and path.name in said and "turned" in said
            assert "taken as the camera delivered them" in said
            one(path)
            assert capsys.readouterr().err == ""  # once is enough
        else:
            assert said == ""


def test_a_damaged_tag_does_not_deny_the_picture(tmp_path, capsys):
    Image.fromarray(FRAME).save(tmp_path / "a.jpg", exif=b"Exif\0\0MM\0*\0\0\xff\xff")
    assert one(tmp_path / "a.jpg").shape == FRAME.shape and capsys.readouterr().err == ""


@pytest.mark.parametrize("turn", [0, 90, 180, 270])
def test_a_video_is_taken_as_the_camera_delivered_it(tmp_path, capsys, turn):
    errors.begin_run()
    path = tmp_path / "a.mp4"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 10, (64, 48))
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:12, :16] = 250
    video.write(picture)
    video.release()
    tag_turn(path, turn)
    frame = one(path)
    assert frame.shape == (48, 64) and frame[3, 3] > 200 and frame[40, 60] < 50
    said = capsys.readouterr().err
    assert ("turned by" in said and "a.mp4" in said) if turn else said == ""


@pytest.mark.parametrize("name", ["a.avi", "a.bak", "a"])
def test_a_video_is_known_by_its_content_under_any_name(tmp_path, name):
    path = tmp_path / "a.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (64, 48))
    video.write(np.full((48, 64, 3), 200, np.uint8))
    video.release()
    (tmp_path / name).write_bytes(path.read_bytes())
    assert one(tmp_path / name).shape == (48, 64)


@pytest.mark.parametrize("extension", ["bmp", "tif", "webp", "ppm", "jp2"])
def test_an_image_of_another_kind_is_called_by_its_name(tmp_path, extension):
    path = tmp_path / ("a." + extension)
    Image.fromarray(FRAME).convert("RGB").save(path)
    kind = {"tif": "TIFF", "webp": "WebP", "ppm": "PBM or PPM", "jp2": "JPEG 2000"}.get(extension, "BMP")
    with pytest.raises(UserError, match="a %s image: convert it to PNG, JPEG or PGM" % kind):
        one(path)


def test_a_pgm_with_line_ends_of_windows_is_read(tmp_path):
    for last in (10, 13, 32, 255):  # which are blanks in a text
        frame = FRAME.copy()
        frame[0, 0] = frame[-1, -1] = last
        head = "P5\r\n%d %d\r\n255\r\n" % FRAME.shape[::-1]
        (tmp_path / "a.pgm").write_bytes(head.encode() + frame.tobytes())
        assert (one(tmp_path / "a.pgm") == frame).all()
        (tmp_path / "a.pgm").write_bytes(head[:-1].encode() + frame.tobytes())
        assert (one(tmp_path / "a.pgm") == frame).all()


def test_a_picture_of_which_nothing_is_visible_is_refused(tmp_path):
    picture = Image.fromarray(np.dstack([FRAME] * 3 + [np.zeros_like(FRAME)]))
    picture.save(tmp_path / "a.png")
    with pytest.raises(UserError, match="all of it is transparent"):
        one(tmp_path / "a.png")
