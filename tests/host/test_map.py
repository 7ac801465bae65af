"""`larics map`: files, checks, pictures, and maps built from logs against the truth."""

import itertools
import json
import math

import cv2
import numpy as np
import pytest

from larics.marker import CODED
from larics.wire import messages as m
from larics_host import cli
from larics_host.mapping import mapfile
from tests.host.test_monitor import firmware
from tools.host_figures import hall_of, map_errors, marker_line, rendered_log, serpentine


def larics_map(*argv):
    return cli.main(["map", *map(str, argv)])


def seen_from(pose, hall, reach_mm=(820, 650)):
    """[(ID, x, y, heading)] in the vehicle frame of the markers in view."""
    turn = math.radians(pose[2])
    seen = []
    for marker_id, x, y, heading in hall:
        dx, dy = x - pose[0], y - pose[1]
        ahead, left = math.cos(turn) * dx + math.sin(turn) * dy, -math.sin(turn) * dx + math.cos(turn) * dy
        if abs(left) < reach_mm[0] and abs(ahead) < reach_mm[1]:
            seen.append((marker_id, ahead, left, heading - pose[2]))
    return seen


def write_log(path, hall, poses, wrong=0.0, noise_mm=0.5, noise_deg=0.05, seed=1):
    """A log of a drive; `wrong`: share of the readings with another marker's ID."""
    rng = np.random.default_rng(seed)
    ids = sorted({one[0] for one in hall})
    lines = []
    for frame, pose in enumerate(poses):
        seen = seen_from(pose, hall)
        for index, (marker_id, x, y, heading) in enumerate(seen):
            if rng.random() < wrong:
                marker_id = int(rng.choice(ids))
            x, y = x + rng.normal(0, noise_mm), y + rng.normal(0, noise_mm)
            lines.append(
                marker_line(frame, index, len(seen), marker_id, x, y, heading + rng.normal(0, noise_deg))
            )
        if not seen:
            lines.append(marker_line(frame, 0, 0, m.ID_NONE, 0, 0, 0, m.MARKER_NONE))
    path.write_text("".join(lines))
    return path


def errors(path, hall):
    """(mm, deg) by which each true marker is off in a map whose first marker is anchored at its true pose."""
    built = mapfile.read_map(path).markers
    off = []
    for marker_id, x, y, heading in hall:
        near = [b for b in built if b.id == marker_id]
        best = min(near, key=lambda b: math.hypot(b.x_mm - x, b.y_mm - y))
        turned = abs((best.heading_deg - heading + 180) % 360 - 180)
        off.append((math.hypot(best.x_mm - x, best.y_mm - y), turned))
    return np.array(off)


def anchor_of(hall, k=0):
    return ",".join(str(value) for value in hall[k])


def test_a_hall_from_a_log_with_wrong_readings(tmp_path, capsys):
    hall = [(CODED.ids()[k], *one[1:]) for k, one in enumerate(hall_of(5))]
    log = write_log(tmp_path / "run.jsonl", hall, serpentine(40), wrong=0.03)
    out = tmp_path / "hall.json"
    png = tmp_path / "hall.png"
    # twenty different IDs show the estimate alone
    assert larics_map("build", log, "-o", out, "--anchor", anchor_of(hall), "--png", png, "--heights") == 0
    printed = capsys.readouterr().out
    assert "problem:" not in printed
    assert "20 markers written" in printed and "readings refused" in printed
    off = errors(out, hall)
    assert off[:, 0].max() < 8 and off[:, 1].max() < 0.25
    assert mapfile.read_map(out).markers[0].height_mm == 2750.0
    in_metres = "%d,%d,0.9" % (hall[0][0], hall[1][0])
    assert larics_map("build", log, "-o", tmp_path / "no.json", "--distance", in_metres) == 2
    text = capsys.readouterr().err
    assert "millimetres" in text and text.count("\n") == 1 and not (tmp_path / "no.json").exists()
    assert cv2.imread(str(png)).shape[0] > 300


