"""What a map makes of the way between markers: legs, their noise, slips, and standard errors."""

import math

import numpy as np
import pytest

from larics_host.mapping import build, settle, slips
from larics_host.mapping.graph import Graph, _leg_error, _reading_error
from larics_host.mapping.poses import after, inverse
from larics_host.mapping.wheels import _VIEW_SIGMA, View, Way
from tests.host.surveys import built_from, solved
from tools import simulated_drives
from tools.simulated_drives import World
from tools.survey_drives import taped


def test_slopes_of_the_factors():
    """Against differences, in the axes in which GTSAM moves a pose."""
    rng = np.random.default_rng(3)
    for error in (
        lambda a, b, z: (_leg_error(a, b, z)[0], np.hstack(_leg_error(a, b, z)[1:])),
        _reading_error,
    ):
        a, b, z = rng.normal(0, 1, (3, 3))
        off, slope = error(a, b, z)
        for k in range(6):
            step = np.zeros(6)
            step[k] = 1e-6
            moved = error(after(a, step[:3]), after(b, step[3:]), z)[0]
            assert (moved - off) / 1e-6 == pytest.approx(slope[:, k], abs=1e-4)


def test_legs_carry_shares_and_noise():
    """A way simulated step by step with known shares and noise, against what its legs say."""
    rng = np.random.default_rng(8)
    steps, track, noise = 400, 300.0, 0.004
    ahead, turn = np.full(steps, 10.0), np.where(np.arange(steps) % 100 < 20, 0.05, 0.0)
    shares = 0.01, 2e-5, -0.02, 0.0, 0.0, 0.0

    def poses(left, right):
        moved, turned = (left + right) / 2, (right - left) / track
        heading = np.concatenate([[0.0], np.cumsum(turned)])
        middle = heading[:-1] + turned / 2
        x, y = (np.concatenate([[0.0], np.cumsum(moved * f(middle))]) for f in (np.cos, np.sin))
        return np.column_stack([x, y, heading])

    wheels = ahead - turn * track / 2, ahead + turn * track / 2
    told = poses(*wheels)
    way = Way(*told.T, track)
    leg = way.legs(np.array([0, steps]), np.zeros(6))[0]
    true_turn = (1 + shares[2]) * turn + shares[1] * ahead
    true = poses(
        (1 + shares[0]) * ahead - true_turn * track / 2, (1 + shares[0]) * ahead + true_turn * track / 2
    )
    assert leg.pose == pytest.approx(told[-1], abs=1e-6)
    assert way.poses(shares)[-1] == pytest.approx(true[-1], abs=1e-6)
    assert leg.carried(np.array(shares)) == pytest.approx(true[-1], rel=0.02, abs=15)
    ends = []
    for _ in range(3000):
        noisy = [wheel + rng.normal(0, 1, steps) * math.sqrt(noise * 10) for wheel in wheels]
        ends.append(poses(*noisy)[-1])
    spread = np.cov(np.array(ends).T)
    assert np.sqrt(np.diag(noise * leg.by_noise)) == pytest.approx(np.sqrt(np.diag(spread)), rel=0.12)


def test_legs_take_what_markers_tell_at_both_ends():
    """Of a way that odometry has wrong there: pose, shares and noise are of what is in between."""
    steps, seen = 300, (70, 220)
    x, heading = np.arange(steps + 1) * 10.0, np.zeros(steps + 1)
    way = Way(x, np.zeros(steps + 1), heading)
    slipped = np.where(np.arange(steps + 1) > 30, 0.05, 0.0) - np.where(np.arange(steps + 1) > 250, 0.09, 0.0)
    lost = Way(x, x * np.sin(slipped), slipped)
    out, into = View(seen[0], (690.0, 8.0, 0.3)), View(seen[1], (-780.0, -20.0, -0.2))
    shares = np.array([0.01, 2e-5, -0.02, 3.0, -2.0, 0.002])

    def legs(one, *views):
        return one.legs(np.array([0, steps]), shares, *([view] for view in views))[0]

    leg = legs(way, out, into)
    middle = way.legs(np.array(seen), shares)[0]
    ends = after(out.pose, middle.pose), inverse(into.pose)
    assert leg.pose == pytest.approx(after(*ends)) and leg.way_mm == 1500.0
    moved = 1.1 * shares
    carried = after(after(out.pose, middle.carried(moved)), ends[1])
    assert leg.carried(moved) == pytest.approx(carried, abs=0.02)
    rng, told = np.random.default_rng(9), []
    for _ in range(4000):
        off, *seen_off = rng.normal(0, 1, (3, 3))
        mid = middle.pose + np.linalg.cholesky(middle.covariance(0.002)) @ off
        begin, end = (
            after(view, one * _VIEW_SIGMA) for view, one in zip((out.pose, into.pose), seen_off, strict=True)
        )
        told.append(after(after(begin, mid), inverse(end)))
    spread = np.cov(np.array(told).T)
    sigmas = np.sqrt(np.diag(spread))
    assert (leg.covariance(0.002) - spread) / np.outer(sigmas, sigmas) == pytest.approx(0, abs=0.08)
    assert legs(lost, out, into).pose[2] == pytest.approx(leg.pose[2], abs=1e-4)
    whole = way.legs(np.array([0, steps]), shares)[0]
    for views in ((), (None, None), (into, out)):  # both in view at once: odometry alone
        assert legs(way, *views).pose == pytest.approx(whole.pose)
        assert legs(way, *views).covariance(0.002) == pytest.approx(whole.covariance(0.002))


