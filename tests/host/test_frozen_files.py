"""The JSON of `larics detect` and the files are as they were frozen (tests/freeze/README.md); one version."""

import json
import re
import shutil

import pytest

import larics
from atomic_file import AtomicFile
from faults import Faults
from larics.marker.detection import FLAG_NAMES, Detection
from larics.settings import Settings
from larics.wire import messages as m
from larics_host import cli
from larics_host.connection import camera_settings
from larics_host.detection import detectors
from larics_host.mapping import mapfile
from larics_host.mapping.mapfile import Marker
from larics_host.truth import read_truth
from settings_store import SettingsStore
from tests.freeze import tables
from tests.host.test_dual import ROOT

FILES = tables.FOLDER / "files"
FRAMES = ROOT / "tests" / "frames"
FRAME = "sunny_r30_1000_0.pgm"


def kind_of(values):
    names = {type(None): "null", int: "integer", float: "number", str: "string", list: "list"}
    return " or ".join(sorted({names[type(value)] for value in values}, key=lambda name: name == "null"))


def detected(capsys):
    """The JSON of a frame with one marker, and that marker."""
    assert cli.main(["detect", str(FRAMES / FRAME), "--json"]) == 0
    frame = json.loads(capsys.readouterr().out)
    return frame, frame["detections"][0]


def keys_of(frame, seen):
    """(object, key, type) of the JSON, with what may be unknown."""
    unknown = detectors.as_dict(Detection())
    now = [("frame", key, kind_of([value])) for key, value in frame.items()]
    return now + [("detection", key, kind_of([value, unknown[key]])) for key, value in seen.items()]


def test_the_json_of_detect(capsys, monkeypatch):
    """Of a frame whose truth is known, so that units and directions count, too."""
    frame, seen = detected(capsys)
    truth = next(one for one in read_truth(FRAMES / "truth.csv") if one.frame == FRAME)
    assert seen["id"] == truth.id
    assert (seen["x"], seen["y"]) == pytest.approx((truth.x_px, truth.y_px), abs=0.1)
    assert seen["heading"] == pytest.approx(truth.heading_deg, abs=0.2)
    assert seen["radius"] == pytest.approx(truth.radius_px, abs=0.1)
    assert 0 < seen["sigma"] < 0.1 and 0 < seen["heading_sigma"] < 0.3 and 0 < seen["margin"] <= 255
    rows = tables.rows("detect.txt")
    frozen = [(row["object"], row["key"], row["type"]) for row in rows]
    assert keys_of(frame, seen) == frozen, (
        "programs read this: a key keeps its name, type, unit and meaning. Add a new key, and by hand its "
        "row in tests/freeze/detect.txt"
    )
    flags = next(row["meaning"] for row in rows if row["key"] == "flags")
    assert flags == "names: %s; others may follow" % " ".join(name for _, name in FLAG_NAMES)

    told = detectors.as_dict
    for change in ({"margin": "204"}, {"more": 1}, {"id": -1}):
        monkeypatch.setattr(detectors, "as_dict", lambda one, change=change: {**told(one), **change})
        assert keys_of(*detected(capsys)) != frozen


# files


def on_a_board(file, tmp_path):
    """(Settings, Faults) of a board that finds this file on its flash."""
    shutil.copy(file, tmp_path / "settings.json")
    faults = Faults()
    return SettingsStore(AtomicFile(str(tmp_path / "settings.json")), faults).load(), faults


@pytest.mark.parametrize("version", ["0.1", "1"])
def test_settings_files_of_every_version_are_read(version, tmp_path):
    """By the PC and by a board; what an older one does not have keeps its default."""
    written = json.loads((FILES / ("settings-%s.json" % version)).read_text())
    assert written["version"] == 1
    loaded = Settings(camera_settings.read_file(FILES / ("settings-%s.json" % version))).as_dict()
    flash = FILES / ("settings-%s.flash" % version)  # as a camera keeps it
    assert Settings(camera_settings.read_file(flash)).as_dict() == loaded
    changed = tmp_path / "changed.json"
    changed.write_bytes(flash.read_bytes().replace(b'"height": 296', b'"height": 300'))
    with pytest.raises(camera_settings.UserError, match="its checksum does not fit"):
        camera_settings.read_file(changed)
    board, faults = on_a_board(flash, tmp_path)
    assert board.as_dict() == loaded and faults.total == 0
    expected = {**Settings().as_dict(), **written}
    expected["map"] = [[*row, 0, 0][:8] for row in written["map"]]
    assert loaded == expected
    frozen = {row["name"] for row in tables.rows("settings.txt")} | {"version"}
    assert set(written) < frozen
    if version == "1":
        assert frozen - set(written) == {"row_ns"}  # appended since that file was written


