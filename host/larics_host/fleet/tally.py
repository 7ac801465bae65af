"""What a block of a log tells, in sums of whole numbers and short samples, so that blocks add up exactly.

A block is worked on without those before it: a visit under a marker or a vehicle's way that its border cuts
counts as two. Borders lie where the size of the log puts them, so results are the same wherever blocks are
read.
"""

from __future__ import annotations

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from larics.wire import messages as m
from larics.wire.codec import LATE
from larics_host.connection.receiver import Receiver
from larics_host.connection.records import as_json
from larics_host.connection.source_watch import SourceWatch
from larics_host.errors import UserError, withheld
from larics_host.fleet.clock import Clock
from larics_host.fleet.passes import Passes, Reading, judged
from larics_host.fleet.sources import Block, lines, local_copy
from larics_host.fleet.track import Landmark, Off, Track
from larics_host.logs.log_lines import possible_sequence, possible_time
from larics_host.logs.log_reader import read_pieces
from larics_host.wording import counted

_HEAD = re.compile(
    rb'\s*\{"time_s": ([-\d.e]+), "time": (?:null|"([^"]*)"), "message": "(\w+)", "sequence": (\d+)[,}]'
)
_WANTED = (b"MARKER", b"STATUS", b"INFO")
_UNUSABLE = m.MARKER_NONE | m.MARKER_ID_UNCERTAIN | m.MARKER_UNCONFIRMED
_PAUSE_S = 5.0  # a longer silence is no time of operation
_SAMPLES = 40  # readings of a pair that a block keeps, and
_SAMPLES_ALL = 400  # that are kept of all blocks
_SHOWN_FRAMES = 3
_SUMS = ("missed", "drops", "crc_errors", "faults", "rejects")
NO_DATE = ""


class Work(NamedTuple):
    """A task: a block, the map's landmarks, how many letters of a date make a period, and whether numbers
    that are missing were lost (larics record leaves out what it fetched)."""

    block: Block
    landmarks: Sequence[Landmark]
    period: int
    loses: bool = True