def test_covariances_are_those_of_gtsam(tmp_path, monkeypatch):
    import gtsam

    _, _, graph = solved(tmp_path, monkeypatch, World(markers=6, length_m=50.0, moved=False), 5008)
    told, own = gtsam.Marginals(graph._factors(False), graph._values()), graph.marginals()

    def same(keys, covariance):
        joint = told.jointMarginalCovariance([gtsam.symbol(*key) for key in keys])
        blocks = [[joint.at(gtsam.symbol(*a), gtsam.symbol(*b)) for b in keys] for a in keys]
        sigmas = np.sqrt(np.diag(np.block(blocks)))
        return (np.block(blocks) - covariance) / np.outer(sigmas, sigmas) == pytest.approx(0, abs=1e-3)

    for log, a, b, _ in graph.legs:
        assert same([("x", a), ("x", b), ("s", log)], own.leg(a, b, log))
    for one in graph.readings:
        assert same([("x", one.passage), ("m", one.place)], own.reading(one.passage, one.place))
    numbers = [number for number in graph.places if number != graph.anchor]
    assert same([("m", number) for number in numbers], own.places(numbers))


def _slipping_drive(tmp_path, monkeypatch, at):
    """(indices of passages, the Graph) of a drive on which a wheel slips far in a step."""
    step, ways = simulated_drives._Wheels.step, []

    def slipping(self, ahead, turn):
        step(self, ahead, turn)
        ways.append(self.driven)
        if len(ways) == at:
            moved, turned = 9.0, 18.0 / simulated_drives.TRACK_MM
            simulated_drives._move(self.odometry, moved, turned)
            self.way, self.turn = self.way + moved, self.turn + turned

    monkeypatch.setattr(simulated_drives._Wheels, "step", slipping)
    world = World(markers=9, length_m=100.0, moved=False, slips=0.0, wrong=0.0)
    _, collected, graph = solved(tmp_path, monkeypatch, world, 5009)
    return collected.drives[0].passages, graph


def test_a_slip_is_found_on_its_leg(tmp_path, monkeypatch):
    """Of one wheel, large: it is not taken for noise, nor for misread markers."""
    passages, graph = _slipping_drive(tmp_path, monkeypatch, 1450)
    leg = int(np.searchsorted([passage.frame for passage in passages], 1449)) - 1
    assert passages[leg].leaving.frame < 1449 < passages[leg + 1].frame
    assert graph.slipped[leg] > 0.9 and sum(graph.slipped.values()) < 2
    assert graph.leg_noise(leg) > 10 * graph.noise and graph.noise < 0.0012 < graph.loudness()
    assert all(reading.used for reading in graph.readings)


def test_a_slip_below_a_marker_does_no_harm(tmp_path, monkeypatch):
    """The marker tells how the vehicle went."""
    passages, graph = _slipping_drive(tmp_path, monkeypatch, 1880)
    (passage,) = (one for one in passages if one.entry and one.entry.frame < 1879 < one.leaving.frame)
    sides = [index for index, one in enumerate(passages) if one is passage]
    assert graph.slipped[sides[0] - 1] < 0.1 and graph.slipped[sides[0]] < 0.1
    assert sum(graph.slipped.values()) < 0.5 and graph.loudness() < 0.0012


