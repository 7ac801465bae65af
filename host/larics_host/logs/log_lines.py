"""What counts in a recorded log: damaged lines are left out and told of once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from larics_host.errors import UserError, report_once
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


NOT_OURS = "is not from larics log"
_SEQUENCE_MOST = 0xFFFF
_LONGEST_S = 1e9  # thirty years; no log is longer


class Damage:
    """Collects the lines of a log that are none, and tells of them once; good ones around them still count.

    A file with none that is good is no log, or lost all it held: then the first one is an error."""

    _GIVE_UP = 100  # lines, of what begins with so many that are none

    def __init__(self, path: StrPath, unit: str = "line") -> None:
        self._path = path
        self._unit = unit
        self._good = 0
        self._bad = 0
        self._first: str | None = None

    def good(self) -> None:
        """Counts a line that is one."""
        self._good += 1

    def bad(self, number: int, why: str, cut: bool = False) -> None:
        """Counts a line that is none, by its number in the file; `cut`: the last one, which broke off."""
        self._bad += 1
        if self._first is None:
            self._first = "%s %d %s" % (self._unit, number, "is cut off" if cut and self._good else why)
        if not self._good and self._bad >= self._GIVE_UP:
            self.tell()

    def tell(self) -> None:
        """Reports what was counted. UserError when no line was good."""
        if not self._bad:
            return
        if not self._good:
            raise UserError("%s %s" % (self._path, self._first))
        rest = ", and %s more" % counted(self._bad - 1, self._unit) if self._bad > 1 else ""
        text = "%s is damaged: %s%s; the rest is read" % (self._path, self._first, rest)
        report_once(text, text)  # a log is read twice, or for ever


def is_cut(line: str) -> bool:
    """Whether a line was the last when the program or the power ended."""
    return not line.endswith("\n")


def sound(line: str) -> str:
    """Refuses what a loss of power leaves where a line was: zeros, or bytes of other files (ValueError)."""
    if "\0" in line or "\ufffd" in line:
        raise ValueError
    return line


def possible_time(time_s: float) -> float:
    """A `time_s` as it is; ValueError for one that none can be, NaN among them."""
    if not abs(time_s) <= _LONGEST_S:
        raise ValueError("time_s = %g" % time_s)
    return time_s


def possible_sequence(sequence: Any) -> int:
    """The sequence number of a message as it is; ValueError for what is none."""
    if type(sequence) is not int or not 0 <= sequence <= _SEQUENCE_MOST:
        raise ValueError("sequence = %r" % (sequence,))
    return sequence
