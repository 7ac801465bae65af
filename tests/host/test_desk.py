"""The camera on the desk, and what the README's tour works on."""

import contextlib
import os
import signal
import subprocess
import sys

import pytest

from larics_host import cli
from larics_host.connection.camera_settings import connected
from larics_host.connection.client import NoAnswer
from larics_host.drive import desk as drive_desk
from larics_host.drive import tour
from larics_host.images.frame_sources import open_frames
from tests.host.plain_marker import plain_frame
from tests.host.test_dual import ROOT
from tests.host.waiting import PATIENCE_S, wait_until


@pytest.fixture
def frames(tmp_path):
    folder = tmp_path / "frames"
    folder.mkdir()
    for k in range(8):
        data = plain_frame(5, 80.0, 60.0 + k, 90.0, size=(160, 144)).tobytes()
        (folder / ("f%02d.pgm" % k)).write_bytes(b"P5\n160 144\n255\n" + data)
    return folder


@contextlib.contextmanager
def desk(folder, *options):
    """Its port's name. It ends well when it is told to."""
    command = [sys.executable, "-m", "larics_host", "simulate", "--desk", str(folder), *options]
    environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        line = process.stdout.readline()
        assert "open this as the camera's port" in line
        yield line.split(":")[0]
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0


def has_radius(camera, radius_px):
    try:
        return camera.get("radius_min_px") == radius_px
    except NoAnswer:  # it is still starting
        return False


def test_what_it_saved_counts_after_a_restart_and_a_new_start(frames, tmp_path):
    (frames / "settings.json").write_text('{"radius_min_px": 20}')
    with desk(frames, "--link", str(tmp_path / "camera")) as name:
        assert name == str(tmp_path / "camera")
        with connected(name) as camera:
            assert camera.info().board == "desk" and camera.get("radius_min_px") == 20
            camera.set("radius_min_px", 24)
            camera.save()
            camera.set("radius_min_px", 22)
            camera.restart()
        with connected(name) as camera:  # the port stays, nobody has to open it anew
            wait_until(lambda: has_radius(camera, 24))
    assert not (tmp_path / "camera").exists()
    with desk(frames) as name, connected(name) as camera:
        wait_until(lambda: has_radius(camera, 24))


@pytest.mark.parametrize("is_kept", [False, True])
def test_the_number_of_its_process_goes_with_it(frames, tmp_path, monkeypatch, is_kept):
    """In this process, which is told to end once it has begun."""
    (tmp_path / "camera.pid").write_text(
        "%d\n" % (os.getpid() + is_kept)
    )  # kept: it is that of another process
    monkeypatch.setattr(drive_desk, "_relay", lambda *_: None)
    assert cli.main(["simulate", "--desk", str(frames), "--link", str(tmp_path / "camera")]) == 0
    assert not (tmp_path / "camera").is_symlink() and (tmp_path / "camera.pid").exists() is is_kept


@pytest.mark.parametrize(
    "options, expected",
    [
        (["--desk", "/no/such"], "there is no folder /no/such"),
        (["--desk", "{frames}", "--fps", "0"], "--fps 0: give a number from 1 to 1000"),
        (["--desk", "{frames}", "--detach"], "--detach needs --link"),
        (["--desk", "{frames}", "-o", "x"], "does not go with -o"),
        (["--desk", "{frames}", "--settings", "/no/such.json"], "/no/such.json"),
        (["--desk", "{frames}", "--link", "{frames}"], "choose another --link"),
        (["--desk", "{empty}"], "no .pgm frame in the folder"),
        (["--desk", "{empty}", "--link", "{empty}/camera", "--detach"], "no .pgm frame in the folder"),
        ([], "-o DIR is missing"),
    ],
)
def test_bad_input_gets_one_line(frames, tmp_path, options, expected, capsys):
    (tmp_path / "empty").mkdir()
    options = [option.format(frames=frames, empty=tmp_path / "empty") for option in options]
    assert cli.main(["simulate", *options]) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and expected in err and len(err.splitlines()) == 1
    assert not list((tmp_path / "empty").iterdir())


def test_the_log_of_a_camera_that_runs_is_kept(frames, tmp_path, capsys):
    (tmp_path / "camera").touch()
    (tmp_path / "camera.log").write_text("what it says")
    assert cli.main(["simulate", "--desk", str(frames), "--link", str(tmp_path / "camera"), "--detach"]) == 2
    assert "choose another --link" in capsys.readouterr().err
    assert (tmp_path / "camera.log").read_text() == "what it says"


def test_the_tours_recordings_hold_what_their_truth_says(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tour, "SPEED_MM_S", 2400.0)  # a tenth of the frames
    assert cli.main(["simulate", "--tour", "-o", str(tmp_path / "tour")]) == 0
    assert "82 frames" in capsys.readouterr().out
    drive = str(tmp_path / "tour" / "drive")
    assert cli.main(["simulate", "--tour", "-o", str(tmp_path / "tour")]) == 2
    assert "holds clip.bin already" in capsys.readouterr().err
    options = ["--radius-px", "25:35", "--report", str(tmp_path / "r.html"), "--max-wrong", "0"]
    assert cli.main(["validate", drive, *options, "--min-detected", "90"]) == 0
    clip = [frame for _, frame in open_frames([tmp_path / "tour" / "clip.bin"])]
    stills = [frame for _, frame in open_frames([drive])]
    assert len(clip) == len(stills) == 18
    assert all((a == b).all() for a, b in zip(clip, stills, strict=True))
