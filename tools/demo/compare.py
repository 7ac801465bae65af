"""What the wire said against the truth of the rendered drive."""

import json
import math
import statistics
from dataclasses import dataclass, field

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host.fleet.tally import missing
from larics_host.truth import by_frame
from tools.demo import drive


@dataclass
class Frame:
    """One frame: what is true, what was reported; poses are (x mm, y mm, heading deg) in the map."""

    index: int
    time_s: float
    truths: list
    vehicle: tuple
    markers: list = field(default_factory=list)
    pose: tuple | None = None
    state: int = m.LOST
    reported: bool = False
    lost: bool = False  # messages are missing where it should be; else the camera did not take it


def angle(difference_deg):
    return (difference_deg + 180) % 360 - 180


def read_run(path, truths):
    """The frames of the drive with what the log file says about them."""
    seen = by_frame(truths)
    vehicles = {t.frame: (t.vehicle_x_mm, t.vehicle_y_mm, t.vehicle_heading_deg) for t in truths}
    frames = [
        Frame(index, index / drive.FPS, seen[name], vehicles[name])
        for index, name in ((k, drive.name_of(k)) for k in range(drive.frame_count()))
    ]
    statuses = []
    before, gone, newest = None, 0, -1  # number of the last message, missing since the newest frame
    for line in path.read_text().splitlines():
        record = json.loads(line)
        sequence = record.get("sequence")
        gone += missing(before, sequence)
        before = sequence
        if record["message"] == "STATUS":
            statuses.append(record)
        if record["message"] not in ("MARKER", "POSE") or record["frame"] >= len(frames):
            continue
        frame = frames[record["frame"]]
        if frame.index > newest:
            for passed in frames[newest + 1 : frame.index]:
                passed.lost = gone > 0
            gone, newest = 0, frame.index
        if record["message"] == "POSE":
            frame.state = record["state"]
            if record["state"] != m.LOST:
                frame.pose = record["x_mm10"] / 10, record["y_mm10"] / 10, record["heading_cdeg"] / 100
        else:
            frame.reported = True
            if not record["flags"] & m.MARKER_NONE:
                frame.markers.append(record)
    return frames, statuses


@dataclass
class Score:
    """Rates and errors of a run."""

    frames: int = 0
    reported: int = 0
    not_taken: int = 0  # by the camera, so that nothing could be reported
    whole: int = 0  # markers whose plates are entirely inside a reported frame
    found: int = 0
    wrong: int = 0
    spurious: int = 0
    offsets_mm: list = field(default_factory=list)
    headings_deg: list = field(default_factory=list)
    positions_mm: list = field(default_factory=list)


def is_whole(truth):
    """Whether the marker's plate is entirely inside the frame."""
    reach = truth.radius_px * 250 / 150
    return reach <= truth.x_px <= drive.WIDTH - 1 - reach and reach <= truth.y_px <= drive.HEIGHT - 1 - reach


def match(record, frame):
    """The truth of a reported marker: the one that is at its place; None when there is none."""
    for truth in frame.truths:
        if offset_error(record, truth) < 75:
            return truth
    return None


def offset_error(record, truth):
    """How far a reported offset is from the true one, mm."""
    return math.hypot(record["x_mm10"] / 10 - truth.offset_x_mm, record["y_mm10"] / 10 - truth.offset_y_mm)


def score(frames):
    total = Score(len(frames))
    for frame in frames:
        total.reported += frame.reported
        total.not_taken += not frame.reported and not frame.lost
        matched = {}
        for record in frame.markers:
            truth = match(record, frame)
            if truth is None:
                total.spurious += 1
            else:
                matched[truth.id] = record
                if record["id"] not in (truth.id, None):
                    total.wrong += 1
                _add_errors(total, record, truth, frame)
        for truth in frame.truths:
            if frame.reported and is_whole(truth):
                total.whole += 1
                total.found += truth.id in matched and matched[truth.id]["id"] == truth.id
        if frame.pose and frame.state == m.TRACKING:
            total.positions_mm.append(position_error(frame))
    return total


def position_error(frame):
    return math.hypot(frame.pose[0] - frame.vehicle[0], frame.pose[1] - frame.vehicle[1])


def _add_errors(total, record, truth, frame):
    total.offsets_mm.append(offset_error(record, truth))
    heading = truth.marker_heading_deg - frame.vehicle[2]
    total.headings_deg.append(abs(angle(record["heading_cdeg"] / 100 - heading)))


def spread(values):
    """(median, 95th percentile) of a list; (nan, nan) of an empty one."""
    if not values:
        return math.nan, math.nan
    ordered = sorted(values)
    return statistics.median(ordered), ordered[min(len(ordered) - 1, round(0.95 * (len(ordered) - 1)))]


def line_bytes(path):
    """Bytes on the line of all messages in a log file."""
    names = {name: number for name, number, _, _ in protocol.MESSAGES}
    return sum(
        protocol.frame_size(names[json.loads(line)["message"]]) for line in path.read_text().splitlines()
    )
