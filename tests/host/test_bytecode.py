"""Compiled files whose names are each there once: on a real interpreter they do what they did."""

import subprocess

import pytest

from larics_host.flash import build, bytecode, mpy_file
from tests.host.test_dual import unix_port
from tests.host.test_linker import own_architecture

MANY = 150  # names: more than fit into one byte
PROGRAM = """
import sys


class Wheel:
    def __init__(self, radius, width=3):
        self.radius = radius
        self.width = width

    def turns(self, way):
        found = []
        while way > 0:
            for part in range(40):
                if part == 7:
                    break
                try:
                    if way == 12:
                        continue
                    found.append(way // (part - 2))
                except ZeroDivisionError:
                    found.append(None)
                finally:
                    found.append(part)
            way -= self.radius
%s
        return found

    def sum_with(self, number):
        return lambda more: number + more + self.width


def told():
    wheel = Wheel(5, width=4)
    names = [n for n in globals() if n.startswith("v")]
    return wheel.turns(27), wheel.sum_with(2)(3), len(names), [Wheel.__name__, repr(wheel)[:2]]


print(told())
try:
    v149 = Wheel(0).w149
except AttributeError as error:
    sys.print_exception(error, sys.stdout)
"""
LONG = "".join("            self.w%d = way if way & 1 or way > 3 else 2\n" % n for n in range(MANY))


def compiled(shared, has_lines):
    text = PROGRAM % LONG + "".join("v%d = 1\nprint(v%d)\n" % (n, n) for n in range(MANY))
    [(_, data)] = build.compile_texts({"wheel.mpy": text}, own_architecture(), () if has_lines else ("-O3",))
    file = mpy_file.MpyFile(data)
    file.names = [shared.get(name, name) for name in file.names]
    return file


def printed(folder, file):
    (folder / "wheel.mpy").write_bytes(file.result())
    command = [*unix_port(), "-c", "import sys; sys.path[:] = [%r]; import wheel" % str(folder)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("has_lines", [False, True])
def test_code_with_names_once_does_the_same(tmp_path, has_lines):
    shared = {"w%d" % n: "w%d" % (n % 9) for n in range(MANY)}
    file = compiled(shared, has_lines)
    before, size = printed(tmp_path, file), len(file.result())
    names = len(file.names)
    assert names > len(set(file.names)) > 128
    bytecode.share_names(file, has_lines)
    assert len(file.names) == len(set(file.names)) < names - 100
    assert printed(tmp_path, file) == before and before.count("1\n") == MANY
    assert len(file.result()) < size - 500
    assert (", line 1," in before) != has_lines  # else the lines are told, and rightly


def test_machine_code_stays():
    text = "import micropython\n\n\n@micropython.viper\ndef f(a: int) -> int:\n    return a\n"
    [(_, data)] = build.compile_texts({"kernel.mpy": text}, own_architecture())
    file = mpy_file.MpyFile(data)
    bytecode.share_names(file, False)
    assert file.result() == data
