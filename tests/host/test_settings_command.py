"""`larics settings` against the real firmware on MicroPython, and what needs no camera."""

import contextlib
import json
import re

import pytest

from larics import settings as setting_rules
from larics.settings import FIELDS, Settings
from larics.settings.fields import DETECTOR, Field
from larics_host import cli
from larics_host.connection import camera_settings
from larics_host.connection.pty_pair import PtyPair
from larics_host.errors import UserError
from tests.host.firmware_process import start_firmware
from tests.host.plain_marker import plain_frame
from tests.host.terminals import shown_in_terminal


@contextlib.contextmanager
def camera(folder, *options):
    """The serial port at which a firmware answers that sees one frame again and again."""
    (folder / "frames").mkdir()
    (folder / "frames" / "f.pgm").write_bytes(b"P5\n128 112\n255\n" + plain_frame(5).tobytes())
    speed = ["--fps", "30", "--rounds", "0", "--set", "radius_min_px=20", "--set", "radius_max_px=40"]
    with PtyPair() as cable:
        process = start_firmware(folder / "frames", cable.device_a, *speed, *options)
        try:
            yield cable.device_b
        finally:
            process.kill()
            process.communicate()


def settings(capsys, *argv):
    code = cli.main(["settings", *map(str, argv)])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_a_camera_is_read_changed_compared_and_restored(tmp_path, capsys, monkeypatch):
    file = tmp_path / "camera.json"
    with camera(tmp_path, "--set", "ceiling_mm10=25000") as device:
        port = ("--port", device)
        code, out, _ = settings(capsys, "show", *port)
        assert code == 0 and all(field.name in out for field in FIELDS) and "25000" in out
        a_narrow_terminal_gets_lines(device)
        code, out, _ = settings(capsys, "show", *port, "--json")
        values = json.loads(out)
        assert (values["width"], values["ceiling_mm10"], values["map"]) == (128, 25000, [])
        assert settings(capsys, "export", *port, file)[0] == 0
        assert json.loads(file.read_text())["ceiling_mm10"] == 25000
        assert settings(capsys, "export", *port, file)[0] == 2

        # each of these radii would be refused beside the old other one
        changes = [
            "radius_min_px=45",
            "radius_max_px=50",
            "route=3,5,3",
            "map=[[3,0,0,0,0,0],[5,2000,0,9000,0,0]]",
        ]
        code, out, _ = settings(capsys, "set", *port, *changes, "output=larics")
        assert code == 0 and out.startswith("changed: radius_max_px, radius_min_px, route, map\n")
        code, out, _ = settings(capsys, "get", *port, "radius_min_px", "route")
        assert out == "radius_min_px = 45\nroute = [3, 5, 3]\n"
        code, out, _ = settings(capsys, "diff", *port, file)
        assert code == 1 and "radius_min_px: camera 45, %s 20" % file in out
        assert "different: 4 settings" in out

        assert settings(capsys, "restore", *port, file)[0] == 0
        assert settings(capsys, "diff", *port, file)[:2] == (0, "no difference\n")
        code, out, _ = settings(capsys, "restore", *port, file)
        assert code == 0 and "has these values already" in out
        code, out, _ = settings(capsys, "diff", *port)
        assert code == 1 and "ceiling_mm10: camera 25000, default 0" in out

        # refused before anything is sent
        code, _, err = settings(capsys, "set", *port, "rate_divider=2", "radius_min_px=70")
        assert code == 2 and err == "larics: radius_min_px = 70 is not below radius_max_px = 40\n"
        assert settings(capsys, "get", *port, "rate_divider")[1] == "rate_divider = 1\n"
        code, _, err = settings(capsys, "save", *port)  # a PC has no flash
        assert code == 2 and err == "larics: the camera refused SAVE_SETTINGS: storage\n"
        older_than_the_pc(capsys, tmp_path / "newer.json", port, monkeypatch)
        assert settings(capsys, "restart", *port)[0] == 0


def a_narrow_terminal_gets_lines(device):
    told = shown_in_terminal("settings", "show", "--port", device, columns=40)
    lines = re.sub("\x1b\\[[0-9;?]*[a-zA-Z]", "", told.decode()).splitlines()
    at = lines.index("ceiling_mm10 = 25000 0.1 mm")
    assert lines[at + 1].startswith("    0..") and max(map(len, lines)) <= 40


def older_than_the_pc(capsys, file, port, monkeypatch):
    """A camera whose firmware does not have a setting that this PC knows."""
    new = Field(250, "novelty", DETECTOR, "int", 2, 0, 9, "", "what 1.1 brought")
    with monkeypatch.context() as patch:
        patch.setattr(setting_rules, "FIELDS", (*FIELDS, new))
        code, out, _ = settings(capsys, "show", *port)
        assert code == 0 and re.search(r"^novelty +- *$", out, re.MULTILINE) and "margin_min" in out
        patch.setattr("larics_host.commands.settings._TABLE_WIDE", 200)
        out = settings(capsys, "show", *port)[1]
        assert "\nnovelty = - \n" in out and "\n\n" not in re.sub(" +$", "", out, flags=re.MULTILINE)
        file.write_text(json.dumps({"novelty": 2, "rate_divider": 1}))
        code, out, _ = settings(capsys, "restore", *port, file)
        assert code == 0 and "has these values already" in out
        code, _, err = settings(capsys, "set", *port, "rate_divider=5", "novelty=3")
        assert code == 2 and err == (
            "larics: novelty = 3: the camera's firmware is older and has no such setting; "
            "larics flash renews it\n"
        )
        assert settings(capsys, "get", *port, "rate_divider")[1] == "rate_divider = 1\n"


