"""Runs tests/dual with a real MicroPython interpreter; pytest itself runs the same files on CPython."""

import ast
import os
import pathlib
import re
import shlex
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DUAL = ROOT / "tests" / "dual"
MODULES = sorted(path.stem for path in DUAL.glob("test_*.py"))


def interpreter():
    """The command line in front of the script: $MICROPYTHON may be a path or a runner with arguments."""
    command = shlex.split(os.environ.get("MICROPYTHON", "")) or [".venv/bin/micropython"]
    found = shutil.which(command[0], path=os.pathsep.join([os.environ.get("PATH", ""), str(ROOT)]))
    if not found and (ROOT / command[0]).is_file():
        found = str(ROOT / command[0])
    if not found:
        pytest.fail("no MicroPython at %s: run `make setup` or set MICROPYTHON" % command[0])
    return [found, *command[1:]]


def unix_port():
    """The interpreter for what runs as a program of this computer; a runner for boards is none."""
    command = interpreter()
    return command if len(command) == 1 else [str(ROOT / ".venv/bin/micropython")]


def heap(command, folder):
    """Options of the unix port: room for the data of tests/dual; for tests/board what 64-bit ones have, since
    32-bit ones have half of it, too little for the bytes that the tests collect. A board keeps its own."""
    size = "heapsize=16M" if folder == DUAL else "heapsize=2M"
    return ["-X", size] if pathlib.Path(command[-1]).name == "micropython" else []


def run_dual(*modules, folder=DUAL):
    search = ["shared", "firmware", str(folder), str(DUAL), ".frozen"]
    command = interpreter() if folder == DUAL else unix_port()
    return subprocess.run(
        [*command, *heap(command, folder), str(DUAL / "run.py"), *modules],
        cwd=ROOT,
        env=dict(os.environ, MICROPYPATH=":".join(search)),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300 if len(command) == 1 else 3000,  # an emulated board is a hundred times slower
    )


def count_tests(path):
    tree = ast.parse(path.read_text())
    return sum(isinstance(node, ast.FunctionDef) and node.name.startswith("test_") for node in tree.body)


def test_there_are_dual_tests():
    assert MODULES


@pytest.mark.parametrize("module", MODULES)
def test_on_micropython(module):
    expected = count_tests(DUAL / (module + ".py"))
    assert expected, "%s.py holds no test" % module
    result = run_dual(module)
    lines = result.stdout.splitlines() or [""]
    assert result.returncode == 0 and re.fullmatch(r"\d+ passed, 0 failed", lines[-1]), result.stdout
    assert int(lines[-1].split()[0]) == expected, result.stdout


def test_a_failing_test_is_reported(tmp_path):
    (tmp_path / "test_bad.py").write_text(
        "def test_good():\n    assert True\ndef test_wrong():\n    assert 1 + 1 == 3\n"
    )
    result = run_dual("test_bad", folder=tmp_path)
    assert result.returncode == 1
    assert "FAILED test_bad.test_wrong" in result.stdout and "AssertionError" in result.stdout
    assert "line 4" in result.stdout
    assert result.stdout.splitlines()[-1] == "1 passed, 1 failed"


@pytest.mark.parametrize(
    "source, last", [("x = 1\n", "0 passed, 0 failed"), ("import nowhere\n", "0 passed, 1 failed")]
)
def test_a_module_without_tests_or_that_does_not_import_fails(tmp_path, source, last):
    (tmp_path / "test_empty.py").write_text(source)
    result = run_dual("test_empty", folder=tmp_path)
    assert result.returncode == 1
    assert result.stdout.splitlines()[-1] == last


def test_no_module_at_all_fails():
    assert run_dual().returncode == 1


def test_the_interpreter_may_be_a_runner_with_arguments(monkeypatch):
    plain = shlex.join(interpreter())
    monkeypatch.setenv("MICROPYTHON", "env LARICS_RUNNER=1 " + plain)
    assert interpreter()[1:] == ["LARICS_RUNNER=1", *shlex.split(plain)]
    assert run_dual("test_marker").returncode == 0


def test_a_missing_interpreter_fails_instead_of_passing(monkeypatch):
    monkeypatch.setenv("MICROPYTHON", "no-such-interpreter")
    with pytest.raises(pytest.fail.Exception, match="no MicroPython at no-such-interpreter"):
        interpreter()
