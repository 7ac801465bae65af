"""The program on an emulated Cortex-M7: a dual module, and the whole firmware from start to answers.

    EMULATED_BOARD=/path/to/firmware.elf make test TEST=tests/host/test_emulated_board.py

The firmware is of MicroPython's QEMU port, see tools/board_memory.py; with a heap of 256 KiB nothing must be
left out that fits there."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.host.test_dual import DUAL, ROOT
from tools import board_memory

FIRMWARE = os.environ.get("EMULATED_BOARD", "")


@pytest.fixture(scope="module")
def firmware():
    if not FIRMWARE:
        pytest.skip("EMULATED_BOARD names no firmware.elf of MicroPython's QEMU port")
    if not shutil.which("qemu-system-arm"):
        pytest.skip("qemu-system-arm is not installed")
    assert Path(FIRMWARE).is_file(), "EMULATED_BOARD=%s is no file" % FIRMWARE
    return FIRMWARE


def test_a_dual_module_passes_on_it(firmware):
    command = [sys.executable, "tools/run_on_board.py", "--qemu", firmware, "tests/dual/run.py", "test_fixed"]
    search = "shared:%s:.frozen" % DUAL
    done = subprocess.run(
        command, cwd=ROOT, env=dict(os.environ, MICROPYPATH=search), capture_output=True, text=True
    )
    assert done.returncode == 0 and " passed" in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize(
    "in_place, commands, least_free",
    ((True, ("margin_min=30", "SAVE", "RAW"), 44 << 10), (False, ("SAVE", "RAW"), 8 << 10)),
)
def test_the_whole_firmware_runs_and_answers(firmware, in_place, commands, least_free):
    rows, messages = board_memory.measure(firmware, True, in_place, commands)
    assert [row[0] for row in rows] == ["ready", "frames", *commands]
    assert [row[4] for row in rows[:-1]] == [0, 50] + [board_memory.STEPS] * (len(commands) - 1)
    assert all(whole for *_, whole, _ in rows), "some of the detector was left out"
    assert all(free > least_free for _, _, free, *_ in rows)
    kinds = [message.name for message in messages]
    assert kinds.count("ACK") == len(commands) and "NACK" not in kinds and "RAW_CHUNK" in kinds
    read = {message.fields.id for message in messages if message.name == "MARKER" and message.fields.count}
    assert len(read) > 4 and max(read) > 7, "plain and coded markers"