def test_a_radius_of_0_1_that_no_detector_has_is_told(tmp_path):
    """0.1 took 5 to 400 px. The rest of such a file is used."""
    values = json.loads((FILES / "settings-0.1.json").read_text())
    values["radius_max_px"] = 100
    (tmp_path / "far.json").write_text(json.dumps(values))
    with pytest.raises(camera_settings.UserError, match=r"radius_max_px = 100 is not allowed: 6\.\.72 px"):
        camera_settings.read_file(tmp_path / "far.json")
    faults = Faults()
    board = SettingsStore(AtomicFile(str(tmp_path / "far.json")), faults).load()
    assert (board.radius_max_px, board.radius_min_px, board.focal_q8) == (60, 12, 92160)
    assert faults.active == 1 << m.FAULT_SETTINGS_CORRUPT


MAPS = {
    "0.1": [Marker(3, 0, 0, 0), Marker(5, 1500.5, 0, 90), Marker(6, 3000, -200.25, 270.5, 2900, 100)],
    "1": [
        Marker(3, 0, 0, 0, None, None, 1.2, 0.08),
        Marker(5, 1500.5, 0, 90),
        Marker(1513, 3000, -200.25, 270.5, 2900, 100, 2, 0.15),
    ],
}


@pytest.mark.parametrize("version", MAPS)
def test_map_files_of_every_version_are_read(version):
    markers = MAPS[version]
    hall = mapfile.read_map(FILES / ("map-%s.json" % version))
    assert hall.markers == markers and hall.route == [3, 5, markers[2].id, 5, 3]
    assert Settings({"map": hall.rows(), "route": hall.route}).map[1] == [5, 1500, 0, 9000, 0, 0, 0, 0]


def test_map_files_of_this_version_are_written_as_they_were(tmp_path):
    mapfile.write_map(tmp_path / "map.json", mapfile.Map(MAPS["1"], [3, 5, 1513, 5, 3]))
    told, frozen = (json.loads(file.read_text()) for file in (tmp_path / "map.json", FILES / "map-1.json"))
    assert told == frozen and told["version"] == 1
    with pytest.raises(camera_settings.UserError, match="is a map of version 2, this is version 1"):
        (tmp_path / "later.json").write_text(json.dumps({**frozen, "version": 2}))
        mapfile.read_map(tmp_path / "later.json")


# the version


def test_every_place_tells_one_version():
    places = {
        "package.json": r'"version": "(.+)"',
        "firmware/vehicle/library.properties": r"^version=(.+)$",
        "firmware/vehicle/library.json": r'"version": "(.+)"',
        "firmware/vehicle/idf_component.yml": r'^version: "(.+)"$',
        "ros2/larics_msgs/package.xml": r"<version>(.+)</version>",
        "ros2/larics_ros/package.xml": r"<version>(.+)</version>",
        "ros2/larics_ros/setup.py": r'version="(.+)"',
        "CHANGELOG.md": r"^## (\d\S*)",
        "docs/release.md": r"^# Release (\S+)",
        "README.md": r"^State: version (\S+)\.",
        "docs/wire.md": r"^    \$PLRCS,(\d[^,]*),",
    }
    told = {
        path: re.search(pattern, (ROOT / path).read_text(), re.MULTILINE).group(1)
        for path, pattern in places.items()
    }
    assert told == dict.fromkeys(places, larics.__version__)
    pages = [ROOT / "README.md", ROOT / "ros2" / "README.md", *(ROOT / "docs").rglob("*.md")]
    wheels = [
        name for page in pages for name in re.findall(r"larics-([\w.]+)-py3-none-any", page.read_text())
    ]
    assert len(wheels) > 5 and set(wheels) == {larics.__version__}
