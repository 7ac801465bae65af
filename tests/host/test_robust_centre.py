"""The centre from both rings at once: little moved by what disturbs a part of one; and its sigma is true."""

import numpy as np
import pytest

from larics.detect.detector import Detector
from larics.direct import robust_centre
from larics.direct.robust_centre import RobustCentre
from larics.kernels import layouts
from larics.marker import LARICS3
from larics.marker.detection import FLAG_BLUR_MODEL
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.painters import ROD
from larics_host.render.plates import Plate
from larics_host.render.presets import PRESETS
from larics_host.render.scene import Scene, Surface, item, table
from larics_host.render.sensor import Sensor
from larics_host.render.series import generator, render_frame
from larics_host.render.view import render_view

ANGLES = (np.arange(16) + 0.5) * np.pi / 8
RATIO = 683 / 1024


class Rings:
    """What RobustCentre takes of a RingFit, with residuals (px) made up."""

    def __init__(self, outer, inner, areas=None):
        self.fit = [0] * layouts.FIT_ITEMS
        self.fit[layouts.FIT_X_Q8], self.fit[layouts.FIT_Y_Q8] = 100 << 8, 80 << 8
        self.fit[layouts.FIT_AREA], self.fit[layouts.FIT_INNER_Q10] = 400, 683
        self.fit[layouts.FIT_BEYOND_Q8] = 333
        self.radius_q8 = 30 << 8
        areas = np.full((2, 16), 400) if areas is None else areas
        self.outer_means, self.inner_means = (
            np.concatenate([np.rint(np.array(r) * 1024).astype(np.int32) + 32768, a]).astype(np.int32)
            for r, a in zip((outer, inner), areas, strict=True)
        )
        self.fit = np.array(self.fit, np.int32)
        self.outer = self.inner = [layouts.BIAS] * 5 + [20, 16, 16, 400]


def rings_of(x, y, apart_x=0.0, radius=0.0, bulge=0.0):
    """Residuals of both rings for a shifted centre (of the mean of the rings') and a difference of theirs."""
    outer = radius + (x - apart_x / 2) * np.cos(ANGLES) + y * np.sin(ANGLES) + bulge * np.cos(2 * ANGLES)
    inner = RATIO * radius + (x + apart_x / 2) * np.cos(ANGLES) + y * np.sin(ANGLES)
    return outer, inner + RATIO * bulge * np.cos(2 * ANGLES)


def fitted(rings):
    robust = RobustCentre(np.zeros(layouts.ROBUST_ITEMS, np.int32))
    assert robust.fit(rings)
    return robust.x_q10 / 1024 - 100, robust.y_q10 / 1024 - 80, robust


def test_clean_rings_give_their_own_centre_and_perspective():
    x, y, robust = fitted(Rings(*rings_of(0.1, -0.06, 0.08, 0.05, 0.1)))
    # the true centre lies beyond the rings' mean by BEYOND of what they are apart
    assert x == pytest.approx(0.1 + 0.08 * 333 / 256, abs=0.004)
    assert y == pytest.approx(-0.06, abs=0.004)
    assert np.sqrt(robust.variance) / 1024 < 0.01


def noisy_rings(seed, noise, missing):
    """Rings that lack sectors, of 0..15 and 16..31 the inner one's, and whose residuals are noisy."""
    rings = np.array(rings_of(0.1, -0.06)) + np.random.default_rng(seed).normal(0, noise, (2, 16))
    made = Rings(*rings)
    for sector in missing:
        (made.outer_means if sector < 16 else made.inner_means)[sector % 16] = 0
    return made


def test_what_is_assumed_where_sectors_do_not_tell_it():
    """By default the rings are as far apart, and of such radii, as print and camera make them: values as of
    the limits in use, from which twice and half of either are at least three times as far away."""
    arc = [*range(9), *range(16, 25)]
    for made, expected in (
        (noisy_rings(2, 0.05, range(16, 27)), (134, -6)),  # halved and doubled: (107, -27), (165, 33)
        (noisy_rings(3, 0.2, arc), (-60, -101)),  # of the radii: (-75, -81), (-42, -159)
    ):
        x, y, _ = fitted(made)
        assert (round(x * 1024), round(y * 1024)) == pytest.approx(expected, abs=4)


def test_an_arc_alone_has_at_most_four_times_the_variance_that_it_leaves():
    arc = [*range(9), *range(16, 25)]
    for noise in (0.05, 0.2):
        robust = fitted(noisy_rings(3, noise, arc))[2]
        assert robust.variance == robust.square * 4095 >> 10