class Camera:
    """Takes settings as a camera does: a conflict is refused."""

    def __init__(self):
        self.settings = Settings()

    def set(self, name, value):
        self.settings.set(name, value)

    def get(self, name):
        return getattr(self.settings, name)


def test_changes_go_in_an_order_that_the_camera_accepts():
    fake = Camera()
    plates = [[3, 0, 0, 0, 0, 0], [5, 2000, 0, 9000, 0, 0]]
    changes = {
        "route": [3, 5],
        "map": plates,
        "allowed_ids": [0, 3, 5],
        "allow_id0": True,
        "radius_min_px": 62,
    }
    changes["radius_max_px"] = 70
    names = camera_settings.apply(fake, Settings().as_dict(), changes)
    assert sorted(names) == sorted(changes)
    assert names.index("allow_id0") < names.index("allowed_ids") and fake.settings.radius_min_px == 62
    back = camera_settings.apply(fake, fake.settings.as_dict(), Settings().as_dict())
    assert sorted(back) == sorted(changes) and fake.settings.as_dict() == Settings().as_dict()


@pytest.mark.parametrize(
    "name, text, value",
    [
        ("width", "320", 320),
        ("mirrored", "true", True),
        ("output", "nmea", "nmea"),
        ("baud", "9600", 9600),
        ("route", "1,2", [1, 2]),
        ("route", "", []),
        ("allowed_ids", "1-7,9,100-199", [[1, 7], 9, [100, 199]]),
        ("allowed_ids", "[3, [9, 15]]", [3, [9, 15]]),
        ("family", "plain", "plain"),
        ("map", "[[1,2,3,4,5,6]]", [[1, 2, 3, 4, 5, 6]]),
    ],
)
def test_values_as_typed(name, text, value):
    assert camera_settings.parse_value(name, text) == value


@pytest.mark.parametrize("name, text", [("width", "x"), ("mirrored", "yes"), ("route", "1;2"), ("hue", "3")])
def test_values_that_cannot_be(name, text):
    with pytest.raises(UserError, match=name):
        camera_settings.parse_value(name, text)


@pytest.mark.parametrize(
    "argv, part",
    [
        (["show"], "--port"),
        (["set", "--port", "/dev/null", "width"], "width is not NAME=VALUE"),
        (["set", "--port", "/dev/null", "width=320", "width=330"], "width is given twice"),
        (["set", "--port", "/dev/null", "width=1"], "width = 1 is not allowed: 80..1024 px"),
        (["get", "--port", "/dev/null", "hue"], "there is no setting hue"),
        (["get", "--port", "/dev/no-port", "width"], "no port /dev/no-port"),
        (["restore", "--port", "/dev/null", "none.json"], "cannot read none.json"),
        (["check", "broken.json"], "broken.json is no JSON file"),
        (["check", "list.json"], "list.json is no table"),
        (["check", "odd.json"], "odd.json: there is no setting hue"),
        (["check", "near.json"], "near.json: there is no setting ceiling_mm; is ceiling_mm10 meant?"),
        (["check", "quoted.json"], 'ceiling_mm10 is the text "25000": write it without quotes, 0..300000'),
        (["check", "point.json"], "ceiling_mm10 is 25000.0: give a whole number, 0..300000"),
        (["check", "null.json"], "ceiling_mm10 is null: give a whole number"),
        (["check", "true.json"], "ceiling_mm10 is true: give a whole number"),
        (["check", "word.json"], 'version is the text "1": write it without quotes'),
        (["check", "conflict.json"], "conflict.json: radius_min_px = 70 is not below"),
        (["nonsense"], "nonsense"),
    ],
)
def test_bad_input_is_one_line(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "list.json").write_text("[1]")
    (tmp_path / "odd.json").write_text('{"hue": 1}')
    (tmp_path / "conflict.json").write_text('{"radius_min_px": 70}')
    (tmp_path / "near.json").write_text('{"ceiling_mm": 2500}')
    (tmp_path / "word.json").write_text('{"version": "1"}')
    for name, value in (("quoted", '"25000"'), ("point", "25000.0"), ("null", "null"), ("true", "true")):
        (tmp_path / (name + ".json")).write_text('{"ceiling_mm10": %s}' % value)
    code, _, err = settings(capsys, *argv)
    assert code == 2 and err.startswith("larics: ") and part in err and err.count("\n") == 1


def test_a_file_is_checked_without_a_camera(tmp_path, capsys):
    camera_settings.write_file(tmp_path / "s.json", {"ceiling_mm10": 30000})
    assert camera_settings.read_file(tmp_path / "s.json")["ceiling_mm10"] == 30000
    code, out, _ = settings(capsys, "check", tmp_path / "s.json")
    assert code == 0 and "%d settings" % len(FIELDS) in out
