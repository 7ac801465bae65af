"""Logs -> what a map is built from: markers, what was seen together, and drives between them.

Where a log has the vehicle's odometry, it becomes drives with passages; of the rest counts what one frame
shows together, see links.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from larics_host import files
from larics_host.errors import UserError
from larics_host.mapping.links import Place, Readings
from larics_host.mapping.passages import Drive, drives
from larics_host.mapping.sightings import Seen, read_sightings

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


# readings of two logs that are the same to the bit, and their share of the shorter one
_SAME_LEAST, _SAME_SHARE = 20, 0.5


@dataclass
class Collected:
    """places [Place] that frames name, links {(number, number): array (N, 3) of x mm, y mm, heading deg of
    the second in the axes of the first}, refused: readings that agree with no others; drives [Drive];
    repeats: whether IDs stand at several places; heights {ID: heights mm}."""

    places: list[Place]
    links: dict[tuple[int, int], np.ndarray]
    refused: int
    drives: list[Drive] = field(default_factory=list)
    repeats: bool = False

    @property
    def outvoted(self) -> int:
        """Readings of another ID than most of their passage have."""
        passages = [passage for drive in self.drives for passage in drive.passages]
        return sum(sum(passage.votes.values()) - passage.votes[passage.id] for passage in passages)

    def ids(self) -> Counter[int]:
        """How often each ID was read."""
        total: Counter[int] = Counter()
        for place in self.places:
            total += place.votes
        for drive in self.drives:
            for passage in drive.passages:
                total += passage.votes
        return total


def collect(
    paths: Sequence[StrPath], repeats: bool, progress: Callable[[int], object] = files.unwatched
) -> Collected:
    """What logs tell; progress is told the bytes read of all of them together. UserError where two are of the
    same drive: what is said twice would count twice."""
    readings = Readings(repeats)
    found: list[Drive] = []
    before = 0
    known: list[set] = []
    for log, path in enumerate(paths):
        seen = read_sightings(path, _from(before, progress))
        if len(paths) > 1:
            _refuse_same(known, seen, paths)
        before += files.size(path)
        progress(before)
        driven, alone = drives(seen, log)
        found += driven
        readings.add(seen, alone)
    places, links, refused = readings.links()
    return Collected(places, links, refused, [one for one in found if one.passages], repeats)


def _refuse_same(known: list[set], seen: Seen, paths: Sequence[StrPath]) -> None:
    """Adds what was seen to that of the logs before. UserError where it is that of one of them."""
    mine = {
        (number, one.id, one.x_mm, one.y_mm, one.heading_deg)
        for number, one in zip(seen.numbers[seen.frames].tolist(), seen.sightings, strict=True)
    }
    for before, theirs in zip(paths, known, strict=False):
        least = max(_SAME_LEAST, _SAME_SHARE * min(len(mine), len(theirs)))
        if len(mine & theirs) >= least:
            raise UserError("%s and %s are of the same drive: give one of them" % (before, paths[len(known)]))
    known.append(mine)


def _from(before, progress):
    return lambda done: progress(before + done)
