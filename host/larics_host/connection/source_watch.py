"""Whether more than one camera speaks on a line, by what INFO and STATUS tell of the sender."""

from __future__ import annotations

_RETURNS = 2  # of a boot number after another one; a restart draws one at random, rarely an old one


class SourceWatch:
    """Feed it with `info` and `status`; each gives a line when there is something new to tell, else None.

    is_mixed: several cameras take turns, so that sequence numbers tell of no loss."""

    def __init__(self) -> None:
        self.is_mixed = False
        self._unique_id: str | None = None
        self._boot: int | None = None
        self._boots: set[int] = set()
        self._returns = 0

    def info(self, unique_id: str) -> str | None:
        """Takes the unique ID of an INFO, in hexadecimal."""
        before, self._unique_id = self._unique_id, unique_id
        if before in (None, unique_id) or self.is_mixed:
            return None
        return "another camera is on the line: unique ID %s, before %s" % (unique_id, before)

    def status(self, boot: int) -> str | None:
        """Takes the boot number of a STATUS."""
        before, self._boot = self._boot, boot
        if before is None or before == boot:
            self._boots.add(boot)
            return None
        self._returns += boot in self._boots
        self._boots.add(boot)
        if self._returns < _RETURNS or self.is_mixed:
            return None
        self.is_mixed = True
        boots = min(before, boot), max(before, boot)
        return "two cameras speak by turns (boots %d and %d): what counts as lost is not; part them" % boots
