"""Compiled loops are kept where that is possible; nothing fails where it is not, and waiting is explained."""

import json
import os
import shutil
import subprocess
import sys

import pytest

from larics import _cpython
from larics_host import compilation, errors
from tests.host.test_dual import ROOT

FRAME = ROOT / "tests" / "frames" / "sunny_r30_1000_0.pgm"


def chosen(tmp_path, monkeypatch, writable):
    """_choose_cache where only these folders (by name) can be written; os.access knows no limits for root."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    monkeypatch.setattr(_cpython, "_usable", lambda folder: any(name in str(folder) for name in writable))
    return _cpython._choose_cache(str(tmp_path / "home"), [], str(tmp_path / "temporary"))


def test_where_compiled_loops_are_kept(tmp_path, monkeypatch):
    (tmp_path / "home").mkdir()
    assert chosen(tmp_path, monkeypatch, ["home", "own", "temporary"]) == (None, True, None)
    folder, kept, line = chosen(tmp_path, monkeypatch, ["own", "temporary"])
    assert folder == str(tmp_path / "own" / "larics-loops") and kept and line is None
    folder, kept, line = chosen(tmp_path, monkeypatch, ["temporary"])
    assert folder == str(tmp_path / "temporary") and kept
    assert line.startswith("larics: compiled loops are kept in %s, as neither" % folder) and "\n" not in line
    (tmp_path / "temporary").mkdir()
    assert chosen(tmp_path, monkeypatch, ["temporary"]) == (folder, True, None)  # told before
    folder, kept, line = chosen(tmp_path, monkeypatch, [])
    assert folder is None and not kept and "compiled anew each time" in line


def test_a_folder_of_somebody_else_is_not_trusted(tmp_path, monkeypatch):
    assert _cpython._usable(str(tmp_path / "mine"))
    monkeypatch.setattr(os, "getuid", lambda: os.stat(tmp_path).st_uid + 1)
    assert not _cpython._usable(str(tmp_path / "mine"))
    assert not _cpython._usable("/proc/none")


def test_what_the_installation_compiled_is_taken_along(tmp_path):
    package = tmp_path / "larics" / "kernels"
    (package / "__pycache__").mkdir(parents=True)
    (package / "__pycache__" / "votes.py311.nbi").write_bytes(b"index")
    (package / "__pycache__" / "votes.pyc").write_bytes(b"not this")
    _cpython._take_along([str(tmp_path / "larics")], str(tmp_path / "kept"))
    import numba.core.caching as caching

    name = caching._CacheLocator.get_suitable_cache_subpath(str(package / "votes.py"))
    assert [path.name for path in (tmp_path / "kept" / name).iterdir()] == ["votes.py311.nbi"]


def test_detection_where_neither_the_installation_nor_a_home_can_be_written(tmp_path):
    pytest.importorskip("numba")
    shutil.copytree(ROOT / "shared", tmp_path / "shared")
    beside = tmp_path / "shared" / "larics" / "__pycache__"
    shutil.rmtree(beside, ignore_errors=True)
    beside.write_text("a file, so that there can be no folder")
    (tmp_path / "temporary").mkdir()
    environment = {
        "PYTHONPATH": "%s:%s" % (tmp_path / "shared", ROOT / "host"),
        "HOME": "/dev/null",
        "TMPDIR": str(tmp_path / "temporary"),
        "PATH": os.environ["PATH"],
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    command = [sys.executable, "-m", "larics_host", "detect", "--json", "--radius-px", "25:35", str(FRAME)]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0 and "Traceback" not in result.stderr
    assert json.loads(result.stdout)["detections"][0]["id"] is not None
    (kept,) = (tmp_path / "temporary").glob("larics-loops*")
    assert "larics: compiled loops are kept in %s, as neither" % kept in result.stderr
    assert list(kept.rglob("*.nbi")) and kept.stat().st_mode & 0o777 == 0o700


def test_who_waits_for_the_compiler_is_told(monkeypatch, capsys):
    import time

    monkeypatch.setattr(compilation, "_PATIENCE_S", 0.01)
    monkeypatch.setattr(compilation, "_has_loops", lambda folder, but: False)
    monkeypatch.setattr(_cpython, "EXECUTOR", "numba")
    errors.begin_run()
    said = ""
    with compilation.told("kernels", "the detection"):
        while not said:
            time.sleep(0.01)
            said = capsys.readouterr().err
    assert said == (
        "larics: compiling the detection for this computer, which is done once and may take a minute\n"
    )
    monkeypatch.setattr(compilation, "_has_loops", lambda folder, but: True)
    errors.begin_run()
    with compilation.told("kernels", "the detection"):
        time.sleep(0.05)
    assert capsys.readouterr().err == ""


def test_loops_are_known_to_be_compiled(tmp_path, monkeypatch):
    folder = tmp_path / "kernels"
    beside, version = folder / "__pycache__", "py%d%d" % sys.version_info[:2]
    beside.mkdir(parents=True)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    (folder / "votes.py").write_text(
        "@micropython.viper\ndef vote(a: ptr8):\n    pass\n\n\n@njit(cache=True)\ndef count():\n    pass\n"
        '@njit(cache=True, inline="always")\ndef inlined():\n    pass\n'
    )
    (folder / "grey.py").write_text("@micropython.viper\ndef look():\n    pass\n")

    def compiled(but=()):
        return compilation._has_loops(folder, but)

    (beside / ("votes.vote-2.%s.nbi" % version)).write_bytes(b"")
    assert not compiled() and not compiled(["grey"])  # one of them is not all
    (beside / "votes.count-7.py99.nbi").write_bytes(b"")
    assert not compiled(["grey"])  # of another Python
    (beside / ("votes.count-7.%s.nbi" % version)).write_bytes(b"")
    assert compiled(["grey"]) and compiled(["grey.look"]) and not compiled()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    assert not compiled(["grey"])
    (tmp_path / "kept").mkdir()
    beside.rename(tmp_path / "kept" / "kernels_12")
    assert compiled(["grey"])


@pytest.mark.long(100)  # the first of all: the others find compiled what they need
def test_everything_is_compiled_at_once():
    pytest.importorskip("numba")
    code = """
