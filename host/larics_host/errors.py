"""The one error that a user may see."""

from __future__ import annotations

import sys


class UserError(Exception):
    """Bad input: its text is one line that says what is wrong and what to do."""


def report(error: object) -> None:
    """Prints an error as the one line `larics: ...` on standard error."""
    print("larics: %s" % " ".join(str(error).split()), file=sys.stderr)
