"""Maps from one drive of a vehicle with odometry, under markers that are never seen together."""

import json
import math
import re
from collections import Counter

import cv2
import numpy as np
import pytest

from larics_host import cli
from larics_host.commands import map as map_command
from larics_host.mapping import build, contradicted, layout, moves, settle, slips
from larics_host.mapping.association import Found
from larics_host.mapping.collect import Collected, collect
from larics_host.mapping.graph import Graph, Link, Reading, _leg_error, _reading_error
from larics_host.mapping.links import Place
from larics_host.mapping.mapfile import read_map
from larics_host.mapping.poses import after, inverse
from larics_host.mapping.wheels import _VIEW_SIGMA, View, Way
from tools import survey_drives
from tools.survey_drives import World, drive, score, taped, write_log


def built_from(folder, world, seed, *options, distance=True):
    one = drive(world, seed)
    words = list(options)
    if distance:
        words += ["--distance", "%d,%d,%.1f" % taped(one, np.random.default_rng(seed))]
    return one, score(one, write_log(folder / "drive.bin", one), *words)


def test_a_hall_from_one_drive(tmp_path, capsys):
    """30 markers 3 m apart, 200 m with slips, misread passages and frames, one marker moved half way."""
    one, result = built_from(tmp_path, World(), 5003)
    assert not result.refused and len(result.errors) == len({h[0] for h in one.hall}) == 30
    assert np.median(result.errors) < 12 and result.errors.max() < 30
    assert result.within.mean() > 0.9
    assert result.moved == [one.hall[one.moved][0]]
    assert result.aside == len(one.misread) > 0


def test_repeated_ids_are_told_apart_along_the_drive(tmp_path):
    one, result = built_from(tmp_path, World(ids=7, moved=False), 5001, "--repeats", distance=False)
    assert not result.refused and len(result.errors) == 30
    assert np.median(result.errors) < 40 and result.within.mean() > 0.9


@pytest.mark.parametrize("ids", [0, 7])
def test_a_map_that_lost_its_association_is_refused(ids, tmp_path):
    world = World(ids=ids, carried_m=80.0)
    _, result = built_from(tmp_path, world, 5002, *(["--repeats"] if ids else []), distance=False)
    assert "not make one map" in result.refused and result.refused.count("\n") == 0
    assert not (tmp_path / "drive.map.json").exists()


def test_given_places_hold_the_map(tmp_path, capsys):
    one = drive(World(markers=9, length_m=70.0, moved=False), 5004)
    log = write_log(tmp_path / "drive.jsonl", one)
    known = [one.hall[0], one.hall[8]]
    words = [word for place in known for word in ("--place", "%d,%.1f,%.1f" % place[:3])]
    picture = tmp_path / "hall.png"
    build = ["map", "build", str(log), "-o"]
    assert cli.main([*build, str(tmp_path / "a.json"), *words, "--png", str(picture)]) == 0
    text = capsys.readouterr().out
    assert "passages" in text and re.search(r"odometry: scale [-+]0\.\d\d %, drift", text)
    assert cv2.imread(str(picture)) is not None
    for marker in read_map(tmp_path / "a.json").markers:
        place = next(one for one in one.hall if one[0] == marker.id)
        off = np.abs(np.subtract((marker.x_mm, marker.y_mm), place[1:3]))
        assert off.max() < 30 and off.max() < 4 * marker.sigma_mm and 0 < marker.sigma_deg < 1
    assert cli.main([*build, str(tmp_path / "b.json"), *words[:2]]) == 2
    assert "give one more" in capsys.readouterr().err


