"""One drive in closed loop, and what was recorded of it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass, replace
from dataclasses import field as of
from typing import TYPE_CHECKING, Any

import numpy as np

from larics.marker import LARICS3
from larics.marker.detection import NO_ID
from larics.wire import messages as m
from larics.wire.codec import frame_size
from larics_host.compilation import told
from larics_host.detection.camera_view import CameraView
from larics_host.drive.c_controller import CController
from larics_host.drive.encoders import Encoders, PythonSender, Talk
from larics_host.drive.field import Field
from larics_host.drive.firmware import Firmware
from larics_host.drive.vehicle import STEP_S, Vehicle
from larics_host.render.series import generator
from larics_host.render.view import render_view
from larics_vehicle.approach import ALIGN, GO, HALT, Approach

if TYPE_CHECKING:
    from larics_host.drive.field import Condition


BAUD = 115200
LATENCY_S = 0.015  # capture and detection on the board: see field.ASSUMED
_IN_FLIGHT = 2  # frames until a new exposure is seen: sensors take it for the frame after the next
_CONTROL_STEPS = 4  # of the vehicle for one of the controller: 20 ms
_WHOLE = 0.999
_MOST_SUSPECTS = 12
_REACH_PX, _REACH_MM = 15.0, 70.0  # a detection further from every marker is a false one


@dataclass
class Sight:
    """What one method made of one frame. Of the markers that are wholly in the frame: right,
    wrong (another ID), unsure (found, no ID). cut, cut_wrong: the same of markers that the border cuts;
    false: detections where there is no marker."""

    right: int = 0
    wrong: int = 0
    unsure: int = 0
    cut: int = 0
    cut_wrong: int = 0
    false: int = 0


@dataclass
class Frame:
    """One frame: truth, what the wire said of it, and what each method saw in it."""

    time_s: float
    x_mm: float
    y_mm: float
    heading_deg: float
    markers: int  # wholly inside the frame, to the end of the orientation line
    state: int
    pose: tuple  # x_mm, y_mm, heading_deg as reported; nan when LOST, as error and sigma_mm
    error: tuple  # mm, degrees; against the pose at the moment at which that marker was exposed
    sigma_mm: float
    marker_id: int
    route_position: int
    behaviour: int
    sights: dict = of(default_factory=dict)
    off: tuple = (math.nan,) * 3  # x mm, y mm, degrees, as error is
    sigmas: tuple = (math.nan,) * 3  # of these, as reported


@dataclass
class Trace:
    """A whole drive. visits: (time, ID, distance mm) each time a marker was left; faults: how many the status
    counts, fault_codes: which it named."""

    field: Field
    frames: list = of(default_factory=list)
    visits: list = of(default_factory=list)
    pushes: list = of(default_factory=list)
    faults: int = 0
    fault_codes: set = of(default_factory=set)
    line_errors: int = 0
    line_bytes: int = 0
    wire: bytearray = of(default_factory=bytearray)  # all whole frames that the camera sent
    ages_us: list = of(default_factory=list)
    pictures: list = of(default_factory=list)  # (time, frame, caption) of those kept
    suspects: list = of(default_factory=list)  # the same of frames with a wrong or false ID on the wire
    halts: Counter[str] = of(default_factory=Counter)  # what the supervision said at each step of a HALT
    behaviours: list = of(default_factory=list)  # (time, state) at each change
    way_mm: float = 0.0


def wheel_limits(condition: Condition) -> dict[str, int]:
    """The limits of the reference behaviour in a condition."""
    slow = condition.rate_hz < 10
    return {
        "speed_mm_s": int(condition.speed_mm_s),
        "accel_mm_s2": int(condition.accel_mm_s2),
        "turn_cdeg_s": 3000 if slow else 9000,
        "turn_accel_cdeg_s2": 6000 if slow else 27000,
        "stale_ms": 1000 if slow else 500,
        "center_mm10": 400 if slow else 300,
        "align_cdeg": 200,
        "leg_mm": int(condition.side_mm * 1.25),
    }


def wheel_controller(condition: Condition, kind: str = "c", is_heard: bool = False) -> Approach | CController:
    """What drives in a condition: "c", the C library with its supervision, or "python", the reference.

    is_heard: there is a line to the camera, so that it is challenged each second."""
    if kind == "python":
        return Approach(**wheel_limits(condition))
    patience_ms = 3 * int(1000 / condition.rate_hz) + 200
    supervision = {"baud": BAUD, "buffer_bytes": 512, "silent_ms": 3000, "stalled_ms": patience_ms}
    # a marker is in view from 0.6 m: so well has a carried pose to be known, over one that is missing
    supervision |= {"most_sigma_mm10": 3000, "most_sigma_cdeg": 1500, "most_carried_ms": 60000}
    supervision |= {"most_way_mm": int(3 * condition.side_mm)}
    if is_heard:
        supervision |= {"challenge_ms": 1000, "answer_ms": patience_ms, "seed": 1}
    return CController(wheel_limits(condition), supervision)


class Simulation:
    """Drives a Field; `trace` is what was recorded.

    interpreter    "micropython" or "cpython"; driver: the method that the firmware uses
    compare        methods that look at the same frames beside it, on this PC
    keep           function (simulation, frame index) -> caption to keep the picture, or None
    controller     "c": the vehicle's C library, which reads the firmware's bytes; "python": the reference
    encoders       how the controller tells the camera of the vehicle's wheels; None: it tells nothing
    """

    def __init__(
        self,
        field_: Field,
        seed: int,
        interpreter: str = "micropython",
        driver: str = "larics",
        compare: Sequence[str] = (),
        keep: Callable[..., str | None] | None = None,
        controller: str = "c",
        encoders: Encoders | None = None,
    ) -> None:
        self.field, self.keep = field_, keep
        self.trace = Trace(field_)
        self.vehicle = Vehicle(field_.start, generator("wheels-" + field_.name, seed))
        self.controller = wheel_controller(field_.condition, controller, encoders is not None)
        size = (field_.camera.width, field_.camera.height)
        self._methods = {name: CameraView(dict(field_.settings, method=name), *size) for name in compare}
        self._firmware = (dict(field_.settings, method=driver), interpreter)
        self._exposures = [(field_.camera.exposure_us, 1.0)] * (_IN_FLIGHT + 1)
        # (time of arrival, type, sequence, record), and the same as bytes of the line
        self._waiting: list[tuple[float, int, int, Any]] = []
        self._line: list[tuple[float, bytes]] = []
        self._talk = None
        if encoders is not None:
            sender = self.controller if isinstance(self.controller, CController) else PythonSender()
            rng = generator("encoders-" + field_.name, seed)
            self._talk = Talk(sender, encoders, rng, BAUD, self.vehicle.drivetrain.track_mm)

    def run(self, on_frame: Callable[[Trace], object] | None = None) -> Trace:
        """The whole drive; on_frame is called with the Trace after each frame."""
        for _ in self.frames():
            if on_frame:
                on_frame(self.trace)
        return self.trace

    def frames(self) -> Generator[Frame]:
        """The drive, frame by frame; each item is the newest Frame."""
        condition = self.field.condition
        settings, interpreter = self._firmware
        events = [event for event in self.field.events if event.kind == "push"]
        period_s = 1 / condition.rate_hz
        is_adjustable = condition.has_exposure_control
        with Firmware(settings, interpreter, int(LATENCY_S * 1e6), is_adjustable=is_adjustable) as firmware:
            steps, index, processing = 0, 0, None
            while steps * STEP_S < condition.seconds:
                now_s = steps * STEP_S
                if processing and now_s >= processing[1] + LATENCY_S - STEP_S / 2:
                    self._report_frame(firmware, *processing)
                    processing = None
                    yield self.trace.frames[-1]
                if now_s >= index * period_s:
                    processing = index, now_s, *self._expose(now_s)
                    index += 1
                while events and events[0].at_s <= now_s:
                    event = events.pop(0)
                    self.vehicle.push(event.forward_mm, event.left_mm, event.turn_deg)
                    self.trace.pushes.append(now_s)
                if steps % _CONTROL_STEPS == 0:
                    self._control(now_s)
                self.vehicle.step(self.controller.speed_mm_s, self.controller.turn_cdeg_s / 100)
                steps += 1
                if self._talk:
                    self._talk.step(self.vehicle, steps * STEP_S)
                self.trace.line_errors = firmware.line_errors
                self.trace.line_bytes = firmware.received_bytes
                self.trace.way_mm = self.vehicle.way_mm

    def _control(self, now_s):
        before, elapsed_ms = self.controller.state, int(1000 * STEP_S * _CONTROL_STEPS)
        if isinstance(self.controller, CController):
            data = b""
            while self._line and self._line[0][0] <= now_s:
                data += self._line.pop(0)[1]
            now_ms = round(now_s * 1000)
            self.controller.receive(data, now_ms)
            if self._talk:
                self._talk.send(self.controller.ask(now_ms), now_s)
            state = self.controller.step(elapsed_ms, now_ms)
            if state == HALT:
                self.trace.halts[self.controller.camera_state] += 1
        else:
            while self._waiting and self._waiting[0][0] <= now_s:
                _, number, sequence, record = self._waiting.pop(0)
                self.controller.on_message(number, sequence, record)
            state = self.controller.step(elapsed_ms)
        if state != before:
            self.trace.behaviours.append((now_s, state))
        if before == ALIGN and state == GO:
            marker_id = self.controller.left_id
            x, y, _ = self.field.markers.get(marker_id, (np.nan, np.nan, 0))
            pose = self.vehicle.pose
            self.trace.visits.append((now_s, marker_id, float(np.hypot(x - pose.x_mm, y - pose.y_mm))))

    def _expose(self, now_s):
        """(pose, behaviour, picture, truths) of this moment."""
        field_ = self.field
        pose, motion = self.vehicle.pose, self.vehicle.motion
        exposure_us, gain = self._exposures.pop(0)
        light = field_.light(now_s, exposure_us, gain)
        camera = replace(field_.camera, exposure_us=exposure_us)
        with told("the renderer"):
            picture, truths = render_view(field_.scene, pose, motion, camera, light, field_.noise)
        return pose, self.controller.state, picture, truths

    def _report_frame(self, firmware, index, now_s, pose, behaviour, picture, truths):
        """The firmware has done with the frame exposed at now_s."""
        line = self._talk.until(now_s + LATENCY_S) if self._talk else ()
        messages = firmware.exchange(picture, index, int(now_s * 1e6), line)
        if firmware.controls:
            exposure_us, gain_cdb = firmware.controls
            self._exposures.append((float(exposure_us), 10 ** (gain_cdb / 2000)))
        else:
            self._exposures.append(self._exposures[-1])
        self.trace.wire += firmware.last_bytes
        arrives_s = now_s + LATENCY_S
        for frame_bytes in firmware.last_bytes.split(b"\0")[:-1]:
            arrives_s += (len(frame_bytes) + 1) * 10 / BAUD
            self._line.append((arrives_s, frame_bytes + b"\0"))
        arrives_s = now_s + LATENCY_S
        reported = None
        for number, sequence, record in messages:
            arrives_s += frame_size(number) * 10 / BAUD
            self._waiting.append((arrives_s, number, sequence, record))
            if number == m.POSE:
                reported = record
            elif number == m.MARKER:
                self.trace.ages_us.append(record.age_us)
            elif number == m.STATUS:
                self.trace.faults = record.faults
                self.trace.fault_codes.update(code for code in (record.last_fault,) if code)
        truths = [truth for truth in truths if truth.id is not None]
        frame = self._frame(now_s, pose, behaviour, truths, reported)
        told = [record for number, _, record in messages if number == m.MARKER]
        frame.sights["wire"] = judge(
            [(one.id, one.x_mm10 / 10, one.y_mm10 / 10) for one in told if not one.flags & m.MARKER_NONE],
            [(t.id, t.offset_x_mm, t.offset_y_mm, self._is_whole(t)) for t in truths],
            _REACH_MM,
        )
        places = [(t.id, t.x_px, t.y_px, self._is_whole(t)) for t in truths]
        for name, view in self._methods.items():
            found = view.detect(picture)
            seen = [(NO_ID if one["id"] is None else one["id"], one["x"], one["y"]) for one in found]
            frame.sights[name] = judge(seen, places, _REACH_PX)
        self.trace.frames.append(frame)
        wire = frame.sights["wire"]
        if (wire.wrong or wire.cut_wrong or wire.false) and len(self.trace.suspects) < _MOST_SUSPECTS:
            self.trace.suspects.append((now_s, picture, "wrong" if wire.wrong else "border or false"))
        caption = self.keep(self, index) if self.keep else None
        if caption:
            self.trace.pictures.append((now_s, picture, caption))

    def _is_whole(self, truth):
        """Whether the frame shows the whole outer ring and the orientation line to its end."""
        camera, angle = self.field.camera, math.radians(truth.heading_deg)
        reach = truth.radius_px * LARICS3.orientation_end_mm10 / LARICS3.outer_mm10
        x, y = truth.x_px + reach * math.cos(angle), truth.y_px - reach * math.sin(angle)
        inside = 0 <= x <= camera.width - 1 and 0 <= y <= camera.height - 1
        return inside and truth.visible >= _WHOLE

    def _frame(self, now_s, pose, behaviour, truths, reported):
        found = (math.nan,) * 3
        if reported.state != m.LOST:
            found = reported.x_mm10 / 10, reported.y_mm10 / 10, reported.heading_cdeg / 100
        true = (pose.x_mm, pose.y_mm, pose.heading_deg)
        is_undone = self._talk is not None and self.field.settings.get("row_ns")
        for truth in () if is_undone else truths:  # a rolling shutter exposes it before or after the middle
            if reported.state == m.TRACKING and truth.id == reported.id:
                true = (truth.vehicle_x_mm, truth.vehicle_y_mm, truth.vehicle_heading_deg)
        off = found[0] - true[0], found[1] - true[1], (found[2] - true[2] + 180) % 360 - 180
        sigmas = (reported.sigma_x_mm10 / 10, reported.sigma_y_mm10 / 10, reported.sigma_cdeg / 100)
        error = float(np.hypot(off[0], off[1])), abs(off[2])
        whole = sum(self._is_whole(truth) for truth in truths)
        return Frame(
            now_s,
            pose.x_mm,
            pose.y_mm,
            pose.heading_deg,
            whole,
            reported.state,
            found,
            error,
            math.nan if reported.state == m.LOST else max(reported.sigma_x_mm10, reported.sigma_y_mm10) / 10,
            reported.id,
            reported.route_position,
            behaviour,
            off=off,
            sigmas=sigmas if reported.state != m.LOST else (math.nan,) * 3,
        )


def judge(
    seen: Iterable[tuple[int, float, float]], places: Sequence[tuple[int, float, float, bool]], reach: float
) -> Sight:
    """The Sight of a frame: (ID or NO_ID or ID_NONE, x, y) of what was seen against (ID, x, y, whole) of what
    is there, which match when no further apart than `reach`."""
    sight = Sight()
    for marker_id, x, y in seen:
        near = [place for place in places if np.hypot(x - place[1], y - place[2]) < reach]
        unsure = marker_id in (NO_ID, m.ID_NONE)
        if not near:
            sight.false += 1
        elif not near[0][3]:
            sight.cut += 1
            sight.cut_wrong += not unsure and marker_id != near[0][0]
        elif unsure:
            sight.unsure += 1
        elif marker_id == near[0][0]:
            sight.right += 1
        else:
            sight.wrong += 1
    return sight
