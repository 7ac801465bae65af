"""Drives that lost themselves, and those that only look so."""

import math

import numpy as np
import pytest

from larics_host.mapping.association import Found, shares_of
from larics_host.mapping.passages import drives
from larics_host.mapping.poses import after
from larics_host.mapping.seams import seam
from larics_host.mapping.sightings import Seen, Sighting, Stretch
from larics_host.mapping.wheels import Way
from tests.host.surveys import built_from
from tools.simulated_drives import World, drive, write_log
from tools.survey_drives import score


def driven(jump, sigma=0.0, beside=()):
    """The Drive of a vehicle that goes 1 m straight on under a marker, in whose sight it goes by (frame ->
    (x mm, y mm, deg)), and under others beside it, [ID]."""
    count = 40
    x = 25.0 * np.arange(count)
    rng = np.random.default_rng(1)
    sightings, frames = [], []
    for k in range(count):
        dx, dy, turned = jump(k)
        off = rng.normal(0, 1, 3) * sigma
        sightings.append(Sighting(5, 500.0 - x[k] + dx + off[0], 100.0 + dy + off[1], 30.0 + turned, 2750.0))
        sightings += [Sighting(one, 500.0 - x[k], -600.0, 0.0, 2750.0) for one in beside]
        frames += [k] * (1 + len(beside))
    stretch = Stretch(np.arange(count), x, np.zeros(count), np.zeros(count))
    ((one,), alone) = drives(Seen(np.arange(count), np.array(frames), sightings, [stretch]))
    assert not alone.any()
    return one


def passed(*jump):
    return driven(*jump).passages


def test_a_marker_in_view_that_goes_is_passed_twice():
    """It was hung elsewhere just then, or the vehicle was carried: odometry has to tell which."""
    assert len(passed(lambda k: (0, 0, 0), 10.0)) == 1
    for moved in ((0.0, 150.0, 0.0), (0.0, 0.0, 15.0), (-800.0, 0.0, 50.0)):
        first, second = passed(lambda k, moved=moved: np.multiply(moved, k >= 20))
        assert first.seen + second.seen <= 40 and first.frame < 20 <= second.frame
        assert second.heading - first.heading == pytest.approx(math.radians(moved[2]), abs=1e-6)
        assert second.y_mm - first.y_mm == pytest.approx(moved[1], abs=1e-6)


def test_a_wild_reading_is_no_passage():
    wild = {7: (0, 0, 90), 20: (0, 200, 0), 21: (0, 200, 0)}
    one = driven(lambda k: wild.get(k, (0, 0, 0)), 0.0, [6])
    first, second = sorted(one.passages, key=lambda passage: passage.id)
    assert first.heading == pytest.approx(math.radians(30.0)) and first.y_mm == pytest.approx(100.0)
    assert (first.id, second.id) == (5, 6) and len(one.together) == 1


def test_a_marker_that_was_moved_in_view_does_not_turn_the_drive(tmp_path):
    one = drive(World(), 17717)
    result = score(one, write_log(tmp_path / "drive.bin", one))
    assert not result.refused and result.moved == [one.hall[one.moved][0]]
    assert len(result.errors) == 30


@pytest.mark.parametrize("seed", [1, 30, 115])
def test_who_is_carried_in_view_of_a_marker_is_lost_as_well(seed, tmp_path):
    """Two are where new places are among those before, one where they are not."""
    one = drive(World(ids=7, carried_m=60.0), seed)
    result = score(one, write_log(tmp_path / "drive.bin", one), "--repeats")
    assert "meets the same markers again" in result.refused


def _hall(motion, count, first=0, turned=True):
    """Founds on a row of 3 m, moved by a motion."""
    founds = []
    for k in range(count):
        heading = 1.7 * k if turned else 0.0
        pose = after(motion, (3000.0 * k, 500.0 * (k % 2), heading))
        founds.append(Found(k + 1, np.array(pose), [first + k], [first + k]))
    return founds


def test_who_meets_all_askew_is_lost():
    before = _hall((0.0, 0.0, 0.0), 8)
    assert seam(before + _hall((0.0, 20000.0, 0.7), 8, 8)) == 8
    assert seam(before + _hall((0.0, 20000.0, 0.7), 4, 8)) is None  # few may be by chance


def test_rows_that_repeat_themselves_are_no_loss():
    before = _hall((0.0, 0.0, 0.0), 8, turned=False)
    for turn in (0.0, math.pi / 2, math.pi):
        assert seam(before + _hall((9000.0, 20000.0, turn), 8, 8, turned=False)) is None
    among = _hall((700.0, 900.0, 0.0), 8, 8, turned=False)
    assert seam(before + among) == 8
    misread = [
        Found(9, np.array((*found.pose[:2] + 20.0, 0.0)), [20 + k], []) for k, found in enumerate(before)
    ]
    assert seam(before + _hall((9000.0, 20000.0, 0.0), 8, 8, turned=False) + misread) is None


def test_who_was_lost_and_found_again_was_lost():
    """Places before are passed again after that, and the new ones too."""
    before, new = _hall((0.0, 0.0, 0.0), 8), _hall((700.0, 900.0, 0.5), 8, 8)
    for k, found in enumerate(before):
        found.passages.append(16 + k)
    assert seam(before + new) == 8


def test_wheels_are_as_unequal_as_wheels_are():
    """With few IDs some chance pairs agree about a drift that no wheels have."""
    one = drive(World(ids=7), 47)
    numbers = np.array([frame[0] for frame in one.frames])
    x, y, heading = np.array([frame[1] for frame in one.frames]).T
    sightings, frames = [], []
    for k, (*_, seen) in enumerate(one.frames):
        sightings += [Sighting(*values, 2750.0) for values in seen]
        frames += [k] * len(seen)
    stretch = Stretch(np.arange(len(numbers)), x, y, np.unwrap(heading))
    ((driven,), _) = drives(Seen(numbers, np.array(frames), sightings, [stretch]))
    assert len(driven.passages) > 50
    shares, _ = shares_of(driven, Way(x, y, np.unwrap(heading)), 0.001)
    assert abs(shares[1]) < 2e-5


def test_who_comes_back_late_is_not_lost(tmp_path):
    """The first marker that is passed again is 90 m away: pairs of headings so far apart tell the drift."""
    _, result = built_from(tmp_path, World(), 20227)
    assert not result.refused and result.errors.max() < 25


def test_a_slip_before_the_first_return_loses_no_drive(tmp_path):
    """Nor where the places before it look like others: louder wheels would explain them, too."""
    _, result = built_from(tmp_path, World(), 20482)
    assert not result.refused and result.errors.max() < 35