def test_what_is_given_is_judged_by_the_drives(tmp_path, capsys):
    """A digit too few, the wrong ID, a tape read wrong: told with what the drives say."""
    one = drive(World(markers=9, length_m=70.0, moved=False, wrong=0.0), 5011)
    log = write_log(tmp_path / "drive.bin", one)
    first, second, mm = taped(one, np.random.default_rng(5011))

    def told(*words):
        out = tmp_path / "a.json"
        out.unlink(missing_ok=True)
        code = cli.main(["map", "build", str(log), "-o", str(out), *words])
        text = capsys.readouterr()
        assert out.exists() == (code < 2) and "Traceback" not in text.err
        return code, text.out + text.err

    names = "markers %d and %d are" % (first, second)
    assert told("--distance", "%d,%d,%.1f" % (first, second, mm))[0] == 0
    code, text = told("--distance", "%d,%d,%.1f" % (first, second, mm / 10))
    assert code == 2 and names in text
    assert float(re.search(r"some (.*) m by the logs", text).group(1)) == pytest.approx(mm / 1000, rel=0.02)
    code, text = told("--distance", "%d,%d,%.1f" % (first, second, 1.08 * mm))
    assert code == 1 and "problem: " + names in text
    assert float(re.search(r"(\d+) mm by the logs", text).group(1)) == pytest.approx(mm, rel=0.02)
    known = [one.hall[k] for k in (0, 2, 6, 8)]
    words = [["--place", "%d,%.1f,%.1f" % place[:3]] for place in known]
    assert told(*sum(words, []))[0] == 0
    words[1] = ["--place", "%d,%.1f,%.1f" % (known[1][0], known[1][1] + 150, known[1][2])]
    code, text = told(*sum(words, []))
    assert code == 1 and "problem: marker %d is " % known[1][0] in text and "from the given place" in text
    words[1] = ["--place", "%d,%.1f,%.1f" % (known[1][0], known[1][1] + 9000, known[1][2])]
    code, text = told(*sum(words, []))
    assert code == 2 and " and %d are " % known[1][0] in text


def test_drives_that_are_no_map_are_not_blamed_on_a_distance(tmp_path):
    one = drive(World(carried_m=80.0), 5002)
    first, second, mm = taped(one, np.random.default_rng(5002))
    words = ["--distance", "%d,%d,%.1f" % (first, second, mm / 10)]
    assert "not make one map" in score(one, write_log(tmp_path / "drive.bin", one), *words).refused


def test_a_known_length_tells_a_misread_marker_from_the_right_one():
    def found(marker_id, x_mm, passages=1):
        return Found(marker_id, np.array([x_mm, 0.0, 0.0]), list(range(passages)), [])

    founds = [found(1, 0.0, 3), found(2, 14000.0), found(2, 3000.0), found(3, 500.0, 2), found(3, 3000.0)]
    assert layout._one_each(founds, []) == [founds[k] for k in (0, 1, 3)]
    assert layout._one_each(founds, [(1, 2, 3010.0), (1, 3, 3000.0)]) == [founds[k] for k in (0, 2, 3)]
    assert layout._one_each(founds, [(2, 1, 13000.0)]) == [founds[k] for k in (0, 1, 3)]


def test_two_logs_and_a_jump_of_the_odometry_make_one_map(tmp_path, capsys):
    """The second half of the drive has another odometry frame; then as a log of its own, with frame numbers
    that begin anew."""
    one = drive(World(markers=9, length_m=100.0, moved=False, wrong=0.0), 5006)
    half = len(one.frames) // 2
    frames = one.frames
    for k in range(half, len(frames)):
        number, pose, *rest = frames[k]
        frames[k] = (number, after((5000, -300, 2), pose), *rest)
    words = "--distance", "%d,%d,%.1f" % taped(one, np.random.default_rng(1))
    jumped = score(one, write_log(tmp_path / "jump.bin", one), *words)
    assert not jumped.refused and len(jumped.errors) == 9 and jumped.errors.max() < 25
    second = [(number - half, *rest) for number, *rest in frames[half:]]
    one.frames = frames[:half]
    write_log(tmp_path / "first.bin", one)
    one.frames = second
    write_log(tmp_path / "second.bin", one)
    out = tmp_path / "both.json"
    logs = [str(tmp_path / name) for name in ("first.bin", "second.bin")]
    assert cli.main(["map", "build", *logs, "-o", str(out)]) == 0, capsys.readouterr().out
    assert len(read_map(out).markers) == 9
    (tmp_path / "joined.bin").write_bytes(
        b"".join((tmp_path / n).read_bytes() for n in ("first.bin", "second.bin"))
    )
    assert cli.main(["map", "build", str(tmp_path / "joined.bin"), "-o", str(out), "--force"]) == 0
    assert len(read_map(out).markers) == 9


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


