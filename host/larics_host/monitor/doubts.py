"""What a camera reports and yet cannot be right, by what is known beside it: told once each.

A mirrored camera exchanges the coding lines of plain markers, so that it reads IDs that the map lacks where
it has their mirror images. Rings larger or smaller than height and size allow: one of the two is wrong.
"""

from __future__ import annotations

import statistics
from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from larics.marker import PLAIN_ID_MOST, mirrored_lines

_ENOUGH = 20  # readings
_RARE = 0.2  # share of readings that may be wrong ones
_SIZE_SHARE = 0.15  # tilt and lens change a ring's radius by less


class Doubts:
    """Feed it with `add`; it yields a line when enough has come for one."""

    def __init__(self) -> None:
        self._expected_px: float | None = None
        self._radii: deque[float] = deque(maxlen=_ENOUGH)
        self._strange: Counter[int] = Counter()
        self._known = 0
        self._told: set[str] = set()

    def set_optics(self, settings: Mapping[str, Any]) -> None:
        """Settings of the camera: with focal length, ceiling and ring size a ring's radius is known."""
        height_mm10 = settings["ceiling_mm10"] - settings["camera_z_mm10"]
        if settings["focal_q8"] and settings["ceiling_mm10"] and height_mm10 > 0:
            self._expected_px = settings["focal_q8"] / 256 * settings["outer_mm10"] / height_mm10

    def add(self, marker_id: int | None, radius_px: float, mapped: Collection[int]) -> Iterator[str]:
        """A reading: its ID (None: uncertain), its radius, and the IDs in the map."""
        yield from self._mirrored(marker_id, mapped)
        if not mapped:  # a map has heights and sizes of its own, and the camera refuses what contradicts them
            yield from self._size(radius_px)

    def _mirrored(self, marker_id, mapped):
        if marker_id is None or not 0 < marker_id <= PLAIN_ID_MOST or not mapped:
            return
        mirror = mirrored_lines(marker_id)
        if marker_id in mapped:
            self._known += mirror != marker_id
        elif mirror in mapped:
            self._strange[marker_id] += 1
        count = self._strange.total()
        if count >= _ENOUGH and self._known <= _RARE * count and "mirrored" not in self._told:
            self._told.add("mirrored")
            read = self._strange.most_common(1)[0][0]
            text = "marker %d is read, which the map has only mirrored, as %d: is the setting mirrored wrong?"
            yield text % (read, mirrored_lines(read))

    def _size(self, radius_px):
        self._radii.append(radius_px)
        if self._expected_px is None or len(self._radii) < _ENOUGH or "size" in self._told:
            return
        seen_px = statistics.median(self._radii)
        if abs(seen_px / self._expected_px - 1) > _SIZE_SHARE:
            self._told.add("size")
            text = "rings of %.0f px, %.0f px by ceiling_mm10, outer_mm10 and focal_q8: one is wrong"
            yield text % (seen_px, self._expected_px)