class Tally:
    """Sums over readings; `add` joins that of the next block of the same vehicle.

    readings   {(ID, period): [count, margin, margin squared, radius in 1/256 px]}
    pairs      {(ID, ID, period): [mm between them]};  offs  {(number, number, period): [(x, y, heading)]}
    wrong      {(ID of the plate, ID read): count};  contradictions  {(ID read, ID there or None): count}
    recorded   frames that lie beside a log, recorded_alike: and read here the IDs that were reported;
               conflicts: other IDs; conflict_frames  [(frame, IDs reported, IDs here)], some of them
    mixed      what is told of several cameras on one line, whose numbers tell nothing; None where one speaks
    told_s     seconds that STATUS tells of, and of these states and fault_seconds {code: seconds}
    """

    def __init__(self) -> None:
        self.bytes = self.lines = self.damaged = self.lost = 0
        self.seconds = 0.0
        self.frames = self.frames_seen = self.uncertain = self.visits = self.statuses = self.boots = 0
        self.told_s = self.recorded = self.recorded_alike = self.conflicts = 0
        self.conflict_frames: list[tuple[str, list[int], list[int]]] = []
        self.sums: Counter[str] = Counter()
        self.states: Counter[int] = Counter()
        self.fault_seconds: Counter[int] = Counter()
        self.cameras: set[str] = set()
        self.mixed: str | None = None
        self.readings: dict[tuple[int, str], list[int]] = {}
        self.pairs: dict[tuple[int, int, str], list[float]] = defaultdict(list)
        self.offs: dict[tuple[int, int, str], list[tuple[float, float, float]]] = defaultdict(list)
        self.wrong: Counter[tuple[int, int]] = Counter()
        self.contradictions: Counter[tuple[int, int | None]] = Counter()
        self.first: Edge | None = None
        self.last: Edge | None = None

    def add(self, other: Tally, same_log: bool) -> None:
        """same_log: `other` goes on where this one ended."""
        if same_log and self.last and other.first:
            self.between(self.last, other.first)
        for name in ("bytes", "lines", "damaged", "lost", "seconds", "frames", "frames_seen", "uncertain",
                     "visits", "statuses", "boots", "told_s", "recorded", "recorded_alike",
                     "conflicts"):  # fmt: skip
            setattr(self, name, getattr(self, name) + getattr(other, name))
        for name in ("sums", "states", "fault_seconds", "wrong", "contradictions"):
            getattr(self, name).update(getattr(other, name))
        self.cameras |= other.cameras
        self.mixed = self.mixed or other.mixed
        for key, sums in other.readings.items():
            mine = self.readings.setdefault(key, [0, 0, 0, 0])
            for k, value in enumerate(sums):
                mine[k] += value
        self.conflict_frames = (self.conflict_frames + other.conflict_frames)[:_SHOWN_FRAMES]
        kinds: Any = (self.pairs, other.pairs), (self.offs, other.offs)
        for samples, others in kinds:
            for sample, values in others.items():
                samples[sample] = (samples[sample] + values)[:_SAMPLES_ALL]
        self.first = self.first or other.first
        if other.last is not None:
            last = other.last
            if last.status is None and same_log and self.last and other.first:
                gone = self.last.lost + missing(self.last.sequence, other.first.sequence) + last.lost
                last = last._replace(status=self.last.status, lost=gone)
            self.last = last

    def between(self, before: Edge, after: Edge) -> None:
        """What the passage from one message to the next tells."""
        passed_s = after.time_s - before.time_s
        if 0 <= passed_s <= _PAUSE_S:
            self.seconds += passed_s
        self.lost += missing(before.sequence, after.sequence)
        status, earlier = after.status, before.status
        if status is not None and earlier is not None:
            if status["boot"] != earlier["boot"]:
                self.boots += 1
            else:
                for name in _SUMS:
                    self.sums[name] += max(0, status[name] - earlier[name])
                gone = before.lost + missing(before.sequence, after.sequence) + after.lost
                self.tell(status, seconds_told(earlier, status, gone) - 1)  # one is counted

    def tell(self, status: Mapping[str, Any], seconds: int) -> None:
        """So many seconds more in the state that a STATUS tells."""
        self.told_s += seconds
        self.states[status["state"]] += seconds
        for code in range(30):
            if status["active_faults"] >> code & 1:
                self.fault_seconds[code] += seconds


def seconds_told(before: Mapping[str, Any], status: Mapping[str, Any], lost: int) -> int:
    """How many seconds a STATUS stands for: those since the one before, of the same boot.

    A program that is held up sends none meanwhile. Where messages are missing, a long time between two may be
    one in which nobody recorded: it counts as one second."""
    passed_s = max(1, status["uptime_s"] - before["uptime_s"])
    return 1 if lost and passed_s > _PAUSE_S else passed_s


def missing(before: int | None, after: int | None) -> int:
    """How many messages are missing between two by their sequence numbers, None where those tell nothing."""
    if before is None or after is None:
        return 0
    step = (after - before) % 65536
    return step - 1 if 0 < step < 32768 else 0


def is_overtaken(before: int | None, after: int | None) -> bool:
    """Whether a message comes a little after one that was sent later, as larics.wire.codec.Decoder has it."""
    return before is not None and after is not None and (after - before) % 65536 > 65536 - LATE


class Edge(NamedTuple):
    """The first or last message of a block, the first or last STATUS in it, and how many messages are missing
    between the two; of the whole block where it has no STATUS."""

    time_s: float
    sequence: int | None
    status: dict[str, Any] | None
    lost: int