def test_what_no_map_can_be_built_from_is_said(tmp_path, capsys):
    one = drive(World(markers=6, length_m=20.0, moved=False, wrong=0.0, wrong_frames=0.0), 5007)
    log, out = str(write_log(tmp_path / "drive.jsonl", one)), str(tmp_path / "hall.json")
    only = one.hall[0][0]
    one.frames = [(*rest, [seen for seen in seens if seen[0] == only]) for *rest, seens in one.frames]
    single = str(write_log(tmp_path / "single.jsonl", one))
    one.frames = [(*rest, []) for *rest, _ in one.frames]
    nothing = str(write_log(tmp_path / "nothing.jsonl", one))
    for words, said in (
        ((nothing,), "no marker was read in these logs: a map needs two or more"),
        ((single,), "marker %d is the only one that was read: a map needs two or more" % only),
        ((log, str(tmp_path / "." / "drive.jsonl")), "drive.jsonl is given twice"),
        ((log, "--anchor", "3,0"), "--anchor 3,0: give ID,X,Y,DEG, such as 3,0,0,90"),
        ((log, "--anchor", "3.5,0,0,0"), "--anchor 3.5,0,0,0: 3.5 is no ID"),
        ((log, "--place", "3,inf,0"), "--place 3,inf,0: give ID,X,Y or ID,X,Y,DEG"),
        ((log, "--distance", "3,17"), "--distance 3,17: give ID,ID,MM"),
        ((log, "--distance", "3,3,90"), "--distance 3,3,90: two markers"),
    ):
        assert cli.main(["map", "build", *words, "-o", out]) == 2
        assert said in capsys.readouterr().err


def test_what_goes_before_a_slip_at_the_end_of_a_drive_is_no_move():
    """A single reading, and nothing behind it: one slip may have done it. Else two had to."""
    way = Way(np.arange(0, 9001.0, 10), np.zeros(901), np.zeros(901))
    graph = Graph(
        noise=0.0005, places={0: (6000.0, 100.0, 0.0), 1: (3000.0, 0.0, 0.0), 2: (9000.0, 0.0, 0.0)}
    )
    graph.poses = {k: (3000.0 * k, 0.0, 0.0) for k in range(4)}
    graph.legs = [(0, k, k + 1, leg) for k, leg in enumerate(way.legs(np.arange(0, 901, 300), np.zeros(6)))]
    graph.readings = [Reading(k, place, (0.0, 0.0, 0.0)) for k, place in ((1, 1), (3, 2))]
    one = Reading(2, 0, (0.0, -150.0, 0.0))
    assert moves._surely(graph, one, graph.places[0], 250.0)
    less = Reading(2, 0, (0.0, -60.0, 0.0))  # two slips would explain it, but that they cancelled each other
    assert moves._surely(graph, less, graph.places[0], 160.0)
    graph.slipped[2] = 0.5
    assert not moves._surely(graph, less, graph.places[0], 160.0)
    assert moves._surely(graph, one, graph.places[0], 250.0)
    graph.legs.pop()
    assert not moves._surely(graph, one, graph.places[0], 250.0)


def test_a_marker_that_was_moved_may_be_misread_after_that(tmp_path):
    one, result = built_from(tmp_path, World(), 17703)
    assert result.moved == [one.hall[one.moved][0]] and result.errors.max() < 20


@pytest.mark.parametrize(
    ("x_mm", "used", "other_mm", "may_be"),
    [
        (300.0, False, 6000.0, True),
        (100.0, False, 6000.0, False),  # its place, misread
        (800.0, False, 6000.0, False),
        (300.0, True, 6000.0, False),
        (300.0, False, 1700.0, False),  # the marker that was read is near enough
    ],
)
def test_what_another_id_may_tell_of_a_move(x_mm, used, other_mm, may_be):
    graph = Graph(poses={0: (0.0, 0.0, 0.0)}, places={0: (0.0, 0.0, 0.0), 1: (other_mm, 0.0, 0.0)})
    one = Reading(0, 1, (x_mm, 0.0, 0.0), used)
    assert moves._may_be_of(graph, one, 0) is may_be
    graph.places[2] = (x_mm, 250.0, 0.0)  # hangs there
    assert not moves._may_be_of(graph, one, 0)


