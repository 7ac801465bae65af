"""What the messages of a camera say at a moment, and what they said before: for whoever shows it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from larics.wire import messages as m
from larics_host import wire_names as codes
from larics_host.connection.records import as_json, known
from larics_host.connection.source_watch import SourceWatch
from larics_host.logs.live_table import STATES, flag_text, reception
from larics_host.monitor.doubts import Doubts

if TYPE_CHECKING:
    from larics_host.connection.receiver import Message


_POINTS = 4000
_RATE_S = 2.0
_STATUS_S = 5.0  # without STATUS, which comes each second: what it told is no longer known
_SILENT_S = 3.0  # without any message: nothing is known any more
_STALE_S = 5.0  # the same of measurements that stop while STATUS goes on
_STALE_STEPS = 3  # or so many times what lay between the last two, with a large rate_divider
_EVENTS = 40
_LANDMARK_SHIFT_MM = 1.0


class MonitorState:
    """Feed it with `add(message, counters)`, and with `pass_time` while nothing comes; `snapshot` gives all
    as a JSON-able dict. What was told stands for seconds, then it is unknown.

    map_rows: rows of the setting `map`, for the places of markers not yet seen.
    Points and trail are numbered, so that whoever has shown some asks only for the rest.
    """

    def __init__(self, source: str, map_rows: Iterable[Sequence[int]] = ()) -> None:
        self.source = source
        self.info = self.status = self.pose = self.counters = None
        self.markers: list[dict[str, Any]] = []  # of the newest frame, the nearest first
        self.frame = None
        self.frames = 0
        self.now_s = 0.0
        self.is_silent = False
        # (number, time s, x mm, y mm, heading deg, ID), None: no marker
        self.points: deque[tuple[Any, ...]] = deque(maxlen=_POINTS)
        self.trail: deque[tuple[Any, ...]] = deque(maxlen=_POINTS)  # (number, x mm, y mm, heading deg, state)
        self.events: deque[tuple[float, str]] = deque(maxlen=_EVENTS)  # (time s, text)
        self.landmarks: dict[
            int, list[tuple[Any, ...]]
        ] = {}  # ID: list of (x mm, y mm, heading deg, in the map)
        self._arrivals: deque[float] = deque()
        self._number = 0
        self._fault_count = None
        self._status_s = 0.0
        self._state = None
        self._heard_s = self._state_s = self._frame_s = self._frame_step_s = self._pose_s = 0.0
        self._pose_frames = 0  # received up to the last POSE
        self._doubts = Doubts()
        self._sources = SourceWatch()
        self.set_map(map_rows)

    def set_map(self, rows: Iterable[Sequence[int]]) -> None:
        """Places the markers of a map; what was learned of others stays."""
        for marker_id in {row[0] for row in rows}:
            self.landmarks.pop(marker_id, None)
        for marker_id, x_mm, y_mm, heading_cdeg, *_ in rows:
            self.landmarks.setdefault(marker_id, []).append((x_mm, y_mm, heading_cdeg / 100, True))

    def add(self, message: Message, counters: Any) -> None:
        """Takes a receiver.Message in; counters of the decoder it came from."""
        self.pass_time(message.time_s)
        self.is_silent, self._heard_s = False, message.time_s
        self.counters = counters
        handler = getattr(self, "_add_" + message.name.lower(), None)
        if handler:
            handler(message.fields, message.time_s)

    def pass_time(self, now_s: float) -> None:
        """Forgets what is too old by this time of the messages' clock."""
        self.now_s = now_s
        if self.is_silent:
            return
        if now_s - self._heard_s > _SILENT_S and self.counters is not None:
            self.is_silent = True
            self.status = self._state = None
            self._forget_frame()
            self._forget_pose()
            self._tell_unknown("nothing received", _SILENT_S, "state, markers and pose are")
            return
        if self.status and now_s - self._status_s > _STATUS_S:
            self.status = None
            self._tell_unknown("no STATUS", _STATUS_S, "faults and rates are")
        if self._state and now_s - self._state_s > _STATUS_S:
            self._state = None
        stale_s = max(_STALE_S, _STALE_STEPS * self._frame_step_s)
        if self.frame is not None and now_s - self._frame_s > stale_s:
            self._forget_frame()
            self._tell_unknown("no MARKER", stale_s, "what is in sight is")
        if self.pose and now_s - self._pose_s > stale_s and self.frames - self._pose_frames > _STALE_STEPS:
            self._forget_pose()
            self._tell_unknown("no POSE", stale_s, "the pose is")

    def _tell_unknown(self, what, seconds, unknown):
        self.events.append((self.now_s, "%s for %.0f s: %s unknown" % (what, seconds, unknown)))

    def _forget_frame(self):
        self.frame, self.markers = None, []
        self._arrivals.clear()

    def _forget_pose(self):
        if self.pose:
            self.pose = dict.fromkeys(self.pose)

    def _add_info(self, fields, time_s):
        told = self._sources.info(fields.unique_id.hex())
        if told:
            self.events.append((time_s, told))
        elif self.info and self.info.boot != fields.boot and not self._sources.is_mixed:
            self.events.append((time_s, "the camera has restarted"))
        self.info = fields

    def _add_marker(self, fields, time_s):
        if fields.frame != self.frame:
            self._frame_step_s = time_s - self._frame_s if self.frame is not None else 0.0
            self.frame, self._frame_s = fields.frame, time_s
            self.frames += 1
            self.markers = []
            self._arrivals.append(time_s)
            while self._arrivals[0] < time_s - _RATE_S:
                self._arrivals.popleft()
        if not fields.flags & m.MARKER_NONE:
            self.markers.append(_shown(fields, time_s))
            self.markers.sort(key=_distance)
            self._doubt(fields, time_s)
        if fields.index + 1 >= fields.count:
            self._number += 1
            first = self.markers[0] if self.markers else None
            values = [first[key] for key in ("x_mm", "y_mm", "heading_deg", "id")] if first else [None] * 4
            self.points.append((self._number, round(time_s, 3), *values))

    def set_optics(self, settings: Mapping[str, Any]) -> None:
        """What the camera knows of sizes and heights, by names of settings."""
        self._doubts.set_optics(settings)

    def _doubt(self, fields, time_s):
        mapped = {key for key, places in self.landmarks.items() if any(place[3] for place in places)}
        for text in self._doubts.add(fields.id, fields.radius_q8 / 256, mapped):
            self.events.append((time_s, text))

    def _add_pose(self, fields, time_s):
        told = as_json(fields)
        self._pose_s, self._pose_frames = time_s, self.frames
        self.pose = {
            "state": STATES[fields.state],
            "x_mm": scaled(told["x_mm10"], 10),
            "y_mm": scaled(told["y_mm10"], 10),
            "heading_deg": scaled(told["heading_cdeg"], 100),
            "sigma_x_mm": scaled(told["sigma_x_mm10"], 10),
            "sigma_y_mm": scaled(told["sigma_y_mm10"], 10),
            "correlation": None if told["sigma_x_mm10"] is None else fields.correlation_q14 / 16384,
            "sigma_deg": scaled(told["sigma_cdeg"], 100),
            "id": told["id"],
            "age_ms": fields.age_us / 1000,
            "marker_age_ms": told["marker_age_ms"],
            "way_mm": told["way_mm"],
            "route": told["route_position"],
            "next_deg": scaled(told["next_cdeg"], 100),
        }
        self._note_state(self.pose["state"], time_s)
        if fields.state == m.LOST:
            return
        self._number += 1
        place = [self.pose[key] for key in ("x_mm", "y_mm", "heading_deg", "state")]
        self.trail.append((self._number, *place))
        if fields.state == m.TRACKING and fields.frame == self.frame:
            for marker in self.markers:
                self._learn(marker)

    def _learn(self, marker):
        """Puts a marker that is in no map where pose and offset say it is."""
        if marker["id"] is None or marker["x_mm"] is None:
            return
        known = self.landmarks.setdefault(marker["id"], [])
        if any(entry[3] for entry in known):
            return
        turn = math.radians(self.pose["heading_deg"])
        x_mm = self.pose["x_mm"] + marker["x_mm"] * math.cos(turn) - marker["y_mm"] * math.sin(turn)
        y_mm = self.pose["y_mm"] + marker["x_mm"] * math.sin(turn) + marker["y_mm"] * math.cos(turn)
        if known and math.hypot(known[0][0] - x_mm, known[0][1] - y_mm) < _LANDMARK_SHIFT_MM:
            return
        heading_deg = (self.pose["heading_deg"] + marker["heading_deg"]) % 360
        known[:] = [(round(x_mm, 1), round(y_mm, 1), round(heading_deg, 2), False)]

    def _add_status(self, fields, time_s):
        told = self._sources.status(fields.boot)
        if told:
            self.events.append((time_s, told))
        self.status, self._status_s = fields, time_s
        self._note_state(STATES[fields.state], time_s)
        if fields.state == m.LOST and self.pose and self.pose["state"] != STATES[m.LOST]:
            # a camera that no longer sends poses
            self.pose = {**dict.fromkeys(self.pose), "state": STATES[m.LOST]}
        if self._fault_count is not None and fields.faults != self._fault_count:
            self.events.append((time_s, "fault: " + codes.name_of("Fault", fields.last_fault)))
        self._fault_count = fields.faults

    def _note_state(self, state, time_s):
        self._state_s = time_s
        if state != self._state:
            self.events.append((time_s, state))
            self._state = state

    @property
    def state(self) -> str | None:
        """TRACKING, COASTING or LOST, by the newest message that tells; None before, and when none tells it
        any more."""
        return self._state

    def rate_hz(self) -> float | None:
        """Frames a second by their arrival."""
        if len(self._arrivals) < 2 or self._arrivals[-1] == self._arrivals[0]:
            return None
        return (len(self._arrivals) - 1) / (self._arrivals[-1] - self._arrivals[0])

    def faults(self) -> list[str]:
        """Names of the faults that last."""
        active = self.status.active_faults if self.status else 0
        return [codes.name_of("Fault", bit) for bit in range(active.bit_length()) if active >> bit & 1]

    def snapshot(self, after: int = 0) -> dict[str, Any]:
        """Everything to show; of points and trail those numbered above `after`, all when that is 0."""
        received = reception(self.counters) if self.counters else (0, 0, 0)
        return {
            "source": self.source,
            "time_s": round(self.now_s, 3),
            "state": self.state,
            "silent": self.is_silent,
            "info": as_json(self.info) if self.info else None,
            "status": as_json(self.status) if self.status else None,
            "pose": self.pose,
            "markers": self.markers,
            "frame": self.frame,
            "frames": self.frames,
            "rate_hz": self.rate_hz(),
            "received": dict(zip(("messages", "lost", "damaged"), received, strict=True)),
            "faults": self.faults(),
            "events": list(self.events),
            "landmarks": [[key, *place] for key, places in self.landmarks.items() for place in places],
            "number": self._number,
            "points": [point for point in self.points if point[0] > after],
            "trail": [point for point in self.trail if point[0] > after],
        }


def _shown(fields, time_s):
    return {
        "id": known(fields, "id"),
        "x_mm": scaled(known(fields, "x_mm10"), 10),
        "y_mm": scaled(known(fields, "y_mm10"), 10),
        "z_mm": scaled(known(fields, "z_mm10"), 10),
        "heading_deg": fields.heading_cdeg / 100,
        "margin": fields.margin,
        "radius_px": round(fields.radius_q8 / 256, 2),
        "age_ms": fields.age_us / 1000,
        "flags": flag_text(fields.flags),
        "time_s": time_s,
    }


def scaled(value: int | None, divisor: int) -> float | None:
    """A number as told, None when that is unknown."""
    return None if value is None else value / divisor


def _distance(marker):
    return math.inf if marker["x_mm"] is None else math.hypot(marker["x_mm"], marker["y_mm"])
