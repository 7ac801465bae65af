import json

import pytest

from larics_host import cli
from larics_host.commands.simulate import PRESET_NAMES
from larics_host.images.frame_sources import open_frames
from larics_host.render import PRESETS
from larics_host.truth import read_truth

TINY = ["--width", "80", "--height", "60", "--radius-px", "10"]


def simulate(*arguments):
    return cli.main(["simulate", *map(str, arguments)])


def test_the_presets_named_in_the_help_are_those_there_are():
    assert tuple(PRESETS) == PRESET_NAMES


def test_frames_truth_and_scene(tmp_path, capsys):
    folder = tmp_path / "new" / "frames"
    assert simulate("--frames", 3, "--seed", 7, *TINY, "-o", folder) == 0
    names = ["frame_000000.pgm", "frame_000001.pgm", "frame_000002.pgm"]
    assert sorted(path.name for path in folder.iterdir()) == [*names, "scene.json", "truth.csv"]
    assert (folder / names[0]).read_bytes().startswith(b"P5\n80 60\n255\n")
    assert [frame.shape for _, frame in open_frames([folder / name for name in names])] == [(60, 80)] * 3
    assert [truth.frame for truth in read_truth(folder)] == names
    scene = json.loads((folder / "scene.json").read_text())
    assert (scene["preset"], scene["seed"], scene["frames"]) == ("sunny", 7, 3)
    assert "3 frames" in capsys.readouterr().out


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        assert simulate("--preset", "harsh", "--frames", 2, "--seed", 3, *TINY, "-o", tmp_path / name) == 0
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_a_drive_with_its_map(tmp_path):
    drive = ["--drive", "curve", "--ids", "5,6", "--rate", 2, "--speed-cm-s", 50, "--spacing-mm", 1000]
    assert simulate(*drive, *TINY, "-o", tmp_path) == 0
    scene = json.loads((tmp_path / "scene.json").read_text())
    assert [marker["id"] for marker in scene["markers"]] == [5, 6]
    assert scene["frames"] == 9  # two metres at half a metre a second, twice a second, both ends
    truths = read_truth(tmp_path)
    assert {truth.id for truth in truths} >= {5, 6}
    for truth in truths:
        if truth.id is not None:
            marker = scene["markers"][truth.id - 5]
            assert (truth.marker_x_mm, truth.marker_y_mm) == (marker["x_mm"], marker["y_mm"])


def test_frames_are_replaced_only_when_asked(tmp_path, capsys):
    assert simulate("--frames", 3, *TINY, "-o", tmp_path) == 0
    assert simulate("--frames", 1, *TINY, "-o", tmp_path) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert simulate("--frames", 1, *TINY, "-o", tmp_path, "--overwrite") == 0
    assert len(list(tmp_path.glob("*.pgm"))) == len(read_truth(tmp_path)) == 1


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["--preset", "foggy"], "unknown preset foggy"),
        (["--target", "qr"], "unknown target qr"),
        (["--drive", "zigzag"], "unknown drive zigzag"),
        (["--radius-px", "0"], "--radius-px is 0"),
        (["--radius-px", "nan"], "--radius-px is nan"),
        (["--width", "-360"], "--width is -360"),
        (["--height", "0"], "--height is 0"),
        (["--frames", "0"], "--frames is 0"),
        (["--frames", "many"], "--frames"),
        (["--seed", "-1"], "--seed is -1"),
        (["--line-mm", "60"], "--line-mm is 60"),
        (["--contrast", "-3"], "--contrast is -3"),
        (["--ids", "8"], "unknown marker ID 8: the coded family"),
        (["--ids", "1;2"], "1;2 is no ID"),
        (["--drive", "straight", "--blur-px", "3"], "--blur-px does not go with --drive"),
        (["--speed-cm-s", "20"], "needs --drive"),
    ],
)
def test_bad_input_is_refused_in_one_line(tmp_path, capsys, arguments, part):
    folder = tmp_path / "out"
    assert simulate("--frames", 1, *TINY, *arguments, "-o", folder) == 2
    error = capsys.readouterr().err
    assert part in error and error.startswith("larics: ") and error.count("\n") == 1
    assert not folder.exists()


def test_unwritable_output_is_refused_in_one_line(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    for output in (tmp_path / "file", tmp_path / "file" / "below"):
        assert simulate("--frames", 1, *TINY, "-o", output) == 2
        error = capsys.readouterr().err
        assert error.startswith("larics: cannot write") and error.count("\n") == 1
