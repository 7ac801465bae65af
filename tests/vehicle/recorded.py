"""Streams on which earlier versions failed, in the layouts of the day they were recorded."""

import lzma
import struct
from pathlib import Path

from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder, fields

FOLDER = Path(__file__).parent / "streams"
# as they were recorded: (name of the field, code of struct)
_MARKER = (
    *(("frame", "I"), ("age_us", "I"), ("flags", "H"), ("id", "B"), ("index", "B"), ("count", "B")),
    *(("x_mm10", "i"), ("y_mm10", "i"), ("z_mm10", "i"), ("heading_cdeg", "H"), ("margin", "B")),
    ("radius_q8", "H"),
)
_POSE = (
    *(("frame", "I"), ("age_us", "I"), ("state", "B"), ("id", "B"), ("x_mm10", "i"), ("y_mm10", "i")),
    *(("heading_cdeg", "H"), ("sigma_mm10", "H"), ("sigma_cdeg", "H"), ("route_position", "H")),
    ("next_cdeg", "H"),
)
_VERSION = (("version_major", "B"), ("version_minor", "B"), ("version_patch", "B"))
_STATUS = (
    *_VERSION,
    *(("boot", "H"), ("uptime_s", "I"), ("frames", "I"), ("missed", "I"), ("detections", "I")),
    *(("rejects", "I"), ("drops", "I"), ("crc_errors", "I"), ("line_errors", "I"), ("faults", "I")),
    *(("last_fault", "B"), ("active_faults", "I"), ("state", "B"), ("exposure_us", "I"), ("gain_cdb", "H")),
    *(("grey_mean", "B"), ("rate_chz", "H"), ("frame_us", "I"), ("detect_us", "I"), ("latency_us", "I")),
    ("free_bytes", "I"),
)
_INFO = (
    *(("token", "H"), ("boot", "H"), *_VERSION, ("width", "H"), ("height", "H"), ("settings", "B")),
    *(("board", "16s"), ("unique_id", "12s")),
)
_LAYOUTS = {m.INFO: _INFO, m.MARKER: _MARKER, m.POSE: _POSE, m.STATUS: _STATUS}
_OLD_ID_NONE = 255


def message(number, **values):
    """The values of a message of today, in field order: those named, else what says "unknown" or 0."""
    unknown = {"id": m.ID_NONE, "route_position": m.ROUTE_NONE, "next_cdeg": m.DIRECTION_NONE}
    found = []
    for name, code, _, low, high, _ in fields(number):
        if name in values:
            found.append(values.pop(name))
        elif code[-1] == "s":
            found.append(bytes(int(code[:-1])))
        elif name.startswith("sigma"):
            found.append(m.SIGMA_UNKNOWN)
        else:
            found.append(min(max(unknown.get(name, 0), low), high))
    assert not values, values
    return found


def frame_of(number, values, sequence=0):
    """The bytes of a message on the line."""
    encoder = Encoder()
    encoder.sequence = sequence & 0xFFFF
    return bytes(encoder.buffer[: encoder.encode(number, values)])


def _uncobs(frame):
    content, place = bytearray(), 0
    while place < len(frame):
        content += frame[place + 1 : place + frame[place]] + b"\0"
        place += frame[place]
    return bytes(content[:-1])


def of_today(stream):
    """[(index of its last byte, type, sequence, values of today)] of a stream of then."""
    found, start = [], 0
    for end, byte in enumerate(stream):
        if byte:
            continue
        content, start = _uncobs(stream[start:end]), end + 1
        if len(content) < 8:
            continue
        layout = _LAYOUTS[content[1]]
        parts = struct.unpack("<" + "".join(code for _, code in layout), content[4:-4])
        values = dict(zip((name for name, _ in layout), parts, strict=True))
        if values.get("id") == _OLD_ID_NONE:
            values["id"] = m.ID_NONE
        if content[1] == m.POSE:  # its age was that of its marker
            values["marker_age_ms"] = min(m.AGE_UNKNOWN, values["age_us"] // 1000)
            values["sigma_x_mm10"] = values["sigma_y_mm10"] = values.pop("sigma_mm10")
        sequence = content[2] | content[3] << 8
        found.append((end, content[1], sequence, message(content[1], **values)))
    return found


def stream_of(name):
    return (FOLDER / name).read_bytes()


def timed_stream_of(name):
    """(bytes, [ms at which each byte was received]) of a record of (ms, length, bytes)."""
    data = lzma.decompress((FOLDER / name).read_bytes())
    stream, times, place = bytearray(), [], 0
    while place < len(data):
        now_ms, size = struct.unpack_from("<IB", data, place)
        stream += data[place + 5 : place + 5 + size]
        times += [now_ms] * size
        place += 5 + size
    return bytes(stream), times


class Stream:
    """Messages of a camera, numbered one after the other: `send(type, name=value, ...)` gives their bytes."""

    def __init__(self, boot=1000, unique_id=b"camera-one--"):
        self.sequence = 0
        self.frame = 0
        self.boot = boot
        self.unique_id = unique_id

    def send(self, number, **values):
        data = frame_of(number, message(number, **values), self.sequence)
        self.sequence = (self.sequence + 1) & 0xFFFF
        return data

    def info(self, token=0):
        return self.send(m.INFO, token=token, boot=self.boot, unique_id=self.unique_id)

    def status(self, uptime_s, **values):
        return self.send(m.STATUS, boot=self.boot, uptime_s=uptime_s, state=m.TRACKING, **values)

    def answer(self, request):
        """What a camera says to a PING or GET_INFO."""
        asked = []
        decoder = Decoder(lambda number, _, values: asked.append((number, values[0])))
        decoder.feed(request, len(request))
        number, token = asked[0]
        data = self.info(token) if number == m.GET_INFO else b""
        return data + self.send(m.ACK, token=token, command=number)

    def marker(self, marker_id=3, x=100, y=0, noise=None, frame=None, **values):
        """A frame with one marker; the noise of its sensor is in z."""
        if frame is None:
            self.frame = (self.frame + 1) % (m.COUNT_MAX + 1)
            frame = self.frame
        values.setdefault("count", 1)
        z = 25000 + (frame if noise is None else noise) % 7
        return self.send(
            m.MARKER,
            **(
                {"frame": frame, "age_us": 15000, "id": marker_id, "x_mm10": x, "y_mm10": y, "z_mm10": z}
                | values
            ),
        )

    def nothing(self):
        return self.marker(m.ID_NONE, x=0, count=0, flags=m.MARKER_NONE, z_mm10=0)

    def pose(self, **values):
        given = {"frame": self.frame, "age_us": 20000, "marker_age_ms": 20, "state": m.TRACKING, "id": 3}
        given |= {"sigma_x_mm10": 20, "sigma_y_mm10": 30, "sigma_cdeg": 15}
        return self.send(m.POSE, **(given | values))
