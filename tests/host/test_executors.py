"""The stand-ins for viper on CPython: what they refuse, and what they do as a board would."""

import importlib.util
import os
import pathlib
import subprocess
import sys
from array import array

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCE = ROOT / "shared" / "larics" / "_cpython.py"
INT32 = st.integers(-0x80000000, 0x7FFFFFFF)


def stand_in(executor, name="stand_in"):
    """A fresh copy of larics._cpython with the executor chosen by LARICS_KERNELS."""
    before = os.environ.pop("LARICS_KERNELS", None)
    if executor is not None:
        os.environ["LARICS_KERNELS"] = executor
    try:
        spec = importlib.util.spec_from_file_location(name, SOURCE)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    finally:
        os.environ.pop("LARICS_KERNELS", None)
        if before is not None:
            os.environ["LARICS_KERNELS"] = before


STRICT = stand_in("strict")
PLAIN = stand_in("plain")


def kernel(module, *kinds):
    """Compiles a function for a stand-in: `kinds` are the annotations of its arguments."""

    def decorate(function):
        names = function.__code__.co_varnames[: function.__code__.co_argcount]
        function.__annotations__ = dict(zip(names, kinds, strict=True))
        return module.micropython.viper(function)

    return decorate


def strict(function, *values):
    """The result of an arithmetic function of int arguments under the strict executor."""
    return kernel(STRICT, *[int] * len(values))(function)(*values)


ARITHMETIC = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "&": lambda a, b: a & b,
    "|": lambda a, b: a | b,
    "^": lambda a, b: a ^ b,
}


@pytest.mark.parametrize("symbol", sorted(ARITHMETIC))
@given(a=INT32, b=INT32)
def test_strict_arithmetic_is_exact_or_raises(symbol, a, b):
    exact = ARITHMETIC[symbol](a, b)
    if -0x80000000 <= exact <= 0x7FFFFFFF:
        assert strict(ARITHMETIC[symbol], a, b) == exact
    else:
        with pytest.raises(OverflowError, match="does not fit int32"):
            strict(ARITHMETIC[symbol], a, b)


