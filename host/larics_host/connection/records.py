"""Messages by the names of their fields.

A record holds what `larics.wire.messages` defines, in its order and its units; text fields are str, other
byte fields bytes.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from larics.wire import codec as protocol
from larics.wire import messages
from larics_host import wire_names as codes

# generated: begin (tools/make_protocol.py)


class Info(NamedTuple):
    """Who is speaking: at start and as answer to GET_INFO."""

    token: int  # of GET_INFO; 0 at start
    boot: int  # drawn at random at each start; RESTART needs it
    version_major: int  # version of the firmware
    version_minor: int  # version of the firmware
    version_patch: int  # version of the firmware
    width: int  # frame width, px
    height: int  # frame height, px
    settings: int  # highest key of a setting
    board: str  # board name, ASCII, padded with 0
    unique_id: bytes  # unique ID of the processor, padded with 0


class Marker(NamedTuple):
    """One marker in one processed frame; sent with count 0 when the frame has none."""

    frame: int  # number of the camera frame, wraps to 0 after 2**30 - 1
    age_us: int  # from the middle of the exposure to the start of sending, us
    flags: int  # sum of MARKER flags; others may follow and are ignored
    id: int  # marker ID, or 65535 for none or uncertain
    index: int  # type: ignore[assignment]  # which of the markers of this frame, 0..count-1; 0 when count is 0
    count: int  # type: ignore[assignment]  # number of markers in this frame
    x_mm10: int  # marker centre minus vehicle origin, forward, 0.1 mm
    y_mm10: int  # the same, to the left, 0.1 mm
    z_mm10: int  # the same, up, 0.1 mm
    heading_cdeg: int  # orientation line, vehicle frame, ccw from above, 0.01 deg
    margin: int  # how far the weakest decision is from its limit
    radius_q8: int  # outer ring in the image; 65535 for that and more, 1/256 px
    sigma_q12: int  # standard deviation of the centre; 65535 unknown, 1/4096 px
    sigma_mdeg: int  # standard deviation of the heading; 65535 unknown, 0.001 deg


class Pose(NamedTuple):
    """The vehicle in the map, once for each processed frame when there is a map."""

    frame: int  # number of the camera frame, wraps to 0 after 2**30 - 1
    age_us: int  # from the middle of the exposure to the start of sending, us
    marker_age_ms: int  # since the last marker it rests on; 65535 none, or more, ms
    state: int  # POSE state
    id: int  # that marker, 65535 for none
    x_mm10: int  # vehicle origin, map frame; unknown when LOST, 0.1 mm
    y_mm10: int  # vehicle origin, map frame; unknown when LOST, 0.1 mm
    heading_cdeg: int  # vehicle's x axis, map frame, ccw; 36000 unknown, 0.01 deg
    sigma_x_mm10: int  # standard deviation of x; 65535 unknown, 0.1 mm
    sigma_y_mm10: int  # standard deviation of y; 65535 unknown, 0.1 mm
    correlation_q14: int  # of the errors of x and y; 0 if unknown, 1/16384
    sigma_cdeg: int  # standard deviation of the heading; 65535 unknown, 0.01 deg
    way_mm: int  # driven since that marker, by odometry; 65535 unknown, or more, mm
    route_position: int  # index in the route of the marker reached; 65535 none
    next_cdeg: int  # direction to go on, vehicle frame; 36000 none, 0.01 deg


class Status(NamedTuple):
    """Health, once a second; counters since start."""

    version_major: int  # version of the firmware
    version_minor: int  # version of the firmware
    version_patch: int  # version of the firmware
    boot: int  # as in INFO
    uptime_s: int  # time since start, s
    frames: int  # frames processed
    missed: int  # camera frames not processed, because a newer one was there
    detections: int  # markers reported
    rejects: int  # candidates refused
    drops: int  # measurements replaced by newer ones before they were sent
    crc_errors: int  # received frames with a wrong CRC
    line_errors: int  # received frames refused for any other reason
    faults: int  # number of faults
    last_fault: int  # code of the last fault, 0 for none
    active_faults: int  # faults that last: bit n stands for code n
    state: int  # POSE state; without a map, of the marker
    exposure_us: int  # exposure time, us
    gain_cdb: int  # camera gain, 0.01 dB
    grey_mean: int  # mean grey of the last frame, 0..255; 65535 without one
    rate_chz: int  # frames processed a second; 65535 not yet known, 0.01 Hz
    frame_us: int  # mean time from frame to frame in this second, if any, us
    detect_us: int  # mean time of a detection in this second, if any, us
    latency_us: int  # longest time from capture to sending of it, if any, us
    free_bytes: int  # free heap after a collection, measured each 30 s
    unanswered: int  # commands left unanswered, because too many came at once
    clamped: int  # values reported as the nearest that their field can hold
    odometry_used: int  # ODOMETRY messages taken into use
    odometry_refused: int  # those that came twice or out of order
    odometry_stale: int  # those that came too late to be of use
    odometry_jumps: int  # times that it began anew: reset, jump, other clock


class Ack(NamedTuple):
    """The command was carried out; after the data it asked for."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    command: int  # type number of the command


