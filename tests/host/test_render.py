"""What the renderer promises beyond its geometry: presets, overrides, noise, sameness."""

import subprocess
import sys
import threading
import zlib

import numpy as np
import pytest

from larics.marker import LARICS3
from larics_host.render import PRESETS, render_frame
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.drive import draw_drive
from larics_host.render.optics import motion_kernel, pixel_samples
from larics_host.render.plates import Plate, tag_cells, tag_side_mm
from larics_host.render.scene import Scene, Surface
from larics_host.render.sensor import Sensor
from larics_host.render.series import draw_view, generator
from larics_host.render.view import render_radiance, truth_of

SMALL = {"width": 160, "height": 120, "radius_px": 15}
PLAIN = Surface(reflectance=0.6, speckle=0.0, stain=0.0)


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_gives_frames_with_truth(preset):
    frame, truths = render_frame(preset, 3, 4)
    assert frame.shape == (296, 360) and frame.dtype == np.uint8
    ids = [truth.id for truth in truths]
    if preset == "negative":
        assert ids == [None]
        assert truths[0].x_px is None and truths[0].vehicle_x_mm is not None
    else:
        assert all(1 <= marker_id <= 7 for marker_id in ids)
        assert preset != "multi" or 2 <= len(ids) <= 4
        assert all(27 < truth.radius_px < 33 for truth in truths)
    assert {truth.frame for truth in truths} == {"frame_000004.pgm"}


@pytest.mark.parametrize("size", [(80, 60, 10), (80, 60, 30), (640, 480, 60), (360, 296, 5)])
def test_frame_sizes_and_radii(size):
    width, height, radius_px = size
    frame, truths = render_frame("sunny", 1, 0, width=width, height=height, radius_px=radius_px)
    assert frame.shape == (height, width)
    assert truths[0].radius_px == pytest.approx(radius_px, rel=0.12)
    assert truths[0].visible > 0.9 or 2 * radius_px >= height


def test_border_cuts_plates_and_inside_does_not():
    reach = 1.0 + LARICS3.plate_mm10 / LARICS3.outer_mm10 - 1.0
    cut = whole = 0
    for index in range(40):
        for preset in ("border", "sunny"):
            view = draw_view(preset, 2, index)
            (truth,) = truth_of(view.scene, view.pose, view.motion, view.camera)
            edge = min(truth.x_px, truth.y_px, 359 - truth.x_px, 295 - truth.y_px)
            if preset == "border":
                cut += edge < reach * truth.radius_px
            else:
                whole += edge > reach * truth.radius_px
    assert cut >= 38 and whole >= 38


def test_every_id_and_line_width_occurs():
    plates = [draw_view("sunny", 9, index).scene.plates[0] for index in range(60)]
    assert {plate.marker_id for plate in plates} == set(range(1, 8))
    widths = [plate.family.line_mm10 for plate in plates]
    assert 150 <= min(widths) < 160 and 190 < max(widths) <= 200