def test_repeated_ids_are_told_apart_by_their_place(tmp_path, capsys):
    hall = hall_of(5)
    log = write_log(tmp_path / "run.jsonl", hall, serpentine(40), wrong=0.03)
    out = tmp_path / "hall.json"
    assert larics_map("build", log, "-o", out, "--repeats") == 0, capsys.readouterr().out
    assert len(mapfile.read_map(out).markers) == 20
    assert map_errors(mapfile.read_map(out).markers, hall).max() < 8


def test_a_rendered_hall(tmp_path, capsys):
    """Frames of 20 markers, detected and located by the product's own code, then built into a map."""
    hall = hall_of(1800)
    rendered_log(tmp_path / "run.jsonl", hall, 1800, 270)
    out = tmp_path / "hall.json"
    code = larics_map("build", tmp_path / "run.jsonl", "-o", out, "--repeats", "--png", tmp_path / "hall.png")
    built = mapfile.read_map(out).markers
    assert code == 0 and len(built) == 20, capsys.readouterr().out
    assert map_errors(built, hall).max() < 3


def test_markers_that_nothing_ties_are_reported_and_distances_tie_them(tmp_path, capsys):
    near, far = [(1, 0, 0, 10.0), (2, 800, 0, 20.0)], [(3, 3000, 200, 30.0), (4, 3800, 300, 40.0)]
    poses = [(x, 0, 0.0) for x in range(200, 500, 20)]
    poses += [(x, 250, 0.0) for x in range(3200, 3600, 20)]
    log = write_log(tmp_path / "run.jsonl", near + far, poses, noise_mm=0.1, noise_deg=0.01)
    out = tmp_path / "hall.json"
    build = ("build", log, "-o", out, "--force", "--anchor", "1,0,0,10")
    assert larics_map(*build) == 1
    said = capsys.readouterr().out
    assert "not tied to the rest: marker 3" in said and "2 markers written" in said

    def distance(a, b):
        return "%d,%d,%.1f" % (a[0], b[0], math.hypot(a[1] - b[1], a[2] - b[2]))

    few = ["--distance", distance(near[0], far[0])]
    assert larics_map(*build, *few) == 1 and "takes three distances" in capsys.readouterr().out
    ties = [(near[0], far[0]), (near[1], far[0]), (near[0], far[1]), (near[1], far[1])]
    mirrored = [word for a, b in ties for word in ("--distance", distance(a, b))]
    # all measured from two markers in a line: the group may lie on either side of it, and turned over it
    # cannot be, because its headings are known; so the two places are told apart by the distances alone
    code = larics_map(*build, *mirrored)
    said = capsys.readouterr().out
    if code:
        assert "two places" in said
    else:
        assert errors(out, near + far)[:, 0].max() < 12
    wrong = [*mirrored[:-1], "4,2,9000"]
    assert larics_map(*build, *wrong) == 1 and "contradict" in capsys.readouterr().out


def test_files_are_made_checked_and_drawn(tmp_path, capsys):
    path = tmp_path / "hall.json"
    markers = ("--marker", "3,0,0,0", "--marker", "5,1500.5,0,90,2600,75")
    assert larics_map("create", path, *markers, "--route", "3,5,3") == 0
    hall = mapfile.read_map(path)
    assert hall.route == [3, 5, 3] and hall.markers[1] == mapfile.Marker(5, 1500.5, 0.0, 90.0, 2600.0, 75.0)
    assert hall.rows()[1] == [5, 1500, 0, 9000, 26000, 750, 0, 0]
    assert larics_map("create", path, *markers) == 2 and "exists" in capsys.readouterr().err
    assert larics_map("check", path) == 0 and "2 markers, route of 3 steps" in capsys.readouterr().out
    assert larics_map("draw", path, "-o", tmp_path / "hall.png") == 0
    assert cv2.imread(str(tmp_path / "hall.png")) is not None
    (tmp_path / "survey.csv").write_text("id,x_mm,y_mm,heading_deg\n1,0,0,0\n2,900,0,45.5\n")
    assert larics_map("create", tmp_path / "b.json", "--csv", tmp_path / "survey.csv") == 0
    assert mapfile.read_map(tmp_path / "b.json").markers[1].heading_deg == 45.5


