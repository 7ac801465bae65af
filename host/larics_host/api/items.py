"""What a Camera yields: immutable records in millimetres, degrees, pixels and seconds; None is "not known".

The vehicle frame has x forward, y left, z up, the map frame is the map's; headings count counterclockwise.
`time` is the middle of the exposure for what is about a frame, else the time of reception: an aware datetime
in UTC, None where a log does not tell it. `time_s` is the same in seconds since the connection or the log
began.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from larics.wire import messages as m
from larics_host import wire_names as codes
from larics_host.connection.records import known


@dataclass(frozen=True, slots=True)
class _Item:
    time: datetime | None
    time_s: float


@dataclass(frozen=True, slots=True)
class _OfFrame(_Item):
    frame: int  # number of the camera frame


@dataclass(frozen=True, slots=True)
class Measurement(_OfFrame):
    """One marker in one frame: number `index` of `count`. marker_id is None when the place is certain and the
    ID is not. x_mm, y_mm, z_mm: from the vehicle's origin to the marker's centre, None without a calibration;
    heading_deg: of its orientation line, in the vehicle frame; radius_px: of its outer ring; margin: 0 to
    255, how far the weakest decision was from its limit; sigma_px, sigma_deg: standard deviations of centre
    and heading; flags: names."""

    marker_id: int | None
    index: int
    count: int
    x_mm: float | None
    y_mm: float | None
    z_mm: float | None
    heading_deg: float
    radius_px: float
    margin: int
    sigma_px: float | None
    sigma_deg: float | None
    flags: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class NothingSeen(_OfFrame):
    """A frame without a marker."""


@dataclass(frozen=True, slots=True)
class Pose(_OfFrame):
    """The vehicle in the map. state: "tracking" (measured in this frame), "coasting" (predicted), "carried"
    (by odometry) or "lost". covariance_mm2: of x and y; sigma_deg: standard deviation of the heading.
    marker_id, marker_age_s, way_mm: the marker it rests on, since when, and the way driven since;
    route_position: index in the route of the marker reached; next_deg: direction to go on, in the vehicle
    frame."""

    state: str
    x_mm: float | None
    y_mm: float | None
    heading_deg: float | None
    covariance_mm2: tuple[tuple[float, float], tuple[float, float]] | None
    sigma_deg: float | None
    marker_id: int | None
    marker_age_s: float | None
    way_mm: int | None
    route_position: int | None
    next_deg: float | None

    @property
    def known(self) -> bool:
        """Whether there is a place: not lost."""
        return self.x_mm is not None


@dataclass(frozen=True, slots=True)
class Motion(_OfFrame):
    """The vehicle's odometry at the exposure of a frame, in the odometry frame, as the camera used it. state:
    "none", "interpolated" or "extrapolated"; with "none" the rest tells the last one."""

    state: str
    epoch: int
    x_mm: float
    y_mm: float
    heading_deg: float


@dataclass(frozen=True, slots=True)
class Health(_Item):
    """STATUS, once a second. state: as of Pose; faults: names of those that last; fault_count: since the
    start; `record` has every counter of the message."""

    state: str
    faults: tuple[str, ...]
    fault_count: int
    uptime_s: int
    rate_hz: float | None
    detect_ms: float | None
    latency_ms: float | None
    exposure_ms: float
    gain_db: float
    grey_mean: int | None
    record: Any


@dataclass(frozen=True, slots=True)
class Started(_Item):
    """INFO: who is speaking; a camera tells it at its start."""

    board: str
    unique_id: str  # hexadecimal digits
    version: tuple[int, int, int]
    width: int
    height: int
    boot: int


Item = Measurement | NothingSeen | Pose | Motion | Health | Started


def _scaled(record, field, divisor):
    value = known(record, field)
    return None if value is None else value / divisor


def _names(group, bits, first=0):
    return tuple(
        codes.name_of(group, bit if first else 1 << bit)
        for bit in range(first, bits.bit_length())
        if bits >> bit & 1
    )


def item_of(record: Any, name: str, time: datetime | None, time_s: float) -> Item | None:
    """The Item of a record of the wire; None for answers and commands."""
    maker = _MAKERS.get(name)
    return None if maker is None else maker(record, time, time_s)


def _marker(record, time, time_s):
    if record.flags & m.MARKER_NONE:
        return NothingSeen(time, time_s, record.frame)
    return Measurement(
        time,
        time_s,
        record.frame,
        marker_id=known(record, "id"),
        index=record.index,
        count=record.count,
        x_mm=_scaled(record, "x_mm10", 10),
        y_mm=_scaled(record, "y_mm10", 10),
        z_mm=_scaled(record, "z_mm10", 10),
        heading_deg=record.heading_cdeg / 100,
        radius_px=record.radius_q8 / 256,
        margin=record.margin,
        sigma_px=_scaled(record, "sigma_q12", 4096),
        sigma_deg=_scaled(record, "sigma_mdeg", 1000),
        flags=_names("MARKER flag", record.flags),
    )


def _pose(record, time, time_s):
    sigma_x, sigma_y = _scaled(record, "sigma_x_mm10", 10), _scaled(record, "sigma_y_mm10", 10)
    covariance = None
    if sigma_x is not None and sigma_y is not None:
        both = record.correlation_q14 / 16384 * sigma_x * sigma_y
        covariance = ((sigma_x**2, both), (both, sigma_y**2))
    return Pose(
        time,
        time_s,
        record.frame,
        state=codes.name_of("POSE state", record.state),
        x_mm=_scaled(record, "x_mm10", 10),
        y_mm=_scaled(record, "y_mm10", 10),
        heading_deg=_scaled(record, "heading_cdeg", 100),
        covariance_mm2=covariance,
        sigma_deg=_scaled(record, "sigma_cdeg", 100),
        marker_id=known(record, "id"),
        marker_age_s=_scaled(record, "marker_age_ms", 1000),
        way_mm=known(record, "way_mm"),
        route_position=known(record, "route_position"),
        next_deg=_scaled(record, "next_cdeg", 100),
    )


def _motion(record, time, time_s):
    return Motion(
        time,
        time_s,
        record.frame,
        state=codes.name_of("MOTION state", record.state),
        epoch=record.epoch,
        x_mm=record.x_mm10 / 10,
        y_mm=record.y_mm10 / 10,
        heading_deg=record.heading_cdeg / 100,
    )


def _status(record, time, time_s):
    return Health(
        time,
        time_s,
        state=codes.name_of("POSE state", record.state),
        faults=_names("Fault", record.active_faults, first=1),
        fault_count=record.faults,
        uptime_s=record.uptime_s,
        rate_hz=_scaled(record, "rate_chz", 100),
        detect_ms=_scaled(record, "detect_us", 1000),
        latency_ms=_scaled(record, "latency_us", 1000),
        exposure_ms=record.exposure_us / 1000,
        gain_db=record.gain_cdb / 100,
        grey_mean=known(record, "grey_mean"),
        record=record,
    )


def _info(record, time, time_s):
    version = record.version_major, record.version_minor, record.version_patch
    place = record.unique_id.hex()
    return Started(time, time_s, record.board, place, version, record.width, record.height, record.boot)


_MAKERS = {"MARKER": _marker, "POSE": _pose, "MOTION": _motion, "STATUS": _status, "INFO": _info}
