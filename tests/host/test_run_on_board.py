"""tools/run_on_board.py: a script on a board's line runs as under the unix binary (a stand-in board here)."""

import os
import subprocess
import sys

import pytest

from larics_host.connection.pty_pair import PtyPair
from tests.host.test_dual import ROOT, unix_port
from tests.host.waiting import PATIENCE_S, wait_until

SCRIPT = """import sys
import lent_module
from larics.arith.fixed import isqrt

with open(sys.argv[1].partition("@")[0], "rb") as file:
    print(len(file.read()), sys.argv[1].partition("@")[2], sys.argv[2], isqrt(lent_module.NUMBER))
%s
"""


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    """The device at which a real interpreter serves the raw REPL."""
    image = str(tmp_path_factory.mktemp("flash") / "flash.img")
    with PtyPair() as cable:
        line = os.open(cable.device_a, os.O_RDWR | os.O_NOCTTY)
        process = subprocess.Popen(
            [*unix_port(), "tests/board/fake_board.py", image, "OMVRT1060 32768 SDRAM"],
            cwd=ROOT, stdin=line, stdout=line, stderr=line, env=dict(os.environ, MICROPYPATH=".frozen"),
        )  # fmt: skip
        yield cable.device_b
        process.kill()
        process.wait()
        os.close(line)


def run(board, tmp_path, last, name="frame.raw"):
    (tmp_path / "lent").mkdir()
    (tmp_path / "lent/lent_module.py").write_text("NUMBER = 144\n")
    (tmp_path / "script.py").write_text(SCRIPT % last)
    (tmp_path / "frame.raw").write_bytes(bytes(5000))
    command = [sys.executable, "tools/run_on_board.py", "--port", board, "--march", "x64"]
    return subprocess.run(
        [*command, tmp_path / "script.py", str(tmp_path / name) + "@1,2", "word"],
        cwd=ROOT,
        env=dict(os.environ, MICROPYPATH="shared:%s:.frozen" % (tmp_path / "lent")),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )


def test_modules_and_files_are_lent_and_the_exit_code_comes_back(board, tmp_path):
    done = run(board, tmp_path, "sys.exit(3)")
    assert (done.stdout, done.returncode) == ("5000 1,2 word 12\n", 3), done.stderr


def test_a_script_that_ends_well_exits_with_0(board, tmp_path):
    assert run(board, tmp_path, "").returncode == 0


def test_an_exception_is_shown_and_exits_with_1(board, tmp_path):
    done = run(board, tmp_path, "raise ValueError('a reason')")
    assert done.returncode == 1 and "ValueError: a reason" in done.stdout


@pytest.mark.parametrize(
    "options, said",
    [
        (["--port", "/dev/no-such-port", "tools/run_on_board.py"], "/dev/no-such-port"),
        (["--qemu", "no.elf", "tools/run_on_board.py"], "no firmware no.elf"),
        (["--port", "x", "no_script.py"], "no script no_script.py"),
    ],
)
def test_what_cannot_be_run_is_told_in_one_line(options, said):
    done = subprocess.run(
        [sys.executable, "tools/run_on_board.py", *options], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 1 and said in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="the emulator's end with its parent is Linux's")
def test_a_runner_that_is_killed_leaves_no_emulator(tmp_path):
    emulator, told = tmp_path / "qemu-system-arm", tmp_path / "pid"
    emulator.write_text("#!/bin/sh\necho $$ > %s.new\nmv %s.new %s\nexec sleep 600\n" % (told, told, told))
    emulator.chmod(0o755)
    runner = subprocess.Popen(
        [sys.executable, "tools/run_on_board.py", "--qemu", emulator, "tools/run_on_board.py"],
        cwd=ROOT,
        env=dict(os.environ, PATH="%s:%s" % (tmp_path, os.environ["PATH"]), MICROPYPATH=""),
    )
    wait_until(told.exists)
    runner.kill()
    runner.wait()
    wait_until(lambda: not is_running(int(told.read_text())))


def is_running(number):
    """Whether the process has not ended yet."""
    try:
        with open("/proc/%d/stat" % number) as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
