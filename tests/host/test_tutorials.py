"""Every tutorial, run as it stands: its blocks of `sh` and `python`, in order, in an empty folder, with a
home that cannot be written."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.host.made_once import made_once
from tests.host.test_dual import ROOT

FOLDER = ROOT / "docs" / "tutorials"
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
SHOWN = ("text", "json", "c", "yaml", "ini")  # not run
# what each leaves behind, and what it must have said
LEFT = {
    "first_marker": ({"marker.pdf", "small.pdf", "drawn", "found.jsonl", "report.html", "run.csv"}, "cells"),
    "calibrate": ({"calibrated.json", "fit.png"}, "+-"),
    "survey": ({"hall.json", "hall.png", "kept.json"}, "3 markers, route of 0 steps: no problem"),
    "webcam": ({"drive.csv", "drive.jsonl"}, "0 damaged"),
    "ros2": ({"drive/metadata.yaml", "again/metadata.yaml"}, "/larics/pose"),
    "fleet": ({"fleet.html", "tables"}, "2 vehicles"),
    "autopilot": ({"hall.json", "drive.mav"}, "VISION_POSITION_ESTIMATE"),
}


RENDER = "larics simulate --tour -o tour\n"


def environment(home):
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return dict(os.environ, PATH=path, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"), HOME=str(home))


@pytest.fixture(scope="session")
def tour(tmp_path_factory):
    """What RENDER leaves: most tutorials begin with it."""

    def render(folder):
        subprocess.run(RENDER.split(), cwd=folder, env=environment(folder), check=True)

    return made_once(tmp_path_factory, "tour", render) / "tour"


def script_of(page):
    """One shell script of all blocks of a page."""
    parts = ["set -eu"]
    for kind, text in BLOCK.findall(page.read_text()):
        assert kind in ("sh", "python", *SHOWN), "%s: a block of %s" % (
            page.name,
            kind,
        )
        if kind == "sh":
            parts.append(text)
        elif kind == "python":
            parts.append("python - <<'END_OF_BLOCK'\n%sEND_OF_BLOCK" % text)
    return "\n".join(parts)


def test_all_tutorials_are_known_and_in_the_index():
    names = {page.stem for page in FOLDER.glob("*.md")}
    assert names == set(LEFT)
    index = (ROOT / "docs" / "index.md").read_text()
    assert all("tutorials/%s\n" % name in index for name in names)


@pytest.mark.long(30)
@pytest.mark.parametrize("name", sorted(LEFT))
def test_a_tutorial_works_as_it_stands(name, tmp_path, request):
    script = script_of(FOLDER / (name + ".md"))
    if RENDER in script:
        copy = "cp -r %s tour\n" % shlex.quote(str(request.getfixturevalue("tour")))
        script = script.replace(RENDER, copy, 1)
    try:
        result = subprocess.run(
            ["bash", "-c", script],
            cwd=tmp_path, env=environment(os.devnull), capture_output=True, text=True, timeout=1500,
        )  # fmt: skip
    finally:
        pid = tmp_path / "camera.pid"
        if pid.exists():
            subprocess.run(["kill", pid.read_text().strip()], stderr=subprocess.DEVNULL)
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
    assert "Traceback" not in result.stderr and "MPLCONFIGDIR" not in result.stderr
    files, said = LEFT[name]
    assert not {file for file in files if not (tmp_path / file).exists()}
    assert said in result.stdout + result.stderr