def _solved(tmp_path, monkeypatch, world, seed):
    """(Drive, Collected, the Graph of its map)."""
    kept = []
    monkeypatch.setattr(build, "find_moves", lambda graph, places: kept.append(graph) or [])
    one = drive(world, seed)
    collected = collect([write_log(tmp_path / "drive.bin", one)], False)
    first, second, mm = taped(one, np.random.default_rng(seed))
    build.build(collected, build.Request(distances=[(first, second, mm)]))
    return one, collected, kept[0]


def test_covariances_are_those_of_gtsam(tmp_path, monkeypatch):
    import gtsam

    _, _, graph = _solved(tmp_path, monkeypatch, World(markers=6, length_m=50.0, moved=False), 5008)
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
    step, ways = survey_drives._Wheels.step, []

    def slipping(self, ahead, turn):
        step(self, ahead, turn)
        ways.append(self.driven)
        if len(ways) == at:
            moved, turned = 9.0, 18.0 / survey_drives.TRACK_MM
            survey_drives._move(self.odometry, moved, turned)
            self.way, self.turn = self.way + moved, self.turn + turned

    monkeypatch.setattr(survey_drives._Wheels, "step", slipping)
    world = World(markers=9, length_m=100.0, moved=False, slips=0.0, wrong=0.0)
    _, collected, graph = _solved(tmp_path, monkeypatch, world, 5009)
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
    one, collected, graph = _solved(tmp_path, monkeypatch, world, 5010)
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


@pytest.mark.parametrize(
    "sigmas_mm, is_scaled, said",
    [
        ((4, 5, 38.2, 6, 21), True, "drive by once more: marker 102 (+- 38 mm), 104 (+- 21 mm)\n"),
        ((4, 5, 38.2, 6, 21), False, ""),
        ((4, 5, 14, 6, 5), True, ""),  # good enough
        ((14, 15, 24, 16, 15), True, ""),  # no better than the others
    ],
)
def test_markers_that_are_known_badly_are_told(sigmas_mm, is_scaled, said, tmp_path, capsys):
    built = build.Built({}, {}, {}, [], is_scaled=is_scaled)
    for number, sigma in enumerate(sigmas_mm):
        built.places[number] = Place(number)
        built.places[number].votes[100 + number] += 1
        built.poses[number] = (0.0, 0.0, 0.0)
        built.covariances[number] = np.diag([sigma**2, 1.0, 1e-6])
    map_command._tell_build(Collected([], {}, 0), built)
    text = capsys.readouterr().out
    assert ("drive by once more" in text) == bool(said) and said in text


def test_the_map_file_has_the_standard_errors(tmp_path):
    one = drive(World(markers=6, length_m=60.0, moved=False, wrong=0.0), 5007)
    result = score(one, write_log(tmp_path / "drive.bin", one))
    assert not result.refused
    data = json.loads((tmp_path / "drive.map.json").read_text())
    assert all(0 < marker["sigma_mm"] < 200 and 0 < marker["sigma_deg"] < 2 for marker in data["markers"])


def _read(passage, used, x_mm=0.0):
    return Reading(passage, 0, (x_mm, 0.0, 0.0), used)


def test_a_split_may_leave_out_one_reading_of_four():
    graph = Graph(poses={k: (0.0, 0.0, 0.0) for k in range(4)}, places={0: (0.0, 0.0, 0.0)})
    readings = [_read(0, False, 60.0), _read(1, True), _read(2, False, 300.0), _read(3, False, 300.0)]
    assert moves._split(graph, readings) == ([readings[1]], readings[2:])
    assert moves._split(graph, [_read(0, False, 60.0), _read(1, True), _read(2, False, 300.0)]) is None
    graph.poses[4] = (0.0, 0.0, 0.0)
    assert moves._split(graph, [_read(k, k % 2 == 1, 300.0) for k in range(5)]) is None


