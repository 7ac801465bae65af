"""The rules of the house hold, and their checker catches what breaks them."""

import os
import subprocess
import sys

import pytest

from tests.host.test_dual import ROOT
from tools import check_rules, make_tables

KERNEL = '''"""One kernel."""
try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8

_LIMIT = const(255)


@micropython.viper
def add(p: ptr8, q: ptr8, n: int) -> int:
    i = 0
    while i < n:
        p[i] = (int(p[i]) + int(q[i])) & 255
        i += 1
    return i
'''


def texts(name, source, **options):
    return [text for _, text in check_rules.check(name, source, **options)]


def test_the_tree_keeps_the_rules():
    violations, files = check_rules.check_tree()
    assert not violations, "\n".join(violations)
    assert files > 10


def test_tables_are_those_of_their_generator():
    assert make_tables.TARGET.read_text() == make_tables.source(), "run: python tools/make_tables.py"
    assert make_tables.C_TARGET.read_text() == make_tables.c_source(), "run: python tools/make_tables.py"


@pytest.mark.parametrize(
    "source, expected",
    [
        ("import math\n", "must not import math"),
        ("from os import path\n", "must not import os"),
        ("import larics_host.errors\n", "must not import larics_host.errors"),
        ("def f():\n    import time\n", "must not import time"),
        ("m = __import__('numpy')\n", "must not import numpy"),
        ("x = 0.5\n", "float literal 0.5"),
        ("x = 1e3\n", "float literal 1000.0"),
        ("x = 2j\n", "float literal 2j"),
        ("x = 1 / 2\n", "true division"),
        ("x = 1\nx /= 2\n", "true division"),
        ("x = float(3)\n", "use of float"),
    ],
)
def test_shared_code_is_integer_only_and_imports_little(source, expected):
    assert texts("shared/larics/arith/x.py", source) == [expected]


def test_what_shared_code_may_use():
    imports = "import array, struct\nimport binascii, micropython\nfrom ulab import numpy\n"
    source = imports + "from larics.arith import fixed\nx = 7 // 2\n"
    assert texts("shared/larics/arith/x.py", source) == []
    assert texts("shared/larics/_cpython.py", "import numba\nx = 1 / 2\n") == []


def test_firmware_and_host_do_not_import_each_other():
    assert texts("firmware/main.py", "from larics_host import cli\n") == ["must not import larics_host"]
    assert texts("firmware/main.py", "import machine\nfrom larics import detector\n") == []
    host = {"firmware_modules": {"loop", "cameras"}}
    assert texts("host/larics_host/x.py", "import loop\n", **host) == ["must not import loop"]
    assert texts("host/larics_host/x.py", "from cameras.replay import Replay\n", **host)
    assert texts("host/larics_host/x.py", "import importlib\nimportlib.import_module('loop')\n", **host)
    assert texts("host/larics_host/x.py", "import numpy\nfrom larics_host import loop\n", **host) == []


def test_a_good_kernel_passes():
    assert texts("shared/larics/kernels/x.py", KERNEL) == []


@pytest.mark.parametrize(
    "source, part",
    [
        ("def f():\n    pass\n", "nothing else"),
        ("@viper\ndef f(n: int):\n    pass\n", "nothing else"),
        ("TABLE = [1, 2]\n", "nothing else"),
        ("class A:\n    pass\n", "nothing else"),
        ("@micropython.viper\ndef f(a, b, c, d, e, f, g, h, i, j, k, l, m):\n    pass\n", "13 arguments"),
        ("@micropython.viper\ndef f(n: int = 3):\n    pass\n", "defaults"),
        ("@micropython.viper\ndef f(p: ptr8, n: int):\n    x = p[n]\n", "outside int()"),
        ("@micropython.viper\ndef f(p: ptr8, n: int):\n    p[n] += 1\n", "p[i] +="),
        ("@micropython.viper\ndef f(n: int):\n    x = abs(n)\n", "call of abs"),
        ("@micropython.viper\ndef f(n: int):\n    x = -n\n", "unary minus"),
        ("@micropython.viper\ndef f(n: int):\n    for i in range(n):\n        pass\n", "For in a kernel"),
    ],
)
def test_kernel_style_is_enforced(source, part):
    assert any(part in text for text in texts("shared/larics/kernels/x.py", source))