def test_a_centre_that_would_move_by_more_than_a_pixel_is_none():
    for x, apart, is_fitted in ((0.9, 0.1, True), (0.98, 0.1, False), (-0.98, -0.1, False)):
        for swap in (False, True):
            outer, inner = rings_of(x, 0, apart)
            if swap:  # x becomes y
                outer, inner = (np.roll(ring, 4) for ring in (outer, inner))
            robust = RobustCentre(np.zeros(layouts.ROBUST_ITEMS, np.int32))
            assert robust.fit(Rings(outer, inner)) == is_fitted, (x, apart, swap)


class Steps:
    """The kernels, with the steps of a fit counted."""

    def __init__(self):
        self.solved = 0

    def __getattr__(self, name):
        return getattr(robust_centre.kernels_before, name)

    def solve_step(self, *arguments):
        self.solved += 1
        return robust_centre.kernels_before.solve_step(*arguments)


def steps(monkeypatch, deviation, missing=0, noise=0.0):
    """How many steps a fit takes whose harmonics left this mean deviation, and lack so many sectors."""
    rings = np.array(rings_of(0.1, -0.06)) + np.random.default_rng(3).normal(0, noise, (2, 16))
    made = Rings(*rings)
    made.outer_means[:missing] = 0
    made.outer = made.inner = [layouts.BIAS] * 5 + [deviation, 16, 16, 400]
    monkeypatch.setattr(robust_centre, "kernels_before", robust_centre.kernels, raising=False)
    with monkeypatch.context() as patch:
        counted = Steps()
        patch.setattr(robust_centre, "kernels", counted)
        fitted(made)
    return counted.solved


def test_quiet_rings_take_few_steps(monkeypatch):
    assert steps(monkeypatch, 32) == 2  # 5/4 of the rings' mean
    assert steps(monkeypatch, 33) > 2
    assert steps(monkeypatch, 32, missing=4) == 2
    assert steps(monkeypatch, 32, missing=5) > 2
    # and others no more than it takes until a step is small
    assert steps(monkeypatch, 40) == 4
    assert steps(monkeypatch, 40, noise=0.2) == 5


@pytest.mark.parametrize(("sectors", "by", "most"), [(2, 0.6, 0.05), (3, -0.35, 0.08)])
def test_a_disturbed_stretch_of_one_ring_hardly_moves_the_centre(sectors, by, most):
    rng = np.random.default_rng(5)
    moved, plain = [], []
    for start in range(16):
        rings = np.array(rings_of(0.02, 0.01)) + rng.normal(0, 0.012, (2, 16))
        rings[start & 1, [(start + k) % 16 for k in range(sectors)]] += by
        x, y, _ = fitted(Rings(*rings))
        moved.append(np.hypot(x - 0.02, y - 0.01))
        # each ring for itself: the difference of the centres takes the disturbance up, times what lies beyond
        outer, inner = (
            np.array([np.mean(r * np.cos(ANGLES)), np.mean(r * np.sin(ANGLES))]) * 2 for r in rings
        )
        plain.append(np.hypot(*((outer + inner) / 2 - (outer - inner) * 333 / 256 - (0.02, 0.01))))
    assert np.median(moved) < most
    assert np.median(moved) < 0.5 * np.median(plain)


def test_faint_sectors_count_less():
    outer, inner = rings_of(0.0, 0.0)
    outer[3:7] += 0.15
    areas = np.full((2, 16), 400)
    strong = fitted(Rings(outer, inner, areas))[:2]
    areas[0, 3:7] = 60
    weak = fitted(Rings(outer, inner, areas))[:2]
    assert np.hypot(*weak) < 0.5 * np.hypot(*strong) + 0.002


def test_the_step_is_that_of_weighted_least_squares():
    rng = np.random.default_rng(1)
    one, none = np.ones(16), np.zeros(16)
    c, s, c2, s2 = np.cos(ANGLES), np.sin(ANGLES), np.cos(2 * ANGLES), np.sin(2 * ANGLES)
    design = np.vstack(
        [
            np.stack([one, none, c, s, -c, -s, c2, s2], 1),
            np.stack([RATIO * one, one, c, s, c, s, RATIO * c2, RATIO * s2], 1),
        ]
    )
    for _ in range(5):
        residuals = design @ rng.normal(0, 0.03, 8) + rng.normal(0, 0.01, 32)
        robust = fitted(Rings(residuals[:16], residuals[16:]))[2]
        work = robust.work
        weights = np.array(work[layouts.ROBUST_WEIGHTS : layouts.ROBUST_WEIGHTS + 32]) / 64
        normal = design.T @ (weights[:, None] * design)
        sure = 256 * weights.sum() / 32
        prior = np.array(work[layouts.ROBUST_MATRIX + 45]) - layouts.BIAS
        assert prior > sure / 2  # the matrix was factored in place
        free = np.linalg.solve(normal + np.diag([0, 0.2, 0, 0, 0, 0, 0, 0]), design.T @ (weights * residuals))
        found = (np.array(work[128:136]) - layouts.BIAS) / 16384
        # what the prior on the rings' difference leaves alone
        for index in (0, 6, 7):
            assert found[index] == pytest.approx(free[index], abs=0.004)


