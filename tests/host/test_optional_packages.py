"""Without an optional package, the one command that needs it says so in one line."""

import os
import subprocess
import sys
import tomllib

import pytest

from larics_host import cli
from larics_host.errors import EXTRAS
from tests.host.test_dual import ROOT
from tests.host.test_log import marker_values, wire


@pytest.mark.parametrize(
    "package, argv",
    [
        ("mcap", ["log", "--input", "run.bin", "-o", "out", "--mcap"]),
        ("mcap", ["log", "--input", "run.bin", "-o", "out", "--bag"]),
        ("cyclonedds", ["ros2", "--input", "run.bin"]),
        ("scipy", ["calibrate", "--places", "."]),
        ("gtsam", ["map", "build", "run.bin", "-o", "out.json"]),
        ("matplotlib", ["map", "draw", "map.json", "-o", "out.png"]),
        ("numba", ["simulate", "-o", "out"]),
    ],
)
def test_a_missing_package_is_named(package, argv, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.bin").write_bytes(wire((2, marker_values(1))))
    assert cli.main(["map", "create", "map.json", "--marker", "1,0,0,0"]) == 0
    before = sorted(path.name for path in tmp_path.iterdir())
    for name in [name for name in sys.modules if name.split(".")[0] == package] + [package]:
        monkeypatch.setitem(sys.modules, name, None)
    assert cli.main(argv) == 2
    error = capsys.readouterr().err
    assert error.startswith("larics: ") and error.count("\n") == 1
    assert 'needs the Python package %s: pip install "larics[%s]"' % (package, EXTRAS[package]) in error
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_the_extras_that_are_named_install_what_is_missing():
    with open(ROOT / "pyproject.toml", "rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    for package, extra in EXTRAS.items():
        names = [requirement.split(";")[0] for requirement in extras[extra]]
        assert package.replace("_", "-") in names and extra in extras["all"][0]


def test_a_home_that_cannot_be_written_is_no_matter_for_plots():
    code = (
        "import contextlib\nfrom larics_host import cli, plots\nwith contextlib.suppress(SystemExit):\n"
        "    cli.main(['--version'])\nplots.png(plots.new_figure(1, 1))"
    )
    environment = dict(os.environ, MPLCONFIGDIR="/dev/null/none", PYTHONPATH=str(ROOT / "host"))
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""