def test_what_is_taken_back_stays_until_slips_were_sought():
    """The slip that explains a reading is found only with it; it is surprising until then."""
    graph = Graph(poses={k: (0.0, 0.0, 0.0) for k in range(4)}, places={0: (0.0, 0.0, 0.0)})
    graph.readings = [_read(0, True), _read(1, True), _read(2, True), _read(3, False, 80.0)]
    flips, returned = Counter(), set()
    for square, used in ((70.0, True), (2400.0, True), (2400.0, False), (7.0, True), (3.0, True)):
        surprises = np.array([1.0, 1.0, 1.0, square])
        changed = settle._set_aside(graph, surprises, flips, returned, 1000.0, 150.0)
        assert changed == (square != 3.0) and [one.used for one in graph.readings] == [True] * 3 + [used]


@pytest.mark.parametrize(
    "used, x_mm, share, words",
    [
        ((True, False), 9000.0, 0.5, "9.0 m apart, and the map has the first"),
        ((False, True), 9000.0, 0.5, "9.0 m apart, and the map has the last"),
        ((True, True, False), 9000.0, None, ""),  # one of another marker
        ((True, False), 1200.0, 0.5, "1.2 m apart, and the map has the first"),  # it may have been moved
        ((True, True, False), 1200.0, 0.5, "has the first"),
        ((True, True, False, True), 1200.0, 0.25, "has the first"),
        ((False, True), 1200.0, 0.0, "has the last"),  # where it is now
        ((True, False), 60.0, None, ""),
        ((True, False), 5600.0, None, ""),  # where marker 6 is, which was misread
        ((True, False), 5900.0, 1.0, "marker 6 may have been moved: another ID was read 0.4 m"),
        ((True, True), 1200.0, None, ""),
    ],
)
def test_an_id_that_was_read_at_two_places_is_told(used, x_mm, share, words):
    graph = Graph(
        poses={k: (0.0, 0.0, 0.0) for k in range(4)}, places={0: (0.0, 0.0, 0.0), 1: (5500.0, 0, 0)}
    )
    graph.readings = [_read(k, one, 0.0 if one else x_mm) for k, one in enumerate(used)]
    places = {number: Place(number) for number in graph.places}
    for number, place in places.items():
        place.votes[5 + number] += 1
    doubts = contradicted.of_two_places(graph)
    assert [one.share for one in doubts] == ([] if share is None else [share])
    (line,) = contradicted.told(doubts, graph, places) or [""]
    assert words in line and ("marker 5" in line or x_mm == 5900.0 or not words)
    covariance = np.eye(6)
    build._add_doubts(covariance, doubts, graph, [1, 0])
    own = 0 if x_mm == 5900.0 else 3
    off = 400.0 if x_mm == 5900.0 else x_mm
    assert covariance[own, own] == pytest.approx(1 + min(900.0, off * math.sqrt(share or 0)) ** 2)
    assert np.delete(np.diag(covariance), own) == pytest.approx(1)


def test_a_marker_that_was_moved_or_not_is_told_with_its_sigma(tmp_path, capsys, monkeypatch):
    """Where nothing tells of a move, its place in the map may be the one before."""
    monkeypatch.setattr(build, "find_moves", lambda graph, places: [])
    one, result = built_from(tmp_path, World(markers=9, length_m=100.0, wrong=0.0), 5016)
    assert not result.moved
    doubted = [marker for marker in read_map(tmp_path / "drive.map.json").markers if marker.sigma_mm > 50]
    assert [marker.id for marker in doubted] == [one.hall[one.moved][0]]


def test_readings_tell_how_noisy_they_are(tmp_path, monkeypatch):
    """With a lens that was never calibrated, as with a good one."""
    world = World(markers=9, length_m=100.0, moved=False, slips=0.0, wrong=0.0)
    _, _, graph = _solved(tmp_path, monkeypatch, world, 5009)
    assert 0.3 <= graph.read_noise < 0.8 and graph.noise < 0.0008
    read, rng = survey_drives._Camera.read, np.random.default_rng(4)
    offs = []

    def noisy(self, frame, pose, hall):
        seen = read(self, frame, pose, hall)
        if seen and (not offs or frame > offs[-1][0] + 10):
            offs.append((frame, rng.normal(0, (5, 5, 0.4))))
        elif seen:
            offs[-1] = (frame, offs[-1][1])
        return [(one, *(np.array(values) + offs[-1][1])) for one, *values in seen]

    monkeypatch.setattr(survey_drives._Camera, "read", noisy)
    _, _, graph = _solved(tmp_path, monkeypatch, world, 5009)
    assert 3 < graph.read_noise < 15 and graph.noise < 0.003


