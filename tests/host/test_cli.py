"""The frame around the sub-commands: help, version, exit codes, one line for bad input."""

import os
import pathlib
import re
import subprocess
import sys
import types

import pytest

from larics import __version__
from larics_host import cli
from larics_host.errors import UserError
from tests.host.waiting import PATIENCE_S

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def command(monkeypatch):
    """Makes a function the only sub-command: `larics fake`."""

    def install(run):
        module = types.SimpleNamespace(
            NAME="fake", HELP="nothing", EXAMPLE="larics fake", add_arguments=lambda parser: None, run=run
        )
        monkeypatch.setattr(cli, "COMMANDS", ("fake",))
        monkeypatch.setattr(cli.importlib, "import_module", lambda name: module)

    return install


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_command_has_help_with_an_example(name, capsys):
    with pytest.raises(SystemExit) as end:
        cli.main([name, "--help"])
    assert end.value.code == 0
    printed = capsys.readouterr().out
    assert "example:\n  larics %s" % name in printed


def test_help_lists_every_command(capsys):
    with pytest.raises(SystemExit) as end:
        cli.main(["--help"])
    assert end.value.code == 0
    printed = capsys.readouterr().out
    assert all(re.search(r"\n    %s\s" % name, printed) for name in cli.COMMANDS)


def test_version(capsys):
    with pytest.raises(SystemExit):
        cli.main(["--version"])
    assert capsys.readouterr().out.strip() == "larics " + __version__


@pytest.mark.parametrize("argv", [[], ["nonsense"], ["marker"], ["marker", "3", "-o"], ["--wrong"]])
def test_wrong_usage_is_one_line(argv, capsys):
    assert cli.main(argv) == 2
    said = capsys.readouterr().err
    assert said.startswith("larics: ") and said.count("\n") == 1 and "--help" in said


def test_user_error_is_one_line_and_2(command, capsys):
    def run(args):
        raise UserError("no frames in x:\ngive another folder")

    command(run)
    assert cli.main(["fake"]) == 2
    assert capsys.readouterr().err == "larics: no frames in x: give another folder\n"


def test_an_operating_system_error_is_one_line_and_2(command, capsys):
    command(lambda args: pathlib.Path("/nowhere/at/all").read_bytes())
    assert cli.main(["fake"]) == 2
    assert capsys.readouterr().err == "larics: /nowhere/at/all: No such file or directory\n"


def test_exit_code_of_the_command_is_kept(command):
    command(lambda args: 3)
    assert cli.main(["fake"]) == 3
    command(lambda args: None)
    assert cli.main(["fake"]) == 0


def test_interrupt_is_quiet(command, capsys):
    def run(args):
        raise KeyboardInterrupt

    command(run)
    assert cli.main(["fake"]) == 130
    assert capsys.readouterr().err == ""


def test_a_missing_package_hurts_only_its_command(command, monkeypatch, capsys):
    command(lambda args: 0)
    fake = cli.importlib.import_module("fake")

    def import_module(name):
        if name.endswith(".plot"):
            raise ModuleNotFoundError("No module named 'matplotlib.pyplot'", name="matplotlib.pyplot")
        return fake

    monkeypatch.setattr(cli, "COMMANDS", ("fake", "plot"))
    monkeypatch.setattr(cli.importlib, "import_module", import_module)
    assert cli.main(["fake"]) == 0
    assert cli.main(["plot"]) == 2
    assert 'pip install "larics[plot]"' in capsys.readouterr().err
    with pytest.raises(SystemExit) as end:
        cli.main(["--help"])
    assert end.value.code == 0


def test_a_bug_in_our_own_imports_is_not_hidden(command, monkeypatch):
    def import_module(name):
        raise ModuleNotFoundError("No module named 'larics_host.nowhere'", name="larics_host.nowhere")

    command(None)
    monkeypatch.setattr(cli.importlib, "import_module", import_module)
    with pytest.raises(ModuleNotFoundError):
        cli.main(["fake"])


def test_as_a_module_with_a_reader_that_leaves():
    search = os.pathsep.join(str(ROOT / name) for name in ("shared", "host"))
    process = subprocess.Popen(
        [sys.executable, "-m", "larics_host", "--version"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=dict(os.environ, PYTHONPATH=search),
        text=True,
    )
    assert process.communicate(timeout=PATIENCE_S) == ("larics %s\n" % __version__, "")
    assert process.returncode == 0


def test_broken_pipe_is_quiet():
    search = os.pathsep.join(str(ROOT / name) for name in ("shared", "host"))
    code = (
        "import sys, types\n"
        "from larics_host import cli\n"
        "def run(args):\n"
        "    for _ in range(100000):\n"
        "        print('x' * 100)\n"
        "nothing = lambda parser: None\n"
        "fake = types.SimpleNamespace(NAME='fake', HELP='', EXAMPLE='', add_arguments=nothing, run=run)\n"
        "cli.COMMANDS = ('fake',)\n"
        "cli._load = lambda name: fake\n"
        "sys.exit(cli.main(['fake']))\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=dict(os.environ, PYTHONPATH=search),
    )
    process.stdout.readline()
    process.stdout.close()
    said = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=PATIENCE_S) == 141 and said == b""


def test_a_package_that_is_missing_while_a_command_runs_is_one_line(command, capsys):
    def run(args):
        raise ModuleNotFoundError("No module named 'nowhere.part'", name="nowhere.part")

    command(run)
    assert cli.main(["fake"]) == 2
    assert capsys.readouterr().err == "larics: this needs the Python package nowhere: pip install nowhere\n"


@pytest.mark.parametrize("encoding", ["ascii", "utf-8"])
def test_names_that_the_terminal_cannot_show_are_printed_escaped(encoding, tmp_path):
    frame = ROOT / "tests" / "frames" / "sunny_r30_1000_0.pgm"
    name = os.fsencode(tmp_path) + b"/\xc5\xbe\xff.pgm"
    with open(name, "wb") as file:
        file.write(frame.read_bytes())
    done = subprocess.run(
        [sys.executable, "-m", "larics_host", "detect", name],
        env=dict(os.environ, PYTHONPATH="shared:host", PYTHONIOENCODING=encoding),
        cwd=ROOT,
        capture_output=True,
    )
    assert done.returncode == 0 and b"\\udcff.pgm" in done.stdout and not done.stderr
