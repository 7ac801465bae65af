"""IDs as people write them: numbers and ranges, of one of the families."""

from __future__ import annotations

import re
from collections.abc import Iterable

from larics.marker import FAMILY_NAMES, ids_in_words, is_used
from larics_host.errors import UserError

_PART = re.compile(r"(-?\d{1,6})(?:-(\d{1,6}))?")


def is_coded(family: str) -> bool:
    """Whether a family's name is that of the coded one. Raises UserError for an unknown name."""
    if family not in FAMILY_NAMES:
        raise UserError(
            "unknown family %s: use plain (IDs 1 to 7) or coded (3,583 IDs, the plain ones included)" % family
        )
    return family == "coded"


def parse_ids(texts: Iterable[str], family: str = "coded", allow_id0: bool = False) -> list[int]:
    """The IDs of texts like "3", "9-15" and "1,4,100-200", in their order, each once.

    Of a range only the IDs that the family uses count; a single ID must be one of them, and a range must hold
    one. Raises UserError, in one line that names the family.
    """
    coded = is_coded(family)
    found = {}
    for part in ",".join(texts).split(","):
        match = _PART.fullmatch(part.strip())
        if not match:
            raise UserError("%s is no ID: give numbers and ranges, such as 3 9-15" % (part.strip() or "''"))
        first = int(match[1])
        last = int(match[2] or first)
        used = [i for i in range(first, last + 1) if is_used(i, coded, allow_id0)]
        if not used:
            words = ids_in_words(coded, allow_id0) + (" (0 with --allow-id0)" if first == 0 else "")
            raise UserError("unknown marker ID %s: %s" % (part.strip(), words))
        found.update(dict.fromkeys(used))
    return list(found)


def ranges_of(ids: Iterable[int]) -> str:
    """Ascending IDs as text, as short as `parse_ids` reads them: [1, 2, 3, 14, 15, 17] -> "1-3,14-17"."""
    runs: list[list[int]] = []
    for marker_id in sorted(ids):
        # a range may run over what no marker has
        if runs and not any(is_used(i) for i in range(runs[-1][1] + 1, marker_id)):
            runs[-1][1] = marker_id
        else:
            runs.append([marker_id, marker_id])
    return ",".join("%d" % a if a == b else "%d-%d" % (a, b) for a, b in runs)