def test_places_that_coincide_contradict_a_distance():
    """And divide nothing by nothing."""
    graph = Graph(places={0: (0.0, 0.0, 0.0), 1: (0.0, 0.0, 0.3)}, anchor=0)
    graph.links = [Link(0, 1, (0.0, 0.0, 0.3)) for _ in range(3)]
    graph.distances = [(0, 1, 700.0)]
    places = {number: Place(number) for number in graph.places}
    for number, place in places.items():
        place.votes[5 + number] += 1
    line = contradicted.by_all_else(graph, graph.marginals(), places)
    assert re.match(r"markers 5 and 6 are 700 mm apart by what is given, \d+ mm by the logs", line)


def test_the_noise_of_few_legs_is_not_much_less_than_expected():
    graph = Graph(noise=0.0004, legs=[(0, k, k + 1, None) for k in range(20)])
    for freedom, least, most in ((12.0, 5e-4, 7e-4), (1200.0, 2.0e-4, 2.2e-4)):
        graph.noise = 0.0004
        settle._heed_noise(graph, slips.Weighed(False, 0.5 * freedom, freedom), (0.0, 0.0))
        assert least < graph.noise < most


def test_a_neighbour_may_have_slipped_where_a_marker_was_moved():
    class Surprised:
        readings = (_read(5, True), _read(6, True), _read(9, True))

        def marginals(self):
            return None

        def surprises(self, _):
            return self.squares

    graph = Surprised()
    for squares, slack, agreed in (
        ((20.0, 30.0, 99.0), 2.0, True),
        ((20.0, 43.0, 99.0), 2.0, False),
        ((20.0, 30.0, 99.0), 1.0, False),
        ((22.0, 3.0, 99.0), 2.0, False),
    ):
        graph.squares = squares
        assert moves._agreed(graph, [graph.readings[0]], slack) == agreed, squares


def test_sides_of_two_readings_may_do_without_one():
    a, b, c, d = (_read(k, True) for k in range(4))
    assert list(moves._variants([a], [b, c, d])) == [([a], [b, c, d])]
    assert list(moves._variants([a, b], [c, d])) == [
        ([a, b], [c, d]), ([a, b], [c]), ([a, b], [d]), ([a], [c, d]), ([b], [c, d]),
    ]  # fmt: skip


def test_several_moves_told_by_single_readings_are_slips(monkeypatch):
    places = {number: Place(number) for number in range(3)}
    for number, place in places.items():
        place.votes[number + 1] += 1
    graph = Graph(places={number: (1000.0 * number, 0.0, 0.0) for number in places})
    graph.readings = [Reading(k, k // 4, (0.0, 0.0, 0.0), k % 4 == 0) for k in range(8)]
    graph.poses = {k: (1000.0 * (k // 4) + 500 * (k % 4 > 0), 0.0, 0.0) for k in range(8)}

    def tried(graph, number, earlier, later, former):
        graph.places[former] = graph.places[number]
        earlier[0].place = former
        return moved_mm[number]

    moved_mm = {0: 300.0, 1: 500.0}
    monkeypatch.setattr(moves, "_tried", tried)
    assert moves.find_moves(graph, places) == [] and sorted(places) == [0, 1, 2]
    assert sorted(graph.places) == [0, 1, 2] and [one.place for one in graph.readings] == [0] * 4 + [1] * 4
    moved_mm[0] = 200.0  # one that stands out is no slip
    assert [move.id for move in moves.find_moves(graph, places)] == [2]
    assert [one.place for one in graph.readings] == [0] * 4 + [3] + [1] * 3
    graph.readings, graph.places = graph.readings[:4], {0: (0.0, 0.0, 0.0)}
    assert [move.id for move in moves.find_moves(graph, places)] == [1]
