"""Ctrl-C while frames are rendered or a drive is simulated: what is there is whole, and told."""

import json
import os
import signal

import pytest

from larics_host import cli, files
from larics_host.drive import simulation
from larics_host.truth import read_truth
from tests.host.test_log import rows


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_drive_that_is_interrupted_keeps_what_was_driven(tmp_path, monkeypatch, capfd, number):
    firmwares = []
    report_frame = simulation.Simulation._report_frame

    def interrupted(self, firmware, index, *exposed):
        if index == 5:
            # Ctrl-C in a terminal goes to all of its session: the interpreter of the firmware is not in it
            assert os.getsid(firmware._process.pid) != os.getsid(0)
            firmwares.append(firmware._process)
            os.kill(os.getpid(), number)
        report_frame(self, firmware, index, *exposed)

    monkeypatch.setattr(simulation.Simulation, "_report_frame", interrupted)
    folder = tmp_path / "drive"
    assert cli.main(["simulate", "--drive", "loop", "--seconds", "60", "-o", str(folder)]) == 130
    out, err = capfd.readouterr()
    assert err == "" and out.startswith("interrupted after")
    assert "frames.csv and score.json in %s" % folder in out
    assert firmwares[0].returncode is not None and len(rows(folder / "frames.csv")) == 5
    assert json.loads((folder / "score.json").read_text())
    assert (folder / "wire.bin").stat().st_size > 100
    for name in ("path.png", "strip.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


def test_a_drive_that_is_interrupted_before_its_first_frame_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(simulation.Simulation, "_report_frame", interrupted)
    folder = tmp_path / "drive"
    assert cli.main(["simulate", "--drive", "loop", "-o", str(folder)]) == 130
    assert not folder.exists()


def test_a_simulation_that_is_interrupted_keeps_whole_frames(tmp_path, capsys, monkeypatch):
    from larics_host.commands import simulate

    written = []

    def write(path, frame):
        if len(written) == 3:
            raise KeyboardInterrupt
        written.append(path.name)
        files.write_file(path, frame.tobytes())

    monkeypatch.setattr(simulate, "write_frame", write)
    folder = tmp_path / "frames"
    assert cli.main(["simulate", "--frames", "9", "-o", str(folder)]) == 130
    assert capsys.readouterr().out.startswith("interrupted: 3 frames with ")
    assert [truth.frame for truth in read_truth(folder)] == written
