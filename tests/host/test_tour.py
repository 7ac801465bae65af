"""The README's tour, run as it stands in an empty folder."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.host.test_dual import ROOT

TEXT = (ROOT / "README.md").read_text()
TOUR = TEXT.split("<!-- tour:begin -->")[1].split("<!-- tour:end -->")[0]
COMMANDS = [text for kind, text in re.findall(r"^```(\w*)\n(.*?)^```$", TOUR, re.M | re.S) if not kind]
LEFT = {
    "tour/drive/truth.csv", "tour/clip.bin", "marker3.pdf", "markers.pdf", "drawn", "detections.jsonl",
    "harsh/scene.json", "curve/truth.csv", "lights/score.json", "report.html", "before.json", "run.csv",
    "run.mcap", "calibrated.json", "fit.png", "hall.json", "hall.png", "seen/messages.jsonl",
    "bag/metadata.yaml",
}  # fmt: skip


@pytest.mark.long(40)
def test_the_tour_works_as_it_stands(tmp_path):
    script = "set -eux\n" + "".join(COMMANDS)
    assert len(COMMANDS) > 12 and "--desk" in script
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = dict(os.environ, PATH=path, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
    try:
        result = subprocess.run(
            ["bash", "-c", script],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=1500,
        )
    finally:
        pid = tmp_path / "camera.pid"
        if pid.exists():
            subprocess.run(["kill", pid.read_text().strip()], stderr=subprocess.DEVNULL)
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
    assert "Traceback" not in result.stderr
    missing = {name for name in LEFT if not (tmp_path / name).exists()}
    assert not missing
    assert (tmp_path / "again.bin").read_bytes() == (tmp_path / "run.bin").read_bytes()
    assert "2 of 2 frames reported alike" in result.stdout and "no problem" in result.stdout
    assert "3 markers written to hall.json" in result.stdout