class _Reader:
    """Makes a Tally of messages one after the other."""

    def __init__(self, landmarks, period, loses):
        self.tally = Tally()
        self._period = period
        self._loses = loses
        self._passes = Passes()
        self._track = Track(landmarks)
        self._sources = SourceWatch()
        self._frame = None
        self._frame_s = 0.0
        self._date = NO_DATE
        self._found = []
        self._time_s = self._sequence = None
        self._first = self._status = self._first_status = None
        self._lost_before = 0  # of the first STATUS
        self._status_lost = 0  # up to the last one

    def message(self, time_s, date, name, sequence, fields):
        """`fields` is None where they do not matter."""
        tally = self.tally
        sequence = sequence if self._loses else None
        if self._time_s is None:
            self._first = time_s, sequence
        else:
            passed_s = time_s - self._time_s
            if 0 <= passed_s <= _PAUSE_S:
                tally.seconds += passed_s
            if is_overtaken(self._sequence, sequence):  # it was counted as missing
                tally.lost = max(0, tally.lost - 1)
                sequence = self._sequence
            elif name != "INFO":  # after a start the numbers begin anew
                tally.lost += missing(self._sequence, sequence)
        self._time_s, self._sequence = time_s, sequence
        if name == "MARKER":
            self._marker(time_s, date, fields)
        elif name == "STATUS":
            self._take_status(fields)
        elif name == "INFO":
            tally.cameras.add("%s %s" % (fields["board"], fields["unique_id"][:8]))

    def _take_status(self, fields):
        tally = self.tally
        tally.statuses += 1
        tally.mixed = self._sources.status(fields["boot"]) or tally.mixed
        seconds = 1
        if self._status is None:
            self._first_status, self._lost_before = fields, tally.lost
        elif self._status["boot"] != fields["boot"]:
            tally.boots += 1
        else:
            if fields["uptime_s"] < self._status["uptime_s"]:  # as connection.decoder has it
                tally.lost = self._status_lost
            for name in _SUMS:
                tally.sums[name] += max(0, fields[name] - self._status[name])
            seconds = seconds_told(self._status, fields, tally.lost - self._status_lost)
        tally.tell(fields, seconds)
        self._status, self._status_lost = fields, tally.lost

    def _marker(self, time_s, date, fields):
        if fields["frame"] != self._frame:
            self._end_frame()
            self._frame, self._frame_s, self._date = fields["frame"], time_s, date[: self._period]
            self.tally.frames += 1
            self.tally.frames_seen += not fields["flags"] & m.MARKER_NONE
        flags = fields["flags"]
        if flags & m.MARKER_ID_UNCERTAIN:
            self.tally.uncertain += 1
        if flags & _UNUSABLE or fields["id"] is None:
            return
        margin = fields["margin"]
        sums = self.tally.readings.setdefault((fields["id"], self._date), [0, 0, 0, 0])
        sums[0] += 1
        sums[1] += margin
        sums[2] += margin * margin
        sums[3] += fields["radius_q8"]
        if not flags & m.MARKER_NO_OFFSET:
            x_mm, y_mm = fields["x_mm10"] / 10, fields["y_mm10"] / 10
            self._found.append(Reading(fields["id"], x_mm, y_mm, fields["heading_cdeg"] / 100, margin))

    def _end_frame(self):
        found, self._found = self._found, []
        if self._frame is None:
            return
        tally, date = self.tally, self._date
        for ids in self._passes.add(self._frame_s, found):
            self._visit(ids)
        if not found:
            return
        for k, one in enumerate(found):
            for other in found[k + 1 :]:
                first, second = sorted((one.id, other.id))
                if first != second:
                    apart_mm = ((one.x_mm - other.x_mm) ** 2 + (one.y_mm - other.y_mm) ** 2) ** 0.5
                    _keep(tally.pairs[first, second, date], apart_mm)
        for told in self._track.add(self._frame_s, found):
            if isinstance(told, Off):
                _keep(tally.offs[told.marker, told.partner, date], told[2:])
            else:
                tally.contradictions[told.read, told.there] += 1

    def _visit(self, ids):
        self.tally.visits += 1
        right, others = judged(ids)
        for read, count in others.items():
            self.tally.wrong[right, read] += count

    def end(self):
        self._end_frame()
        for ids in self._passes.end():
            self._visit(ids)
        if self._first is not None:
            lost = self.tally.lost
            before = self._lost_before if self._status else lost
            self.tally.first = Edge(*self._first, self._first_status, before)
            self.tally.last = Edge(self._time_s, self._sequence, self._status, lost - self._status_lost)
        return self.tally