def test_the_same_arguments_give_the_same_bytes_in_any_order_thread_and_process():
    def digest(preset, index):
        frame, truths = render_frame(preset, 11, index, **SMALL)
        return zlib.crc32(frame.tobytes() + repr(truths).encode())

    tasks = [("harsh", 0), ("sunny", 3), ("cloudy", 5)]
    first = [digest(*task) for task in tasks]
    assert [digest(*task) for task in reversed(tasks)] == first[::-1]
    found = {}
    threads = [
        threading.Thread(target=lambda task=task: found.update({task: digest(*task)})) for task in tasks
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [found[task] for task in tasks] == first
    script = (
        "import zlib; from larics_host.render import render_frame\n"
        "f, t = render_frame('harsh', 11, 0, width=160, height=120, radius_px=15)\n"
        "print(zlib.crc32(f.tobytes() + repr(t).encode()))"
    )
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert int(output) == first[0]


def test_seeds_and_indices_differ():
    frames = [render_frame("sunny", seed, index, **SMALL)[0] for seed in (1, 2) for index in (0, 1)]
    for i, frame in enumerate(frames):
        assert not any(np.array_equal(frame, other) for other in frames[:i])


@pytest.mark.parametrize("target", ["aruco", "apriltag"])
def test_tags_hang_in_the_same_scene(target):
    options = {"jpeg": 0, "marker_ids": [3]}
    marker, truths = render_frame("sunny", 4, 2, **options)
    tag, tag_truths = render_frame("sunny", 4, 2, target=target, **options)
    truth, tag_truth = truths[0], tag_truths[0]
    assert (truth.x_px, truth.y_px, truth.id) == (tag_truth.x_px, tag_truth.y_px, tag_truth.id)
    assert abs(truth.heading_deg - tag_truth.heading_deg) < 0.5
    y, x = np.mgrid[:296, :360]
    away = np.hypot(x - truth.x_px, y - truth.y_px) / truth.radius_px
    reach = LARICS3.plate_mm10 / LARICS3.outer_mm10
    # noise follows the light, so only the optics' blur can tell the pictures apart outside the plate
    assert np.array_equal(marker[away > 1.12 * reach], tag[away > 1.12 * reach])
    assert not np.array_equal(marker[away < reach], tag[away < reach])


@pytest.mark.parametrize(("target", "modules"), [("aruco", 6), ("apriltag", 8)])
def test_tags_fill_the_same_plate(target, modules):
    cells = tag_cells(target, 5)
    assert cells.shape == (modules, modules)
    border = np.concatenate([cells[0], cells[-1], cells[:, 0], cells[:, -1]])
    assert border.all() and not cells.all()
    quiet = tag_side_mm(target) * (modules + 2) / modules
    assert quiet / np.sqrt(2) == pytest.approx(LARICS3.plate_mm10 / 10)


def on_axis(marker_id=1, **plate):
    return Scene(surface=PLAIN, plates=(Plate(marker_id, Pose(0, 0, 90.0), **plate),))


def test_contrast_is_that_between_plate_and_ink():
    radiance = render_radiance(on_axis(), Pose(), Motion(), Camera(focal_px=1200.0))
    frame = Sensor(contrast=100, black=20).frame(radiance, generator("test", 1))
    assert frame[147, 179] == 120  # bare plate in the middle
    assert frame[147, 179 + 60] == 20  # in the outer ring
    rings = np.abs(np.hypot(*np.mgrid[-147:149, -179:181]) - 50) < 4
    assert frame[rings].max() < 125


def test_noise_has_the_stated_variance():
    flat = np.full((200, 200), 0.5, np.float32)
    for read_noise, shot_noise in ((2.0, 0.0), (0.0, 0.05), (1.5, 0.03)):
        sensor = Sensor(contrast=160, black=40, read_noise=read_noise, shot_noise=shot_noise)
        frame = sensor.frame(flat, generator("test", 2)).astype(float)
        expected = read_noise**2 + shot_noise * 120 + 1 / 12
        assert frame.mean() == pytest.approx(120, abs=0.1)
        assert frame.var() == pytest.approx(expected, rel=0.05)


def test_saturation_clips():
    lit = np.full((10, 10), 50.0, np.float32)
    assert (Sensor().frame(lit, generator("test", 3)) == 255).all()


def test_vignetting_darkens_the_corners():
    flat = np.ones((100, 120), np.float32)
    frame = Sensor(contrast=200, black=0, vignetting=0.4).frame(flat, generator("test", 4))
    assert frame[50, 60] == 200
    assert frame[0, 0] == frame[-1, -1] == 120


@pytest.mark.parametrize("blur_px", [2.0, 8.0, 15.0])
def test_motion_blur_is_as_long_as_asked(blur_px):
    """The edge of a plate that moves across it becomes a ramp of that length."""
    camera = Camera(focal_px=1200.0, exposure_us=10000.0)
    speed = blur_px / 0.4 / 0.01  # 0.4 px per mm
    image = render_radiance(on_axis(), Pose(), Motion(left_mm_s=speed), camera)
    edge = image[147, 67:92][::-1]  # plate 1.0 inside, ceiling 0.6 outside
    width = np.interp(-0.65, -edge, np.arange(edge.size)) - np.interp(-0.95, -edge, np.arange(edge.size))
    assert width == pytest.approx(0.75 * blur_px, abs=0.6)
    standing = render_radiance(on_axis(), Pose(), Motion(), camera)
    edge = standing[147, 67:92][::-1]
    assert np.interp(-0.65, -edge, np.arange(edge.size)) - np.interp(-0.95, -edge, np.arange(edge.size)) < 1.2


def test_overrides_rule():
    view = draw_view(
        "sunny", 1, 1, contrast=33.0, defocus_px=2.5, tilt_deg=30.0, line_mm=12.0, marker_ids=[4], lens=(0, 0)
    )
    (plate,) = view.scene.plates
    assert (view.sensor.contrast, view.sensor.defocus_px, view.camera.tilt_deg) == (33.0, 2.5, 30.0)
    assert (plate.marker_id, plate.family.line_mm10, view.camera.k1) == (4, 120, 0)
    assert draw_view("sunny", 1, 1, marker_ids=[]).scene.plates == ()
    assert draw_view("sunny", 1, 1, marker_ids=[0]).scene.plates[0].marker_id == 0
    quiet = draw_view("cloudy", 1, 1, noise=0.0, jpeg=0)
    assert quiet.sensor.read_noise == quiet.sensor.shot_noise == quiet.sensor.jpeg == 0
    blurred = draw_view("sunny", 1, 1, blur_px=10.0)
    speed = np.hypot(blurred.motion.forward_mm_s, blurred.motion.left_mm_s)
    per_mm = blurred.camera.focal_px / blurred.scene.ceiling_mm
    assert speed * blurred.camera.exposure_us * 1e-6 * per_mm == pytest.approx(10.0)


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_occlusion_hides_that_share_of_the_ring(share):
    options = {"noise": 0.0, "jpeg": 0, "lens": (0, 0), "tilt_deg": 0.0, "blur_px": 0.0}
    view = draw_view("sunny", 8, 0, occlusion=share, **options)
    bare = draw_view("sunny", 8, 0, **options)
    with_board, without = (
        render_radiance(v.scene, v.pose, v.motion, v.camera, v.sensor.defocus_px) for v in (view, bare)
    )
    (truth,) = truth_of(view.scene, view.pose, view.motion, view.camera)
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    x = np.rint(truth.x_px + truth.radius_px * np.cos(angle)).astype(int)
    y = np.rint(truth.y_px + truth.radius_px * np.sin(angle)).astype(int)
    hidden = np.abs(with_board[y, x] - without[y, x]) > 0.1
    assert hidden.mean() == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize(
    "arguments",
    [
        {"preset": "rainy"},
        {"target": "qr"},
        {"colour": 3},
        {"width": 0},
        {"radius_px": -1},
        {"radius_px": float("nan")},
    ],
)
def test_bad_arguments_are_refused(arguments):
    arguments = {"preset": "sunny", "seed": 1, "index": 0, **arguments}
    with pytest.raises(ValueError):
        render_frame(arguments.pop("preset"), arguments.pop("seed"), arguments.pop("index"), **arguments)


def test_samples_are_symmetric_and_spread():
    samples = pixel_samples(24, 0.01)
    assert np.abs(samples.mean(axis=0)).max() < 1e-12
    assert np.abs(samples[:, :2]).max() < 0.5 and np.abs(samples[:, 2]).max() < 0.005
    # every slot of the exposure is used once
    assert np.allclose(np.sort(samples[:, 2]), (np.arange(24) + 0.5) / 24 * 0.01 - 0.005)


def test_motion_kernel_is_a_centred_line():
    kernel = motion_kernel(6.0, -3.0)
    size = len(kernel) // 2
    y, x = np.mgrid[-size : size + 1, -size : size + 1]
    assert kernel.sum() == pytest.approx(1, abs=1e-5)
    assert abs((kernel * x).sum()) < 1e-5 and abs((kernel * y).sum()) < 1e-5
    assert (kernel * x * y).sum() < 0
    assert (kernel * (x * x + y * y)).sum() == pytest.approx(45 / 12, rel=0.2)


def test_a_drive_passes_its_markers_under_one_ceiling():
    drive = draw_drive(
        "sunny", 5, shape="curve", marker_ids=(3, 4, 7), rate_hz=5, width=180, height=148, radius_px=15
    )
    seen = []
    for index in range(0, drive.frames, 4):
        for truth in truth_of(
            drive.scene, drive.path.at(index * drive.speed_mm_s / 5)[0], Motion(), drive.camera
        ):
            if truth.id is not None and truth.id not in seen:
                seen.append(truth.id)
    assert seen == [3, 4, 7]
    # what does not move in the map moves as one in the picture: two frames match under the known shift
    quick = draw_drive("sunny", 5, marker_ids=(3,), speed_mm_s=100, rate_hz=1, spacing_mm=1500)
    first, second = (
        render_radiance(quick.scene, quick.path.at(100.0 * index)[0], Motion(), quick.camera)
        for index in (6, 7)
    )
    shift = 100 * quick.camera.focal_px / quick.scene.ceiling_mm
    down = int(round(shift))
    a, b = first[60:200, 60:300], second[60 + down : 200 + down, 60:300]
    assert np.corrcoef(a.ravel(), b.ravel())[0, 1] > 0.7
    # any order, the same bytes
    assert np.array_equal(drive.frame(7)[0], drive.frame(7)[0])
    assert drive.frame(0)[1][0].time_us < drive.frame(1)[1][0].time_us
