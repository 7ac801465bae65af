"""The wheel does what the checkout does: built, laid into an empty folder, and run there from elsewhere."""

import os
import shutil
import subprocess
import sys

import pytest

from larics import __version__
from larics_host.connection.pty_pair import PtyPair
from tests.host.made_once import made_once
from tests.host.test_dual import ROOT
from tests.host.test_flash import Board

FRAME = ROOT / "tests/frames/sunny_r30_1000_0.pgm"


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder into which the wheel was installed."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]

    def build(folder):  # in the source tree, where two at a time are in each other's way
        command = [*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", str(folder), str(ROOT)]
        subprocess.run(command, check=True, capture_output=True)

    (wheel,) = made_once(tmp_path_factory, "wheel", build).glob("*.whl")
    target = tmp_path_factory.mktemp("wheel") / "site"
    subprocess.run([*pip, "install", "--no-deps", "--target", str(target), str(wheel)], check=True)
    return target


@pytest.fixture(scope="module")
def compiled(installed):
    """The same with the loops that were compiled in the checkout, which numba keeps by a source's date."""
    for kept in [*ROOT.glob("shared/larics/**/*.nb[ic]"), *ROOT.glob("host/larics_host/**/*.nb[ic]")]:
        source = kept.parents[1] / (kept.name.split(".")[0] + ".py")
        target = installed / source.relative_to(ROOT / source.relative_to(ROOT).parts[0])
        shutil.copystat(source, target)
        (target.parent / "__pycache__").mkdir(exist_ok=True)
        shutil.copy(kept, target.parent / "__pycache__")
    return installed


def larics(installed, folder, *words):
    """Runs the installed command; whatever it imports of ours must come from the wheel."""
    environment = dict(os.environ, PYTHONPATH=str(installed))
    environment.pop("MICROPYPATH", None)
    command = [sys.executable, "-m", "larics_host", *map(str, words)]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def test_everything_comes_from_the_wheel(installed, tmp_path):
    environment = dict(os.environ, PYTHONPATH=str(installed))
    code = "import larics, larics_host, larics_vehicle, larics_host.sources as s\n"
    code += (
        "print(larics.__file__, larics_host.__file__, larics_vehicle.__file__, s.source_root(), sep='\\n')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert all(line.startswith(str(installed)) for line in done.stdout.split())


def test_detect_and_marker(compiled, tmp_path):
    done = larics(compiled, tmp_path, "detect", FRAME, "--json", "--radius-px", "25:35")
    assert done.returncode == 0 and '"id": 4' in done.stdout, done.stderr
    assert larics(compiled, tmp_path, "marker", "3", "-o", "m.pdf").returncode == 0
    assert (tmp_path / "m.pdf").stat().st_size > 1000


@pytest.mark.long(50)
def test_a_board_is_flashed_from_it(installed, tmp_path):
    with PtyPair() as cable:
        board = Board(cable, tmp_path / "flash.img")
        try:
            board.power_on()
            done = larics(installed, tmp_path, "flash", "--port", board.port)
        finally:
            board.close()
    assert done.returncode == 0 and "first installation" in done.stdout, done.stderr
    assert done.stdout.splitlines()[-1].strip().startswith("larics %s runs on OpenMV" % __version__)


def test_frames_are_rendered_and_held_against_their_truth(compiled, tmp_path):
    assert (
        larics(compiled, tmp_path, "simulate", "--frames", "2", "--seed", "5400", "-o", "f").returncode == 0
    )
    done = larics(compiled, tmp_path, "validate", "f", "--radius-px", "25:36", "--min-read", "100")
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_the_packages_need_beside_their_modules_is_in_it(installed):
    for name in ("monitor/page.html", "detection/live_page.html", "drive/controller.c"):
        assert (installed / "larics_host" / name).stat().st_size > 1000


def test_the_firmware_runs_from_it(installed, tmp_path):
    done = larics(installed, tmp_path, "camera", "--source", "nothing.mp4", "--settings", tmp_path / "s.json")
    assert done.returncode == 2 and "there is no file nothing.mp4" in done.stderr


def test_the_program_for_a_board_is_the_checkouts(installed, tmp_path):
    code = (
        "from larics_host.flash import build\nfrom larics_host.sources import source_root\nimport sys\n"
        "print(*sorted(name for _, name in build.program(source_root())), sep='\\n')"
    )
    environment = dict(os.environ, PYTHONPATH=str(installed))
    run = [sys.executable, "-c", code]
    ours = subprocess.run(
        run, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    ).stdout
    from larics_host.flash import build

    assert ours.split() == sorted(name for _, name in build.program(ROOT))