@pytest.mark.parametrize(
    "markers, options, parts",
    [
        (["3,0,0,0", "3,900,0,0"], [], ["marker 3 twice within 2000 mm"]),
        (["3,0,0,0", "4,300,0,0"], [], ["markers 3 and 4 at impossible places: their plates overlap"]),
        (["3,0,0,0", "4,9000,0,0"], ["--reach-mm", "4000"], ["9000 mm from the nearest", "3 is 9000"]),
        (["3,0,0,0", "4,2000,0,0"], ["--distance", "3,4,2500"], ["2000 mm apart in the map, 2500 mm"]),
        (["3,0,0,0", "8,1000,0,0"], [], ["marker 8: no camera reads this ID, the coded family has IDs"]),
        (["3,0,0,0", "3,900,0,0", "4,950,0,0"], [], ["3 twice", "3 and 4 at impossible"]),
    ],
)
def test_every_problem_is_named(markers, options, parts, tmp_path, capsys):
    words = [word for text in markers for word in ("--marker", text)]
    larics_map("create", tmp_path / "m.json", *words)
    capsys.readouterr()
    assert larics_map("check", tmp_path / "m.json", *options) == 1
    said = capsys.readouterr().out
    assert all(part in said for part in parts), said


def test_unreachable_route_steps(tmp_path, capsys):
    path = tmp_path / "m.json"
    markers = (
        "--marker",
        "1,0,0,0",
        "--marker",
        "2,2000,0,0",
        "--marker",
        "3,9000,0,0",
        "--marker",
        "4,8000,0,0",
    )
    larics_map("create", path, *markers, "--route", "1,2,3,4,3")
    capsys.readouterr()
    assert larics_map("check", path, "--reach-mm", 6000) == 1
    said = capsys.readouterr().out
    assert said.strip() == "problem: route step 3: marker 3 is 7000 mm from marker 2, out of reach"
    larics_map("create", path, *markers, "--route", "1,5", "--force")
    assert "marker 5 is not in the map" in capsys.readouterr().out


def test_a_map_goes_to_a_real_firmware(tmp_path, capsys):
    path = tmp_path / "hall.json"
    larics_map("create", path, "--marker", "5,10,20,90", "--marker", "6,2010,20,0", "--route", "5,6,5")
    with firmware(tmp_path) as (device, _):
        assert larics_map("send", path, "--port", device) == 0
        assert "changed: map, route" in capsys.readouterr().out
        assert cli.main(["settings", "get", "--port", device, "map", "route"]) == 0
    assert capsys.readouterr().out == (
        "map = [[5, 10, 20, 9000, 0, 0, 0, 0], [6, 2010, 20, 0, 0, 0, 0, 0]]\nroute = [5, 6, 5]\n"
    )