@given(a=INT32, b=INT32.filter(bool))
def test_strict_division_floors(a, b):
    if (a, b) == (-0x80000000, -1):
        return
    assert strict(lambda a, b: a // b, a, b) == a // b
    assert strict(lambda a, b: a % b, a, b) == a % b


@given(value=INT32, count=st.integers(-40, 40))
def test_strict_shifts(value, count):
    if not 0 <= count < 32:
        with pytest.raises(OverflowError, match="shift count"):
            strict(lambda a, n: a << n, value, count)
        with pytest.raises(OverflowError, match="shift count"):
            strict(lambda a, n: a >> n, value, count)
        return
    assert strict(lambda a, n: a >> n, value, count) == value >> count
    if -0x80000000 <= value << count <= 0x7FFFFFFF:
        assert strict(lambda a, n: a << n, value, count) == value << count
    else:
        with pytest.raises(OverflowError, match="does not fit int32"):
            strict(lambda a, n: a << n, value, count)


def test_strict_checks_constants_on_either_side_and_loads():
    overflowing = [
        (int, lambda n: 0x7FFFFFFF + n, 1),
        (int, lambda n: 0 - 0x7FFFFFFF - n, 2),
        (int, lambda n: 65536 * n, 32768),
        (int, lambda n: 1 << n, 31),
        (int, lambda n: n, 0x80000000),
        (STRICT.ptr8, lambda p: int(p[0]) * 0x1000000, b"\x80"),
        (STRICT.ptr16, lambda p: int(p[0]) * 32769, array("H", [65535])),
    ]
    for kind, function, value in overflowing:
        with pytest.raises(OverflowError):
            kernel(STRICT, kind)(function)(value)


def test_a_negative_value_from_ptr32_needs_a_mask():
    """32-bit boards load it signed, 64-bit ones unsigned."""
    items = array("i", [-5])
    for function in (
        lambda p: int(p[0]) + 1,
        lambda p: 1 - int(p[0]),
        lambda p: int(p[0]) >> 1,
        lambda p: 1 if int(p[0]) < 0 else 0,
        lambda p: 1 if int(p[0]) == 3 else 0,
        lambda p: int(p[0]),
        lambda p: int(p[0]) & 0x7FFFFFFF,
    ):
        with pytest.raises(OverflowError):
            kernel(STRICT, STRICT.ptr32)(function)(items)
    extended = kernel(STRICT, STRICT.ptr32)(lambda p: ((int(p[0]) & 0x3FFFFFFF) ^ 0x20000000) - 0x20000000)
    assert extended(items) == -5
    assert kernel(STRICT, STRICT.ptr32)(lambda p: int(p[0]) + 1)(array("i", [41])) == 42


@pytest.mark.parametrize("module", [STRICT, PLAIN], ids=["strict", "plain"])
@pytest.mark.parametrize("index", [-1, 3, 1 << 20])
def test_no_access_outside_a_buffer(module, index):
    def store(p, i):
        p[i] = 1

    for kind, buffer in (
        (module.ptr8, bytearray(3)),
        (module.ptr16, array("H", [0] * 3)),
        (module.ptr32, array("i", [0] * 3)),
    ):
        with pytest.raises(IndexError):
            kernel(module, kind, int)(lambda p, i: int(p[i]))(buffer, index)
        with pytest.raises(IndexError):
            kernel(module, kind, int)(store)(buffer, index)


@pytest.mark.parametrize("module", [STRICT, PLAIN], ids=["strict", "plain"])
def test_stores_keep_the_low_bits_and_small_loads_are_unsigned(module):
    def store(p, value):
        p[1] = value

    for kind, buffer, value, stored in (
        (module.ptr8, bytearray(2), 0x1234, 0x34),
        (module.ptr8, bytearray(2), -1, 0xFF),
        (module.ptr16, array("H", [0, 0]), 0x12345, 0x2345),
        (module.ptr16, array("H", [0, 0]), -2, 0xFFFE),
        (module.ptr32, array("i", [0, 0]), -3, -3),
        (module.ptr32, array("i", [0, 0]), 0x7FFFFFFF, 0x7FFFFFFF),
    ):
        kernel(module, kind, int)(store)(buffer, value)
        assert list(buffer) == [0, stored]
        if stored >= 0:
            assert kernel(module, kind)(lambda p: int(p[1]))(buffer) == stored


@pytest.mark.parametrize("module", [STRICT, PLAIN], ids=["strict", "plain"])
def test_items_must_have_the_size_of_the_pointer(module):
    for kind, buffer in (
        (module.ptr8, array("H", [0])),
        (module.ptr16, bytearray(4)),
        (module.ptr16, array("i", [0])),
        (module.ptr32, bytearray(4)),
        (module.ptr32, array("H", [0])),
    ):
        with pytest.raises(TypeError, match="-byte items given for ptr"):
            kernel(module, kind)(lambda p: int(p[0]))(buffer)


@pytest.mark.parametrize("module", [STRICT, PLAIN], ids=["strict", "plain"])
def test_the_number_of_arguments_counts(module):
    with pytest.raises(TypeError, match="takes 2 arguments, not 1"):
        kernel(module, int, int)(lambda a, b: a + b)(1)


@given(a=st.integers(-(2**60), 2**60))
def test_plain_does_not_check(a):
    assert kernel(PLAIN, int)(lambda a: a + a)(a) == 2 * a


def test_the_executor_is_chosen_by_the_environment(monkeypatch):
    assert stand_in("strict").EXECUTOR == "strict"
    assert stand_in("plain").EXECUTOR == "plain"
    assert stand_in("numba").EXECUTOR == "numba"
    assert stand_in(None).EXECUTOR == "numba"
    assert stand_in("").EXECUTOR == "numba"
    monkeypatch.setitem(sys.modules, "numba", None)
    assert stand_in(None).EXECUTOR == "plain"
    with pytest.raises(ImportError, match="numba is not installed"):
        stand_in("numba")


def test_an_unknown_executor_is_named():
    process = subprocess.run(
        [sys.executable, "-c", "import larics.arith.fixed"],
        cwd=ROOT,
        env=dict(os.environ, PYTHONPATH="shared", LARICS_KERNELS="bad"),
        capture_output=True,
        text=True,
    )
    assert process.returncode == 1
    assert "LARICS_KERNELS=bad is unknown; use one of numba, plain, strict" in process.stderr


@pytest.mark.parametrize("executor", ["numba", "plain", "strict"])
def test_frame_view_takes_any_buffer_of_pixels(executor):
    module = stand_in(executor)
    frame = np.arange(12, dtype=np.uint8).reshape(3, 4)
    for buffer in (
        frame,
        frame.tobytes(),
        bytearray(frame.tobytes()),
        memoryview(frame),
        array("B", range(12)),
    ):
        view = module.frame_view(buffer)
        assert len(view) == 12 and bytes(view) == frame.tobytes()
    assert len(module.frame_view(b"")) == 0
    for bad in (frame[:, ::2], frame.T, frame.astype(np.uint16), array("H", [1])):
        with pytest.raises(ValueError, match="contiguous buffer of 8-bit pixels"):
            module.frame_view(bad)
