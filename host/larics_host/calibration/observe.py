"""Markers seen in frames, as arrays for the fits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from larics_host.detection import batch
from larics_host.errors import UserError, report
from larics_host.progress import watched
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath
    from larics_host.detection.options import DetectionOptions


_UNWANTED = {"border", "id_uncertain", "unconfirmed"}


class Observations(NamedTuple):
    """One entry a marker seen: `frame` is the index of its frame; x_px, y_px, radius_px, heading_deg (image
    angle, counterclockwise) and marker_id are arrays of equal length."""

    width: int
    height: int
    frames: int
    frame: np.ndarray
    marker_id: np.ndarray
    x_px: np.ndarray
    y_px: np.ndarray
    radius_px: np.ndarray
    heading_deg: np.ndarray

    def of(self, marker_id: int) -> Observations:
        """Only those of one marker."""
        keep = self.marker_id == marker_id
        return self._replace(**{name: getattr(self, name)[keep] for name in self._fields[3:]})

    def commonest_id(self) -> int:
        return Counter(self.marker_id.tolist()).most_common(1)[0][0]


def _rows(paths, options, jobs):
    """(rows, sizes of frames, number of frames, copies of frames that were left out)."""
    rows = []
    sizes = set()
    known = set()
    frames = copies = 0
    for result in watched(
        batch.detect_all(paths, options, jobs), batch.count_frames(paths)[0], quiet_stdout=True
    ):
        if result.found is None:
            raise UserError(result.error)
        sizes.add((result.width, result.height))
        frames += 1
        seen = [
            (one["id"], one["x"], one["y"], one["radius"], one["heading"])
            for one in result.found
            if not _UNWANTED & set(one["flags"])
        ]
        # no sensor repeats its noise, nor a detection its last digit
        if seen and tuple(seen) in known:
            copies += 1
            continue
        known.add(tuple(seen))
        rows += [(frames - 1, *one) for one in seen]
    return rows, sizes, frames, copies


def observe(paths: Iterable[StrPath], options: DetectionOptions, jobs: int | None = None) -> Observations:
    """What a detection with `options` sees in all frames behind `paths`; markers at the border and those
    whose ID is uncertain are left out. UserError when there is none, one cannot be
    read, or frames differ in size."""
    rows, sizes, frames, copies = _rows(paths, options, jobs)
    name = ", ".join(map(str, paths))
    if not rows:
        hint = "try --radius-px"
        turned = options._replace(mirrored=not options.mirrored)
        if _rows(paths, turned, jobs)[0]:  # nothing else reads a marker the wrong way round
            hint = "they are read in the mirror, so %s"
            hint %= "do without --mirrored" if options.mirrored else "the camera is mirrored: give --mirrored"
        raise UserError("no marker with a certain ID in %s (%s): %s" % (name, counted(frames, "frame"), hint))
    if copies:
        what = "a copy of a frame" if copies == 1 else "%d copies of frames" % copies
        report("%s in %s left out: a copy says nothing new" % (what, name))
    if len(sizes) > 1:
        raise UserError("the frames of %s differ in size: a calibration is for one size" % name)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    width, height = sizes.pop()
    return Observations(width, height, frames, *columns)