class Nack(NamedTuple):
    """The command was refused and changed nothing."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    command: int  # type number of the command
    reason: int  # NACK reason
    detail: int  # key of the setting in question, else 0


class Setting(NamedTuple):
    """Up to eight values of one setting: answer to GET_SETTING."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    key: int  # number of the setting
    first: int  # index of value0 within a list; 0 for single values
    count: int  # type: ignore[assignment]  # length of the whole list; 1 for single values
    value0: int  # value of index first + k; 0 where there is none
    value1: int
    value2: int
    value3: int
    value4: int
    value5: int
    value6: int
    value7: int

    @property
    def values(self) -> tuple[int, ...]:
        """value0 and all after it."""
        return self[4:]


class RawHeader(NamedTuple):
    """What the raw frame is, or the window of it, whose chunks follow."""

    token: int  # of GET_RAW; names the transfer
    frame: int  # number of the camera frame, wraps to 0 after 2**30 - 1
    width: int  # frame width, px
    height: int  # frame height, px
    left: int  # first column of the window, px
    top: int  # first row of the window, px
    columns: int  # width of the window; that of the frame when it is whole, px
    rows: int  # height of the window, px
    crc_low: int  # CRC-32 of the window's pixels row by row, low half
    crc_high: int  # CRC-32 of the window's pixels, high half


class RawChunk(NamedTuple):
    """Pixels of a raw frame, packed without loss; sent when the line is otherwise idle."""

    token: int  # of GET_RAW
    first: int  # number of the first pixel, in strips of 16 columns
    count: int  # type: ignore[assignment]  # number of pixels
    coding: int  # Rice parameter 0..7, or 8: plain bytes
    data: bytes  # the pixels; 0 after the last one


class Motion(NamedTuple):
    """The vehicle's odometry at the exposure of a processed frame, as the camera used it; once it has any."""

    frame: int  # number of the camera frame, wraps to 0 after 2**30 - 1
    state: int  # MOTION state
    epoch: int  # of the ODOMETRY used
    x_mm10: int  # odometry frame, in the middle of the exposure, 0.1 mm
    y_mm10: int  # the same, to the left, 0.1 mm
    heading_cdeg: int  # the same, counterclockwise, 0.01 deg
    way_mm10: int  # driven since the start, to and fro, wraps to 0, 0.1 mm
    turn_cdeg: int  # turned since the start, to and fro, wraps to 0, 0.01 deg
    odometry_age_us: int  # from the newest odometry to the exposure; 0: none, us


class GetInfo(NamedTuple):
    """Answered by INFO, then ACK."""

    token: int  # returned by the answer; a retry repeats it, a new command does not


class Ping(NamedTuple):
    """Answered by ACK."""

    token: int  # returned by the answer; a retry repeats it, a new command does not


