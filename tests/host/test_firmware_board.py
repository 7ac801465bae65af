"""Runs tests/board with a real MicroPython: tests of the firmware that need its heap or its modules."""

import re

import pytest

from tests.host.test_dual import ROOT, count_tests, run_dual

BOARD = ROOT / "tests" / "board"
MODULES = sorted(path.stem for path in BOARD.glob("test_*.py"))


def test_there_are_board_tests():
    assert MODULES


@pytest.mark.parametrize("module", MODULES)
def test_on_micropython(module):
    expected = count_tests(BOARD / (module + ".py"))
    result = run_dual(module, folder=BOARD)
    lines = result.stdout.splitlines() or [""]
    assert result.returncode == 0 and re.fullmatch(r"\d+ passed, 0 failed", lines[-1]), result.stdout
    assert expected and int(lines[-1].split()[0]) == expected, result.stdout
