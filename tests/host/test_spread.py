"""Standard errors that take what one place says for one word, however often it is said."""

import numpy as np
import pytest

from larics_host.calibration import lens
from larics_host.calibration.camera_model import CameraModel
from larics_host.calibration.observe import Observations
from larics_host.calibration.spread import bounded, covariance, places_of


def test_places_are_told_apart_by_distance():
    points = np.array([[0, 0], [1, 1], [50, 0], [0.5, 0], [50, 3], [0, 50]])
    assert places_of(points, 5.0).tolist() == [0, 0, 1, 0, 1, 2]


def test_the_covariance_is_that_of_leaving_out_one_place_after_the_other():
    rng = np.random.default_rng(1)
    jacobian, true = rng.normal(size=(40, 3)) * [1, 100, 0.01], np.array([2.0, -1.0, 300.0])
    measured = jacobian @ true + rng.normal(size=40)
    places = np.repeat(np.arange(10), 4)
    best = np.linalg.lstsq(jacobian, measured, rcond=None)[0]
    without = [
        np.linalg.lstsq(jacobian[places != k], measured[places != k], rcond=None)[0] - best for k in range(10)
    ]
    expected = 0.9 * sum(np.outer(one, one) for one in without)
    assert np.allclose(covariance(jacobian, jacobian @ best - measured, places), expected, rtol=1e-6)


def test_what_one_place_alone_determines_is_not_determined():
    jacobian = np.array([[1.0, 0], [1, 0], [1, 0], [1, 1]])
    assert np.isinf(covariance(jacobian, np.ones(4), [0, 1, 2, 3])).all()
    assert np.isinf(covariance(jacobian[:3, :1], np.ones(3), [0, 0, 0])).all()


def test_far_residuals_count_as_the_loss_has_them():
    assert np.allclose(bounded(np.array([0.001, 1.0]), 0.1), [0.001, 0.1], atol=0.001)


def observations(rng, copies, noise_px, place_px):
    """(Observations of a known camera, the camera): each place seen `copies` times, with its own error."""
    model = CameraModel(360, 296, rng.uniform(500, 600), (179.5, 147.5), rng.uniform(-0.15, 0.05), 0.0)
    grid = [(x, y) for y in (60, 104, 148, 192, 236) for x in (60, 120, 180, 240, 300)]
    x, y = (np.repeat(np.array(grid, float)[:, k], copies) for k in (0, 1))
    radius = model.radius_px(x, y, 150 / 2750)
    radius = radius + np.repeat(rng.normal(0, place_px, len(grid)), copies) + rng.normal(0, noise_px, len(x))
    count = len(x)
    zeros = np.zeros(count)
    return Observations(360, 296, count, np.arange(count), zeros + 5, x, y, radius, zeros), model


@pytest.mark.parametrize("copies", [1, 10])
def test_stated_errors_hold_where_places_have_errors_of_their_own(copies, monkeypatch):
    monkeypatch.setattr(lens, "_COMMON_PX", 0.0)  # there is none here
    rng = np.random.default_rng(2)
    pulls = []
    for _ in range(25):
        seen, model = observations(rng, copies, 0.005, 0.02)
        found = lens.fit(seen, model, lens.LENS, 2750.0, 150.0)
        pulls += [
            (getattr(found.model, name) - getattr(model, name)) / found.sigmas[name] for name in lens.LENS
        ]
    assert 0.6 <= np.mean(np.abs(pulls) < 1) <= 0.8 and np.mean(np.abs(pulls) < 2) > 0.9
