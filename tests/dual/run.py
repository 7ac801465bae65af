"""Runs test modules under MicroPython: `micropython tests/dual/run.py test_fixed [test_marker...]`.

Every function test_* of each module is called. Each failure is printed with its traceback; the last
line counts, and the exit code is 1 on a failure or when not one test ran.
"""

import gc
import sys

# the ground floor first: to import sources from within each other takes more stack than a 32-bit build has
for name in ("larics.arith.fixed", "larics.locate.camera_model", "larics.settings"):
    __import__(name)


def run(names):
    """Runs the tests of the named modules; returns (passed, failed)."""
    passed = failed = 0
    for name in names:
        try:
            module = __import__(name)
        except Exception as error:
            print("FAILED import of", name)
            sys.print_exception(error, sys.stdout)
            failed += 1
            continue
        for test in sorted(dir(module)):
            if not test.startswith("test_"):
                continue
            gc.collect()  # what the test before left is in pieces all over a small heap
            try:
                getattr(module, test)()
                passed += 1
            except Exception as error:
                print("FAILED", name + "." + test)
                sys.print_exception(error, sys.stdout)
                failed += 1
    return passed, failed


passed, failed = run(sys.argv[1:])
print("%d passed, %d failed" % (passed, failed))
sys.exit(1 if failed or not passed else 0)
