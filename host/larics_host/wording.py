"""Numbers in sentences."""

from __future__ import annotations


def counted(number: int, noun: str) -> str:
    """`1 frame`, `0 frames`, `2 frames`: a number with its noun, given in the singular."""
    return "%d %s%s" % (number, noun, "" if number == 1 else "s")