def _keep(sample, value):
    if len(sample) < _SAMPLES:
        sample.append(value)


class Told(NamedTuple):
    """What became of a block: its Tally, or why it could not be read, and lines for the user."""

    tally: Tally | None
    error: str | None
    lines: list[tuple[object, str]]


def read_block(work: Work) -> Told:
    """The work on one block, in whatever process."""
    block = work.block
    reader = _Reader(work.landmarks, work.period, work.loses)
    with withheld() as told:
        try:
            if block.end is None:
                _read_whole(reader, block)
            else:
                _read_lines(reader, block)
        except UserError as error:
            return Told(None, str(error), told)
        except OSError as error:
            why = "cannot read %s: %s" % (block.source.name, error.strerror or error)
            return Told(None, why, told)
    return Told(reader.end(), None, told)


def _read_lines(reader, block):
    tally = reader.tally
    for line in lines(block):
        tally.bytes += len(line)
        tally.lines += 1
        if not line.strip():
            continue
        try:
            _read_line(reader, line)
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
            tally.damaged += 1


def _read_line(reader, line):
    """One line; only those that matter are parsed wholly."""
    head = _HEAD.match(line)
    if head is None or not line.endswith(b"}\n"):
        fields = json.loads(line)  # written by other hands
        name, date = fields["message"], fields.get("time") or NO_DATE
        time_s = possible_time(fields["time_s"] + 0.0)
        reader.message(time_s, date, name, possible_sequence(fields["sequence"]), fields)
        return
    time, date, name, sequence = head.groups()
    fields = json.loads(line) if name in _WANTED else None
    reader.message(float(time), (date or b"").decode(), name.decode(), int(sequence), fields)


def _read_whole(reader, block):
    """A log that cannot be cut: its messages one after the other."""
    with local_copy(block.source) as path:
        receiver = Receiver()
        reader.tally.bytes += block.source.size
        time_s, clock = 0.0, Clock()
        is_timed = False
        for piece in read_pieces(path):
            if piece.time_s is not None:
                time_s, is_timed = piece.time_s, True
            for message in receiver.feed(piece.data, time_s):
                if not is_timed:
                    time_s = clock.of(message)
                reader.tally.lines += 1
                reader.message(time_s, NO_DATE, message.name, message.sequence, as_json(message.fields))


def vehicles(told: Iterator[tuple[Block, Told]]) -> tuple[dict[str, Tally], dict[str, int], list[str]]:
    """({vehicle: Tally of all its logs}, {vehicle: how many}, lines about blocks that could not be read)."""
    tallies: dict[str, Tally] = {}
    logs: dict[str, set[str]] = defaultdict(set)
    errors = []
    none_good: dict[str, int] = {}  # log: its damaged lines, of those in which no message was found
    good: set[str] = set()
    before = None
    for block, one in told:
        if one.tally is None:
            errors.append(str(one.error))
            before = None
            continue
        source = block.source
        if not source.size and not one.tally.lines:
            errors.append("%s is empty" % source.name)
            continue
        logs[source.vehicle].add(source.name)
        tallies.setdefault(source.vehicle, Tally()).add(one.tally, before == source.name)
        before = source.name
        if one.tally.first is not None:
            good.add(source.name)
        else:
            none_good[source.name] = none_good.get(source.name, 0) + one.tally.damaged
    for name, damaged in none_good.items():
        if name in good:
            continue
        if damaged:
            errors.append("%s: none of its %s is a message of larics log" % (name, counted(damaged, "line")))
        else:
            errors.append("%s holds no message" % name)
    lost = none_good.keys() - good
    for vehicle, names in logs.items():
        if names <= lost:
            del tallies[vehicle]
    return tallies, {vehicle: len(logs[vehicle]) for vehicle in tallies}, errors