class GetSetting(NamedTuple):
    """Answered by SETTING, one for each eight values, then ACK."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    key: int  # number of the setting


class SetSetting(NamedTuple):
    """Up to eight values; a list takes effect with its last part."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    key: int  # number of the setting
    first: int  # index of value0 within a list; 0 for single values
    count: int  # type: ignore[assignment]  # length of the whole list; 1 for single values
    value0: int  # value of index first + k; 0 where there is none
    value1: int
    value2: int
    value3: int
    value4: int
    value5: int
    value6: int
    value7: int

    @property
    def values(self) -> tuple[int, ...]:
        """value0 and all after it."""
        return self[4:]


class SaveSettings(NamedTuple):
    """Writes all settings to flash."""

    token: int  # returned by the answer; a retry repeats it, a new command does not


class GetRaw(NamedTuple):
    """Answered by RAW_HEADER and ACK, then all RAW_CHUNKs."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    window: int  # window of the frame


class GetRawAgain(NamedTuple):
    """Sends pixels again, of the frame still kept."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    transfer: int  # token of the GET_RAW
    first: int  # number of the first pixel, as in RAW_CHUNK
    count: int  # type: ignore[assignment]  # number of pixels


class Restart(NamedTuple):
    """Restarts after its ACK was sent."""

    token: int  # returned by the answer; a retry repeats it, a new command does not
    boot: int  # from INFO or STATUS, so that a retry cannot restart twice


class Odometry(NamedTuple):
    """Where the vehicle is by its wheels, up to 100 times a second; not answered."""

    time_us: int  # when it was sampled, on the vehicle's clock; wraps to 0, us
    age_us: int  # from then to the start of sending, us
    x_mm10: int  # odometry frame; cumulative since its start, 0.1 mm
    y_mm10: int  # the same, to the left, 0.1 mm
    heading_cdeg: int  # vehicle's x axis in that frame, counterclockwise, 0.01 deg
    epoch: int  # another one after each jump or reset of x, y, heading or time_us
    flags: int  # sum of ODOMETRY flags; others may follow and are ignored


RECORDS = {
    messages.INFO: Info,
    messages.MARKER: Marker,
    messages.POSE: Pose,
    messages.STATUS: Status,
    messages.ACK: Ack,
    messages.NACK: Nack,
    messages.SETTING: Setting,
    messages.RAW_HEADER: RawHeader,
    messages.RAW_CHUNK: RawChunk,
    messages.MOTION: Motion,
    messages.GET_INFO: GetInfo,
    messages.PING: Ping,
    messages.GET_SETTING: GetSetting,
    messages.SET_SETTING: SetSetting,
    messages.SAVE_SETTINGS: SaveSettings,
    messages.GET_RAW: GetRaw,
    messages.GET_RAW_AGAIN: GetRawAgain,
    messages.RESTART: Restart,
    messages.ODOMETRY: Odometry,
}


# generated: end


def record_of(number: int, values: Sequence[Any]) -> Any:
    """The record of what a Decoder hands out; copies what the decoder will reuse. KeyError: unknown type."""
    plain = []
    for field, value in zip(protocol.fields(number), values, strict=True):
        if field[0] in codes.TEXT_FIELDS:
            value = bytes(value).rstrip(b"\0").decode("latin-1")
        elif isinstance(value, bytearray):
            value = bytes(value)
        plain.append(value)
    return RECORDS[number](*plain)


def known(record: Any, field: str) -> Any:
    """The value of a field, None when it is not known or there is none: an ID that is uncertain, the place of
    a camera that is LOST, an offset without a calibration."""
    value = getattr(record, field)
    if value == codes.UNKNOWN.get(field):
        return None
    if isinstance(record, Marker) and value == 0:
        for flag, fields in codes.UNKNOWN_BY_FLAG.items():
            if record.flags & flag and field in fields:
                return None
    return value


def as_json(record: Any) -> dict[str, Any]:
    """The fields as logs show them: bytes as hexadecimal digits; None for what is not known."""
    fields = {name: known(record, name) for name in record._fields}
    return {name: value.hex() if isinstance(value, bytes) else value for name, value in fields.items()}