@pytest.mark.parametrize(
    "argv, part",
    [
        (["check", "none.json"], "cannot read none.json"),
        (["check", "broken.json"], "broken.json is no JSON file"),
        (["check", "list.json"], "it has no list of markers"),
        (["check", "old.json"], "map of version 7, this is version 1"),
        (["check", "odd.json"], "odd.json, marker 1: x_mm is [], not a number"),
        (["check", "huge.json"], "huge.json, marker 1: x_mm is 1000"),
        (["check", "rout.json"], "rout.json: unknown rout; a map has version, markers and route"),
        (["check", "word.json"], 'word.json is a map of version "1", this is version 1'),
        (["check", "text.json"], 'text.json, marker 1: id is the text "5": write a number, without quotes'),
        (["build", "text.json", "-o", "x.json"], "text.json line 1 is not from larics log"),
        (["build", "note.txt", "-o", "x.json"], "note.txt holds no message, 6 bytes: text (hello)"),
        (["check", "short.json"], "short.json, marker 2: heading_deg is missing"),
        (["create", "x.json"], "a map needs markers"),
        (["create", "x.json", "--marker", "1,2"], "--marker 1,2: give ID,X,Y,DEG, such as 3,0,1500,90"),
        (["create", "x.json", "--marker", "1,2,nan,0"], "--marker 1,2,nan,0: y_mm is 'nan', not a number"),
        (["create", "x.json", "--marker", "1.5,2,3,0"], "id is '1.5', not a whole number"),
        (["create", "x.json", "--marker", "65535,2,3,0"], "id is 65535: 0 to 65534 are allowed"),
        (["create", "x.json", "--marker", "1,2,3,0", "--route", "a"], "--route a is no list"),
        (["build", "none.jsonl", "-o", "x.json"], "cannot read none.jsonl"),
        (["build", "lonely.jsonl", "-o", "x.json"], "no two markers were seen in one frame"),
        (["build", "raw.jsonl", "-o", "x.json"], "calibrate the camera first"),
        (["build", "lonely.jsonl", "-o", "x.json", "--anchor", "1,2"], "--anchor 1,2: give ID,X,Y,DEG"),
        (["build", "lonely.jsonl", "-o", "x.json", "--distance", "1,2,0"], "a distance above 0"),
        (["build", "lonely.jsonl", "-o", "x.json", "--distance", "1,9,50"], "marker 9: no place"),
        (["draw", "empty.json", "-o", "x.png"], "empty.json has no marker"),
    ],
)
def test_bad_input_is_one_line(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    one = {"id": 1, "x_mm": 0, "y_mm": 0, "heading_deg": 0}
    for name, data in (
        ("list", [1]),
        ("old", {"version": 7, "markers": []}),
        ("odd", {"version": 1, "markers": [dict(one, x_mm=[])]}),
        ("text", {"version": 1, "markers": [dict(one, id="5")]}),
        ("short", {"version": 1, "markers": [one, {"id": 2, "x_mm": 1, "y_mm": 2}]}),
        ("empty", {"version": 1, "markers": []}),
        ("huge", {"version": 1, "markers": [dict(one, x_mm=10**400)]}),
        ("rout", {"version": 1, "markers": [one], "rout": [1]}),
        ("word", {"version": "1", "markers": [one]}),
    ):
        (tmp_path / (name + ".json")).write_text(json.dumps(data))
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "note.txt").write_text("hello\n")
    (tmp_path / "lonely.jsonl").write_text(
        "".join(marker_line(k, 0, 1, 1 + k // 9, 0, 0, 0) for k in range(18))
    )
    (tmp_path / "raw.jsonl").write_text(marker_line(1, 0, 1, 3, 0, 0, 0, m.MARKER_NO_OFFSET))
    assert larics_map(*argv) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1


@pytest.mark.parametrize(
    "places, is_told, problems",
    [
        ([(0, 0), (1.5, 0), (1.5, 30)], True, 1),
        ([(0, 0), (150, 0), (150, 30)], True, 1),
        ([(0, 0), (150, 0), (0, 30), (900, 0)], False, 3),  # some have been measured wrongly
        ([(0, 0), (0, 0)], False, 1),
        ([(0, 0)], False, 0),
    ],
)
def test_places_in_metres_are_one_problem_that_names_them(tmp_path, capsys, places, is_told, problems):
    path = tmp_path / "hall.json"
    words = [["--marker", "%d,%g,%g,0" % (number, *place)] for number, place in enumerate(places, 1)]
    larics_map("create", path, *itertools.chain(*words))
    out = capsys.readouterr().out
    assert ("are the places in metres?" in out) == is_told
    assert out.count("problem") == problems


def test_sizes_in_metres_are_doubted(tmp_path, capsys):
    path = tmp_path / "hall.json"
    assert larics_map("create", path, "--marker", "3,0,0,0,2.75,0.15", "--marker", "5,2000,0,0,2750,150") == 0
    out = capsys.readouterr().out
    assert "doubt: marker 3: height_mm is 2.75: is it in metres?" in out
    assert "doubt: marker 3: radius_mm is 0.15: is it in metres?" in out and "marker 5" not in out


def test_a_map_without_a_marker_is_a_problem(tmp_path, capsys):
    (tmp_path / "hall.json").write_text('{"version": 1, "markers": [], "route": [3, 5]}')
    assert larics_map("check", tmp_path / "hall.json") == 1
    assert capsys.readouterr().out == "problem: there is no marker in the map\n"