import importlib, sys
from larics_host import compilation
compilation.compile_all()
for package in compilation.PACKAGES:
    name = "larics_host.render." if package == "render" else "larics.kernels."
    for source in compilation._folder(package).glob("*.py"):
        for loop in compilation.loops_of(source):
            if not getattr(importlib.import_module(name + source.stem), loop.split(".")[1]).signatures:
                print(loop)
"""
    environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    # CPython has faster ways to undo and check what is on the wire
    assert set(done.stdout.split()) == {"crc.cobs", "crc.crc32", "stream.unpack", "stream.unstuff"}


def test_all_is_compiled_once_and_again_when_the_text_changes(tmp_path, monkeypatch):
    pytest.importorskip("numba")
    done = []
    monkeypatch.setattr(compilation, "compile_all", lambda: done.append(True))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for name in compilation.PACKAGES:
        (tmp_path / "texts" / name).mkdir(parents=True)
    (tmp_path / "texts" / "kernels" / "votes.py").write_text("a = 1")
    monkeypatch.setattr(compilation, "_folder", lambda package: tmp_path / "texts" / package)
    compilation.compile_once()
    compilation.compile_once()
    assert len(done) == 1
    (tmp_path / "texts" / "kernels" / "votes.py").write_text("a = 2")
    compilation.compile_once()
    compilation.compile_once()
    assert len(done) == 2
    monkeypatch.setattr(_cpython, "EXECUTOR", "plain")
    (tmp_path / "all-loops.stamp").unlink()
    compilation.compile_once()
    assert len(done) == 2