def test_legs_that_explain_the_same_come_to_rest(tmp_path, monkeypatch):
    """Beside a marker that was moved, slips on several legs are as likely as each other."""
    world, rests = World(slips=0.1, length_m=200.0), []
    weigh = settle.weigh

    def weighed(graph, marginals):
        rests.append(weigh(graph, marginals))
        return rests[-1]

    monkeypatch.setattr(settle, "weigh", weighed)
    one, result = built_from(tmp_path, world, 700)
    assert not rests[-1].changed and len(rests) < 60
    assert result.errors.max() < 30 and result.moved == [one.hall[one.moved][0]]


def test_a_legs_likelihood_is_of_what_all_others_say_of_it():
    """However large its own covariance was in the solution."""
    rest, within, other = (np.diag(sigmas) ** 2 for sigmas in ((9, 5, 0.02), (4, 8, 0.01), (1, 3, 0.004)))
    rest[0, 1] = rest[1, 0] = 20.0
    off = np.array([12.0, -7.0, 0.03])
    left = np.linalg.inv(np.linalg.inv(rest) + np.linalg.inv(within))
    alone = slips._alone(within @ np.linalg.solve(rest + within, off), within, left)
    scores = []
    for own in (within, other):
        told = alone.under(own)
        settled = own @ np.linalg.solve(rest + own, off)
        left = np.linalg.inv(np.linalg.inv(rest) + np.linalg.inv(own))
        assert told.squares == pytest.approx(settled @ np.linalg.solve(own, settled))
        assert told.freedom == pytest.approx(3 - np.trace(np.linalg.solve(own, left)))
        square, size = off @ np.linalg.solve(rest + own, off), np.linalg.slogdet(rest + own)[1]
        scores.append((told.score, -0.5 * (square + size)))
    assert scores[0][0] - scores[1][0] == pytest.approx(scores[0][1] - scores[1][1])


def test_standard_errors_count_the_slips_that_may_have_been(tmp_path, monkeypatch):
    world = World(markers=9, length_m=60.0, moved=False, wrong=0.0)
    one, collected, graph = solved(tmp_path, monkeypatch, world, 5010)
    assert all(graph.expected[a] > graph.leg_noise(a) for _, a, _, _ in graph.legs)
    built = build.build(collected, build.Request(distances=[taped(one, np.random.default_rng(5010))]))
    numbers = list(built.poses)
    covariance = build._free(
        graph.place_covariance(graph.marginals(), numbers), [graph.places[k] for k in numbers]
    )
    sure = np.sqrt(np.diag(covariance).reshape(-1, 3)[:, :2].max(axis=1))
    told = np.array([built.sigmas(number).place_mm for number in numbers])
    assert built.is_scaled and not build.build(collected, build.Request()).is_scaled
    assert (told > 1.005 * sure).all() and (told < 3 * sure).all()


def test_readings_tell_how_noisy_they_are(tmp_path, monkeypatch):
    """With a lens that was never calibrated, as with a good one."""
    world = World(markers=9, length_m=100.0, moved=False, slips=0.0, wrong=0.0)
    _, _, graph = solved(tmp_path, monkeypatch, world, 5009)
    assert 0.3 <= graph.read_noise < 0.8 and graph.noise < 0.0008
    read, rng = simulated_drives._Camera.read, np.random.default_rng(4)
    offs = []

    def noisy(self, frame, pose, hall):
        seen = read(self, frame, pose, hall)
        if seen and (not offs or frame > offs[-1][0] + 10):
            offs.append((frame, rng.normal(0, (5, 5, 0.4))))
        elif seen:
            offs[-1] = (frame, offs[-1][1])
        return [(one, *(np.array(values) + offs[-1][1])) for one, *values in seen]

    monkeypatch.setattr(simulated_drives._Camera, "read", noisy)
    _, _, graph = solved(tmp_path, monkeypatch, world, 5009)
    assert 3 < graph.read_noise < 15 and graph.noise < 0.003


def test_the_noise_of_few_legs_is_not_much_less_than_expected():
    graph = Graph(noise=0.0004, legs=[(0, k, k + 1, None) for k in range(20)])
    for freedom, least, most in ((12.0, 5e-4, 7e-4), (1200.0, 2.0e-4, 2.2e-4)):
        graph.noise = 0.0004
        settle._heed_noise(graph, slips.Weighed(False, 0.5 * freedom, freedom), (0.0, 0.0))
        assert least < graph.noise < most
