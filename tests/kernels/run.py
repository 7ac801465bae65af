"""Runs kernels on generated inputs and prints what came out: `run.py MODULE...`, on any interpreter.

For each module of larics.kernels named, `cases_MODULE.py` holds CASES: kernel name -> function(random)
that yields tuples of arguments. Printed is one line a call: kernel, number of the call, its result, and
the CRC-32 of each buffer after it, written or not. Two interpreters agree when their lines do.

A kernel that raises prints a line with FAILED and the error, and the exit code is 1.

`run.py --dump MODULE.KERNEL NUMBER` prints the arguments of one call after it in full.
Under the strict executor a line `peak KERNEL VALUE` tells the largest intermediate of all its calls.
"""

import binascii
import sys

from inputs import Random

SEED = 20240


def load(module):
    """The cases and the kernels of a module of larics.kernels."""
    cases = __import__("cases_" + module).CASES
    package = __import__("larics.kernels." + module)
    return cases, getattr(package.kernels, module)


def calls(cases, name):
    return enumerate(cases[name](Random(SEED)))


def describe(value):
    return "" if isinstance(value, int) else " %08x" % binascii.crc32(value)


class Peak:
    """Records the largest intermediate value that the strict executor checked."""

    def __init__(self):
        self.value = 0
        self.active = False
        if sys.implementation.name != "cpython":
            return
        from larics import _cpython

        if _cpython.EXECUTOR == "strict":
            self.active = True
            self._checked = _cpython._checked
            _cpython._checked = self._record

    def _record(self, value):
        self.value = max(self.value, abs(value))
        return self._checked(value)


def run(module, peak):
    """Runs every kernel of a module; returns the number of those that raised."""
    cases, kernels = load(module)
    failed = 0
    for name in sorted(cases):
        path = module + "." + name
        peak.value = 0
        number = 0
        try:
            kernel = getattr(kernels, name)
            for number, arguments in calls(cases, name):
                result = kernel(*arguments)
                print("%s %d %s%s" % (path, number, result, "".join(map(describe, arguments))))
        except Exception as error:
            print("%s %d FAILED %s: %s" % (path, number, type(error).__name__, error))
            failed += 1
        if peak.active:
            print("peak %s %d" % (path, peak.value))
    return failed


def dump(path, wanted):
    module, name = path.split(".")
    cases, kernels = load(module)
    for number, arguments in calls(cases, name):
        if number == wanted:
            print("result", getattr(kernels, name)(*arguments))
            for position, value in enumerate(arguments):
                shown = value if isinstance(value, int) else list(memoryview(value))
                print("argument", position, shown)


if sys.argv[1] == "--dump":
    dump(sys.argv[2], int(sys.argv[3]))
else:
    watched = Peak()
    sys.exit(1 if sum([run(module, watched) for module in sys.argv[1:]]) else 0)
