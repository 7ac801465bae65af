"""Logs of a fleet that was never there: vehicles drive a round under a row of markers, day after day."""

import json
import math
import random

from larics.wire import messages as m
from larics_host.connection.receiver import Message
from larics_host.connection.records import Info, Marker, Status
from larics_host.logs.log_writer import json_line

HALL = {
    k + 1: (x, y, heading)
    for k, (x, y, heading) in enumerate(
        [(0, 0, 0), (900, 0, 90), (1800, 0, 180), (2700, 100, 270), (2700, 1000, 0), (1800, 1000, 45),
         (900, 1000, 90)]
    )
}  # fmt: skip
DAY_NS = 86400 * 10**9
START_NS = 1_790_000_000 * 10**9
_VIEW_MM = 750
_STEP_S = 0.05


def write_map(path):
    markers = [{"id": k, "x_mm": x, "y_mm": y, "heading_deg": heading} for k, (x, y, heading) in HALL.items()]
    path.write_text(json.dumps({"version": 1, "markers": markers, "route": []}))
    return path


def places(speed_mm_s=900):
    """(x, y, heading) every _STEP_S once round: two straights of 2400 mm, 1000 mm apart, and half circles."""
    bend = math.pi * 500
    for k in range(int((4800 + 2 * bend) / (speed_mm_s * _STEP_S))):
        way = k * speed_mm_s * _STEP_S
        second = way > 2400 + bend
        way -= (2400 + bend) * second
        if way <= 2400:
            x, y, heading = way, 0.0, 0.0
        else:
            heading = math.degrees((way - 2400) / 500)
            x = 2400 + 500 * math.sin(math.radians(heading))
            y = 500 - 500 * math.cos(math.radians(heading))
        yield (2400 - x, 1000 - y, heading + 180) if second else (x, y, heading)


def record(names, **values):
    return names(**{**dict.fromkeys(names._fields, 0), **values})


class Vehicle:
    """margin(day, marker) -> 0..255; read(rng, marker) -> the ID read; hall: where markers really hang."""

    def __init__(self, seed, margin=None, read=None, hall=None, scale=1.0, faults=0):
        self.random = random.Random(seed)
        self.margin = margin or (lambda day, marker: 150)
        self.read = read or (lambda rng, marker: marker)
        self.hall = hall or HALL
        self.scale = scale
        self.faults = faults

    def write(self, path, day=0, rounds=1):
        """A log of a day; returns its path."""
        self.sequence, self.lines = 0, []
        self.start_ns = START_NS + day * DAY_NS
        info = record(Info, board="openmv", unique_id=b"\1" * 12)
        self._say("INFO", info, 0.0)
        time_s, frame = 0.0, 0
        for _ in range(rounds):
            for place in places():
                time_s += _STEP_S
                frame += 1
                self._frame(place, day, frame, time_s)
                if frame % 20 == 0:
                    uptime = frame // 20
                    status = record(Status, uptime_s=uptime, frames=frame, state=m.TRACKING, boot=7,
                                    active_faults=self.faults, missed=2 * uptime)  # fmt: skip
                    self._say("STATUS", status, time_s)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"".join(self.lines))
        return path

    def _say(self, name, fields, time_s):
        self.sequence = (self.sequence + 1) % 65536
        self.lines.append(json_line(Message(name, self.sequence, fields, time_s), self.start_ns))

    def _frame(self, place, day, frame, time_s):
        x, y, heading = place
        seen = []
        for marker, (mx, my, turned) in self.hall.items():
            c, s = math.cos(math.radians(-heading)), math.sin(math.radians(-heading))
            dx, dy = c * (mx - x) - s * (my - y), s * (mx - x) + c * (my - y)
            if math.hypot(dx, dy) < _VIEW_MM:
                seen.append((math.hypot(dx, dy), marker, dx * self.scale, dy * self.scale, turned - heading))
        if not seen:
            none = record(Marker, frame=frame, flags=m.MARKER_NONE, id=m.ID_NONE)
            self._say("MARKER", none, time_s)
        rng = self.random
        for index, (_, marker, dx, dy, turned) in enumerate(sorted(seen)):
            fields = record(
                Marker,
                frame=frame,
                id=self.read(rng, marker),
                index=index,
                count=len(seen),
                x_mm10=round(10 * (dx + rng.gauss(0, 1))),
                y_mm10=round(10 * (dy + rng.gauss(0, 1))),
                z_mm10=20000,
                heading_cdeg=round(100 * (turned + rng.gauss(0, 0.1))) % 36000,
                margin=max(0, min(255, round(self.margin(day, marker) + rng.gauss(0, 10)))),
                radius_q8=round(256 * 30 * self.scale),
            )
            self._say("MARKER", fields, time_s)
