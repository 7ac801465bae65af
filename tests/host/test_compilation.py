"""Compiled loops are kept where that is possible; nothing fails where it is not, and waiting is explained."""

import json
import os
import shutil
import subprocess
import sys
import threading

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
    numba = pytest.importorskip("numba")
    monkeypatch.setattr(compilation, "_PATIENCE_S", 0)
    monkeypatch.setattr(_cpython, "EXECUTOR", "numba")
    told = threading.Event()
    report_once = compilation.report_once
    monkeypatch.setattr(compilation, "report_once", lambda *line: (report_once(*line), told.set()))
    for kept, once in (True, "is done once and "), (False, ""):
        monkeypatch.setattr(_cpython, "KEEPS_COMPILED", kept)
        errors.begin_run()
        one_more = numba.njit(lambda value: value + 1)
        with compilation.told("the detection"):
            assert one_more(1) == 2 and told.wait(60)
        line = "larics: compiling the detection for this computer, which %smay take a minute\n" % once
        assert capsys.readouterr().err == line
        errors.begin_run()
        told.clear()
        timers = threading.active_count()
        with compilation.told("the detection"):  # it is compiled: no clock runs
            assert one_more(1) == 2 and threading.active_count() == timers
        assert not told.is_set() and capsys.readouterr().err == ""


def test_who_waits_is_told_although_loops_of_an_older_text_are_there(tmp_path):
    pytest.importorskip("numba")
    module = tmp_path / "one.py"
    text = "from numba import njit\n\n\n@njit(cache=True)\ndef loop(value):\n    return value + %d\n"
    code = """
import sys, threading
sys.path.insert(0, %r)
from larics_host import compilation
told = threading.Event()
compilation._PATIENCE_S = 0
compilation.report_once = lambda about, text: told.set()
import one
with compilation.told("a loop"):
    print(one.loop(1), told.wait(60 * %d))
"""
    environment = dict(
        os.environ,
        PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"),
        NUMBA_CACHE_DIR=str(tmp_path / "kept"),
        PYTHONDONTWRITEBYTECODE="1",
    )
    environment.pop("LARICS_KERNELS", None)

    def run(patient):
        command = [sys.executable, "-c", code % (str(tmp_path), patient)]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    module.write_text(text % 1)
    assert run(True) == "2 True\n" and run(False) == "2 False\n"
    module.write_text(text % 2)
    assert run(True) == "3 True\n"


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
