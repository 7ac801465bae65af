"""Where detections come from: a method run on the frames here, or the log of an earlier run."""

from __future__ import annotations

import io
import math
import re
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from larics_host import files
from larics_host.detection import batch
from larics_host.errors import UserError, report
from larics_host.progress import watched

if TYPE_CHECKING:
    from larics_host.annotations import StrPath
    from larics_host.detection.options import DetectionOptions


_KEYS = ("id", "x", "y", "heading", "radius", "margin")


def base_name(name: str) -> str:
    """The name of a frame without its folder, as the truth has it: "clip.bin#3" for a frame of a stream."""
    return PurePath(name).name


class Detections:
    """`by_frame`: {base name: list of detections as dicts}; `label` is what people call it; `paths` and
    `times_ms` are empty for a log."""

    def __init__(self, label: str) -> None:
        self.label = label
        self.by_frame: dict[str, list[dict[str, Any]]] = {}
        self.times_ms: list[float] = []
        self.failed = 0


def run_method(
    folder: StrPath, options: DetectionOptions, jobs: int | None, scheduler: str | None = None
) -> Detections:
    """Detections of a method on all frames of a folder. Sources that fail are reported and counted."""
    detections = Detections(options.method)
    total, _ = batch.count_frames([folder])
    results = batch.detect_all([folder], options, jobs, scheduler=scheduler)
    for result in watched(results, total, options.method, True):
        if result.found is None:
            report(result.error)
            detections.failed += 1
            continue
        detections.by_frame[base_name(result.name)] = result.found
        if result.ms is not None:
            detections.times_ms.append(result.ms)
    return detections


def read_log(path: StrPath) -> Detections:
    """Detections that `larics detect --json` wrote. UserError where it is no such file."""
    detections = Detections(Path(path).stem)
    text = files.read_text(path)
    for number, line in enumerate(io.StringIO(text, newline=None), 1):
        if not line.strip():
            continue
        name, found = _record(line)
        if name is None:
            # a frame that is left out would count as one without a detection
            why = "is not from larics detect --json"
            if detections.by_frame:
                why = "is damaged" if line.endswith("\n") else "was cut off"
                why += ": write the file again with larics detect --json"
            raise UserError("%s line %d %s" % (path, number, why))
        detections.by_frame[re.split(r"[/\\]", name)[-1]] = found  # of any operating system
    if not detections.by_frame:
        raise UserError("%s holds no frame" % path)
    return detections


def _record(line):
    """(frame name, detections) of a line; (None, None) when it is something else."""
    try:
        record = files.parse_json(line)
        name, found = record["frame"], record["detections"]
        for one in found:
            numbers = [one[key] for key in _KEYS[1:]]
            if not all(type(value) in (int, float) and math.isfinite(value) for value in numbers):
                return None, None
            if one["id"] is not None and type(one["id"]) is not int:
                return None, None
        return name + "", found
    except (ValueError, KeyError, TypeError, OverflowError):
        return None, None
