"""What a board reported of frames, against what this computer makes of the same frames, message by message.

Both run the same code, but that a board with a small heap does without `weigh_all` (larics.detect.detector):
what is the one or the other is alike, and whatever else differs is a fault of a compiler, an interpreter or a
memory. Frame numbers in the names of the files (frame_<number>.pgm) say which message belongs to which frame,
else their order.
Settings that make a frame depend on those before (tracking, confirm_needed) need all frames of the run.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from larics.device.frame_messages import Reports
from larics.device.sensor import EVERY_PART, Sensor
from larics_host.connection.camera_settings import calibrated_for
from larics_host.connection.records import Marker, as_json, record_of
from larics_host.errors import UserError
from larics_host.images.frame_folder import number_of
from larics_host.images.frame_sources import open_frames
from larics_host.logs.log_records import read_objects
from larics_host.progress import watched
from larics_host.validation.sources import base_name
from larics_host.wording import counted

if TYPE_CHECKING:
    import numpy as np

    from larics.settings import Settings
    from larics_host.annotations import StrPath


COMPARED = [name for name in Marker._fields if name not in ("frame", "age_us")]


class _Kept:
    """In place of an outbox: keeps the messages of a frame as dicts."""

    def __init__(self):
        self.messages = []

    def add(self, number, values):
        self.messages.append(as_json(record_of(number, values)))


class HostRun:
    """Does with a frame what the firmware does. settings: larics.settings.Settings; ValueError as there.
    weigh_all: not as on a small heap."""

    def __init__(self, settings: Settings, weigh_all: bool = True) -> None:
        self._sensor = Sensor(settings, weigh_all=weigh_all)
        self._sensor.rebuild(EVERY_PART)

    def messages(self, number: int, frame: np.ndarray) -> list[dict[str, Any]]:
        """The MARKER messages of a frame as dicts, without a meaningful age."""
        sensor = self._sensor
        count = sensor.place(sensor.detector.detect(frame))
        kept = _Kept()
        reports = Reports(kept)
        if not count:
            reports.no_marker(number, 0)
        for index in range(count):
            reports.marker(number, 0, index, count, sensor.measurements[index], sensor.calibrated)
        return kept.messages


def _reported(path):
    """{frame number: list of MARKER messages} of a log."""
    frames = {}
    for record in read_objects(path):
        if record["message"] == "MARKER":
            if any(name not in record for name in Marker._fields):
                raise UserError("%s is not from larics log" % path)
            frames.setdefault(record["frame"], []).append(record)
    if not frames:
        raise UserError("%s has no marker message" % path)
    return frames


def compare_messages(folder: StrPath, log: StrPath, settings: Settings) -> dict[str, Any]:
    """The comparison as a JSON-able dict: frames, compared, equal, unreported, differences and a summary.

    differences: [{frame, index, field, board, host}], field "count" when the number of markers differs; those
    from a small heap's messages where these are nearer.
    """
    reported = _reported(log)
    runs = None
    unreported = []
    found: tuple[list, list] = ([], [])  # of each frame, against a usual heap and a small one
    frames = 0
    for order, (name, frame) in enumerate(watched(open_frames([folder]), label="frames", quiet_stdout=True)):
        number = number_of(base_name(name))
        number = order if number is None else number
        if runs is None:
            runs = begin(settings, frame), begin(settings, frame, weigh_all=False)
        if frame.shape != (settings.height, settings.width):
            raise UserError("%s is of another size than the frames before" % name)
        here = [run.messages(number, frame) for run in runs]
        frames += 1
        if number not in reported:
            unreported.append(base_name(name))
            continue
        for several, messages in zip(found, here, strict=True):
            several.append(_differences(base_name(name), reported[number], messages))
    compared = len(found[0])
    if not compared:
        raise UserError("%s reports none of the frames in %s" % (log, folder))
    nearest = min(found, key=lambda several: sum(map(len, several)))
    equal = sum(not some for some in nearest)
    return {
        "frames": frames,
        "compared": compared,
        "equal": equal,
        "unreported": unreported,
        "differences": [one for some in nearest for one in some],
        "summary": "%d of %s reported alike; %d not in the log"
        % (equal, counted(compared, "frame"), len(unreported)),
    }


def begin(settings: Settings, frame: np.ndarray, weigh_all: bool = True) -> HostRun:
    """A HostRun for frames of this one's size; UserError when the settings do not suit it."""
    height, width = frame.shape
    reason = calibrated_for(settings, width, height)
    if reason:
        raise UserError(reason)
    try:
        settings.update({"width": width, "height": height})
        return HostRun(settings, weigh_all)
    except ValueError as error:
        raise UserError("the settings do not suit frames of %d x %d: %s" % (width, height, error)) from None


def _differences(frame, board, host):
    if len(board) != len(host):
        text = {"frame": frame, "index": 0, "field": "count"}
        return [dict(text, board=len(board), host=len(host))]
    return [
        {"frame": frame, "index": k, "field": name, "board": one[name], "host": other[name]}
        for k, (one, other) in enumerate(zip(board, host, strict=True))
        for name in COMPARED
        if one[name] != other[name]
    ]