def test_copies_of_array_items_are_compared_with_their_definition():
    layouts = {"BIAS": 1 << 24, "FIT_AREA": 14}
    source = "_BIAS = const(1 << 24)\n_FIT_AREA = const(14)\n_FAR = const(3)\n"
    assert texts("shared/larics/direct/x.py", source, layouts=layouts) == []
    source = "_BIAS = const(1 << 20)\n_FIT_AREA = const(13)\n_FIT_AERA = const(14)\nFIT_AREA = const(15)\n"
    assert texts("shared/larics/kernels/x.py", source, layouts=layouts) == [
        "_BIAS is 1048576, but 16777216 in layouts.py",
        "_FIT_AREA is 13, but 14 in layouts.py",
        "_FIT_AERA is no item in layouts.py",
        "FIT_AREA is 15, but 14 in layouts.py",
    ]


OF_BLOCKS = {"ROBUST"}  # arrays whose items are the first ones of whole blocks


def test_array_items_are_defined_once_and_none_is_left_out():
    layouts = check_rules.layouts_of()
    for array in {name.split("_")[0] for name in layouts if "_" in name}:
        items = [layouts[name] for name in layouts if name.startswith(array + "_")]
        if array in OF_BLOCKS:
            assert items == sorted(set(items)) and items[0] == 0, array
        else:
            assert sorted(items) == list(range(len(items))), array  # the last is the array's own length


def test_the_init_of_kernels_is_free_but_integer():
    assert texts("shared/larics/kernels/__init__.py", "def f():\n    pass\n") == []
    assert texts("shared/larics/kernels/__init__.py", "x = 0.1\n") == ["float literal 0.1"]


def test_a_violation_in_a_tree_is_reported_with_its_place(tmp_path):
    for folder in ("shared/larics/arith", "firmware/cameras", "host/larics_host"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "firmware/loop.py").write_text("import gc\n")
    (tmp_path / "firmware/cameras/__init__.py").write_text("")
    (tmp_path / "host/larics_host/a.py").write_text("import numpy\n\nimport loop\n")
    (tmp_path / "host/larics_host/b.py").write_text("import cameras\n")
    (tmp_path / "shared/larics/arith/c.py").write_text("x = 3 / 4\n")
    violations, files = check_rules.check_tree(tmp_path)
    assert violations == [
        "shared/larics/arith/c.py:1: true division",
        "host/larics_host/a.py:3: must not import loop",
        "host/larics_host/b.py:1: must not import cameras",
    ]
    assert files == 5


@pytest.mark.parametrize(
    "source, expected",
    [
        ("def f(x: int):\n    pass\n", ["f lacks type annotations"]),
        ("def f(x, y: int) -> int:\n    return x\n", ["f lacks type annotations"]),
        ("def f(*x: int, **y) -> None:\n    pass\n", ["f lacks type annotations"]),
        ("class A:\n    def __init__(self):\n        pass\n", ["A.__init__ lacks type annotations"]),
        (
            "if x:\n    def f():\n        pass\n",
            ["f lacks type annotations"],
        ),
        ("class A:\n    def __init__(self, x: int) -> None:\n        def g(y):\n            pass\n", []),
        ("class _A:\n    def f(self):\n        pass\n", []),
        ("def _f(x):\n    pass\n", []),
    ],
)
def test_public_functions_of_the_host_are_annotated(source, expected):
    assert texts("host/larics_host/x.py", source) == expected
    assert texts("firmware/x.py", source) == []


def test_a_folder_named_micropython_on_the_path_changes_nothing(tmp_path):
    (tmp_path / "micropython").mkdir()
    code = (
        "import importlib, pkgutil, larics, larics_vehicle\n"
        "for package in (larics, larics_vehicle):\n"
        "    for module in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):\n"
        "        importlib.import_module(module.name)\n"
    )
    path = os.pathsep.join([str(tmp_path), str(ROOT / "shared")])
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, env=dict(os.environ, PYTHONPATH=path), capture_output=True, text=True)
    assert result.returncode == 0, result.stderr[-2000:]
