"""Every kernel gives what it says: beside the comparison of executors, an oracle for what is right."""

import copy
import importlib
import sys

import pytest

from tests.host.test_kernels import ALL, CASES, ROOT

sys.path.insert(0, str(CASES))

from inputs import Random  # noqa: E402
from oracles import ORACLES  # noqa: E402

SEED = 777
# kernels that are held against their definition, drawn markers or a library elsewhere
ELSEWHERE = {
    "rings.ring_crossings": "tests/host/test_kernels_on_markers.py",
    "lines": "tests/host/test_kernels_on_markers.py",
    "code": "tests/host/test_kernels_on_markers.py",
    "rules": "tests/dual/test_direct_acceptance.py",
    "code_rules.code_rules": "tests/dual/test_code_acceptance.py",
    "robust": "tests/host/test_robust_centre.py",
    "crc": "tests/dual/test_protocol.py",
    "odometry": "tests/dual/test_odometry.py",
    "covariance": "tests/dual/test_carried_limits.py",
    "rolling": "tests/host/test_rolling.py",
    "paper": "tests/host/test_paper.py",
    "raw": "tests/host/test_raw_frame.py",
    "cells": "tests/dual/test_cells.py",
    "cell_search": "tests/dual/test_cell_words.py",
    "cell_strokes": "tests/dual/test_cell_strokes.py",
    "evidence": "tests/dual/test_evidence.py",
    "cell_words": "tests/dual/test_cell_words.py",
}


def test_every_kernel_has_an_oracle():
    elsewhere = {name for name in ALL if name in ELSEWHERE or name.split(".")[0] in ELSEWHERE}
    assert sorted(elsewhere | set(ORACLES)) == ALL
    assert all((ROOT / path).is_file() for path in ELSEWHERE.values())


@pytest.mark.parametrize("name", sorted(ORACLES))
def test_kernel_is_right(name):
    module, function = name.split(".")
    kernel = getattr(importlib.import_module("larics.kernels." + module), function)
    calls = 0
    for arguments in importlib.import_module("cases_" + module).CASES[function](Random(SEED)):
        before = tuple(copy.copy(argument) for argument in arguments)
        result = kernel(*arguments)
        ORACLES[name](before, arguments, result)
        calls += 1
    assert calls >= 3