def test_too_few_sectors_determine_nothing():
    outer, inner = rings_of(0.0, 0.0)
    rings = Rings(outer, inner)
    rings.outer_means[:12] = 0
    rings.inner_means[:12] = 0
    robust = RobustCentre(np.zeros(layouts.ROBUST_ITEMS, np.int32))
    assert not robust.fit(rings)
    assert robust.variance == 25 * 25  # of the harmonics, then


def test_a_bright_cable_over_a_ring_moves_the_centre_by_little():
    worst, sigmas = 0.0, []
    camera = Camera(focal_px=600.0, row_us=0.0)
    detector = Detector(360, 296, 25, 35, family=LARICS3)
    for index in range(12):
        angle = index * np.pi / 6 + 0.2
        where = (120 * np.cos(angle), 120 * np.sin(angle))
        cable = item(ROD, *where, 4000, 4, angle=angle + np.pi / 2, value=1.5)
        scene = Scene(
            surface=Surface(0.6, 0.0, stain=0.0),
            plates=(Plate(5, Pose(0, 0, 20.0)),),
            occluders=table([cable]),
        )
        frame, (truth,) = render_view(
            scene,
            Pose(),
            Motion(),
            camera,
            Sensor(110, 30, 0.8, 0.008, defocus_px=0.5),
            generator("cable", index),
        )
        for found in detector.detect(frame):
            worst = max(worst, np.hypot(found.x_q8 / 256 - truth.x_px, found.y_q8 / 256 - truth.y_px))
            sigmas.append(found.sigma_q12)
    assert len(sigmas) >= 9
    assert worst < 0.1


@pytest.mark.parametrize("preset", ["sunny", "cloudy", "glossy"])
def test_errors_are_as_large_as_the_detections_say(preset):
    assert preset in PRESETS
    detector = Detector(360, 296, 25, 35, family=LARICS3)
    centre, heading, radius = [], [], []
    for index in range(60):
        frame, truths = render_frame(preset, 70, index)
        for found in detector.detect(frame):
            truth = truths[0]
            error = np.array([found.x_q8 / 256 - truth.x_px, found.y_q8 / 256 - truth.y_px])
            if np.hypot(*error) < 3 and found.sigma_q12 > 0:
                radius.append(found.radius_q8 / 256 - truth.radius_px)
                centre += list(np.abs(error) * 4096 / found.sigma_q12)
                turned = (found.heading_cdeg / 100 - truth.heading_deg + 180) % 360 - 180
                heading.append(abs(turned) * 1000 / found.sigma_mdeg)
    assert abs(np.median(radius)) < (0.008 if preset == "sunny" else 0.02)
    assert 0.55 < np.mean(np.array(centre) < 1) < 0.85 and np.mean(np.array(centre) < 2) > 0.87
    assert 0.45 < np.mean(np.array(heading) < 1) < 0.92 and np.mean(np.array(heading) < 2) > 0.75


@pytest.mark.parametrize("blurred", [{"blur_px": 10.0}, {"defocus_px": 3.5}])
def test_the_blur_model_reader_tells_its_sigma_too(blurred):
    detector = Detector(360, 296, 25, 35, family=LARICS3)
    centre, heading = [], []
    for index in range(20):
        frame, (truth,) = render_frame("sunny", 71, index, **blurred)
        for found in detector.detect(frame):
            error = np.array([found.x_q8 / 256 - truth.x_px, found.y_q8 / 256 - truth.y_px])
            if found.flags & FLAG_BLUR_MODEL and np.hypot(*error) < 3:
                centre += list(np.abs(error) * 4096 / found.sigma_q12)
                turned = (found.heading_cdeg / 100 - truth.heading_deg + 180) % 360 - 180
                heading.append(abs(turned) * 1000 / found.sigma_mdeg)
    assert len(heading) > 12
    assert 0.45 < np.mean(np.array(centre) < 1) < 0.9 and np.mean(np.array(centre) < 2) > 0.8
    assert 0.4 < np.mean(np.array(heading) < 1) < 0.95 and np.mean(np.array(heading) < 2) > 0.75
