"""Maps from one drive of a vehicle with odometry, under markers that are never seen together."""

import json
import re

import cv2
import numpy as np
import pytest

from larics_host import cli
from larics_host.commands import map as map_command
from larics_host.mapping import build, layout
from larics_host.mapping.association import Found
from larics_host.mapping.collect import Collected
from larics_host.mapping.links import Place
from larics_host.mapping.mapfile import read_map
from larics_host.mapping.poses import after
from tests.host.surveys import built_from
from tools.simulated_drives import World, drive, write_log
from tools.survey_drives import score, taped


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


def test_what_no_map_can_be_built_from_is_said(tmp_path, capsys):
    one = drive(World(markers=6, length_m=20.0, moved=False, wrong=0.0, wrong_frames=0.0), 5007)
    log, out = str(write_log(tmp_path / "drive.jsonl", one)), str(tmp_path / "hall.json")
    raw = str(write_log(tmp_path / "raw.bin", one))
    only = one.hall[0][0]
    one.frames = [(*rest, [seen for seen in seens if seen[0] == only]) for *rest, seens in one.frames]
    single = str(write_log(tmp_path / "single.jsonl", one))
    one.frames = [(*rest, []) for *rest, _ in one.frames]
    nothing = str(write_log(tmp_path / "nothing.jsonl", one))
    for words, said in (
        ((nothing,), "no marker was read in these logs: a map needs two or more"),
        ((single,), "marker %d is the only one that was read: a map needs two or more" % only),
        ((log, str(tmp_path / "." / "drive.jsonl")), "drive.jsonl is given twice"),
        ((nothing, log, raw), "drive.jsonl and %s are of the same drive: give one of them" % raw),
        ((log, "--place", "3,0,0", "--place", "3,9,0"), "marker 3 is given 2 places"),
        ((log, "--place", "3,0,0", "--anchor", "3,9,0,0"), "marker 3 is given 2 places"),
        ((log, "--anchor", "3,0"), "--anchor 3,0: give ID,X,Y,DEG, such as 3,0,0,90"),
        ((log, "--anchor", "3.5,0,0,0"), "--anchor 3.5,0,0,0: 3.5 is no ID"),
        ((log, "--place", "3,inf,0"), "--place 3,inf,0: give ID,X,Y or ID,X,Y,DEG"),
        ((log, "--distance", "3,17"), "--distance 3,17: give ID,ID,MM"),
        ((log, "--distance", "3,3,90"), "--distance 3,3,90: two markers"),
    ):
        assert cli.main(["map", "build", *words, "-o", out]) == 2
        assert said in capsys.readouterr().err


def test_logs_of_two_halls_that_were_joined_are_two_drives(tmp_path, capsys):
    """The frames' numbers and the way begin anew in between: what odometry says there is of two vehicles."""
    logs = []
    for seed in (3, 4):
        one = drive(World(markers=6, length_m=25.0, moved=False, wrong=0.0), seed)
        logs.append(write_log(tmp_path / ("%d.bin" % seed), one).read_bytes())
    (tmp_path / "joined.bin").write_bytes(b"".join(logs))
    out = str(tmp_path / "hall.json")
    assert cli.main(["map", "build", str(tmp_path / "joined.bin"), "-o", out]) == 1
    assert "problem: not tied to the rest: marker" in capsys.readouterr().out


def test_a_way_that_is_told_a_little_shorter_is_no_other_drive(tmp_path):
    """Each frame has the way at its own time, interpolated or foretold: it may step back a little."""
    one = drive(World(markers=6, length_m=25.0, moved=False, wrong=0.0), 3)
    one.frames = [
        (number, pose, way + 50 * (number % 10 == 0), turn + 0.5 * (number % 10 == 0), seen)
        for number, pose, way, turn, seen in one.frames
    ]
    out = str(tmp_path / "hall.json")
    assert cli.main(["map", "build", str(write_log(tmp_path / "drive.bin", one)), "-o", out]) == 0
    assert len(read_map(out).markers) == 6


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
