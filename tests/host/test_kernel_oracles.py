"""Every kernel gives what it says: beside the comparison of executors, an oracle for what is right."""

import copy
import importlib
import sys

import pytest

from tests.host.test_kernels import CASES

sys.path.insert(0, str(CASES))

from inputs import Random  # noqa: E402
from oracles import ORACLES  # noqa: E402

SEED = 777


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
