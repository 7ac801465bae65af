"""The host's side of the commands: requests with a token, repeated until they are answered.

    client = Client(SerialSource("/dev/ttyACM0"))
    client.get("ceiling_mm10")
    client.set("route", [3, 1, 2])
    client.save()

Measurements go on meanwhile; `on_message(type, sequence, values)` gets every message that is no answer.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from larics import settings as setting_rules
from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import wire_names as codes
from larics_host.connection.decoder import Decoder
from larics_host.connection.line_watch import LineWatch
from larics_host.connection.raw_frame import RawAssembly, RawFrame
from larics_host.connection.records import Ack, Info, Setting, record_of
from larics_host.errors import UserError

PATIENT = 12  # tries of commands for people: a camera, or this computer, may stand still for seconds
_ANSWERS = (m.ACK, m.NACK, m.INFO, m.SETTING, m.RAW_HEADER, m.RAW_CHUNK)

if TYPE_CHECKING:
    from larics_host.annotations import Stream


class NoAnswer(UserError):
    """The camera did not answer in time."""


class Restarted(UserError):
    """The camera has begun anew while it was asked: what was set and not saved is lost."""


class Refused(UserError):
    """The camera answered NACK; `reason` is its number."""

    def __init__(self, text: str, reason: int) -> None:
        super().__init__(text)
        self.reason = reason


class Client:
    """Talks to a camera over `stream`: read() -> bytes that arrived, b"" after a short wait, None at the
    end; write(bytes).

    timeout_s is how long one request waits before it is sent again, retries how often it is sent.
    """

    def __init__(
        self,
        stream: Stream,
        on_message: Callable[[int, int, Sequence[Any]], object] | None = None,
        timeout_s: float = 0.5,
        retries: int = 6,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.decoder = Decoder(self._arrived)
        self.watch = LineWatch()
        self._stream = stream
        self._on_message = on_message
        self._timeout_s = timeout_s
        self._retries = retries
        self._clock = clock
        self._encoder = protocol.Encoder()
        self._token = random.randrange(1, 65536)
        self._boot: int | None = None
        self._answer = None
        self._waiting_for = None
        self._data: list[Sequence[Any]] = []
        self._raw_token = 0
        self._raw: RawAssembly | None = None

    # commands

    def ping(self) -> None:
        self._request(m.PING)

    def info(self) -> Info:
        """The records.Info of the camera."""
        for record in self._request(m.GET_INFO):
            if isinstance(record, Info):
                return record
        raise NoAnswer("the camera acknowledged, but its INFO was lost: try again")

    def get(self, name: str) -> Any:
        """The value of a setting, as in `larics.settings`."""
        field = _field(name)
        for _ in range(self._retries):
            parts = {}
            length = 0
            for record in self._request(m.GET_SETTING, field.key):
                if isinstance(record, Setting):
                    length = record.count
                    for k, number in enumerate(record.values):
                        parts[record.first + k] = number
            numbers = [parts[k] for k in range(length) if k in parts]
            if parts and len(numbers) == length:
                return field.value(numbers)
        raise NoAnswer("the answer for the setting %s keeps getting lost" % name)

    def get_all(self, names: Iterable[str]) -> dict[str, Any]:
        """{name: value} of those of the settings that the camera has: older firmware may lack some."""
        found = {}
        for name in names:
            try:
                found[name] = self.get(name)
            except Refused as error:
                if error.reason != m.NACK_UNKNOWN_KEY:
                    raise
        return found

    def set(self, name: str, value: Any) -> None:
        """Changes a setting until the next start; `save` makes it permanent. Raises UserError."""
        field = _field(name)
        reason = field.reason(value)
        if reason:
            raise UserError(reason)
        numbers = field.numbers(value)
        first = 0
        while True:
            part = numbers[first : first + m.SETTING_VALUES]
            padding = [0] * (m.SETTING_VALUES - len(part))
            self._request(m.SET_SETTING, field.key, first, len(numbers), *part, *padding)
            first += m.SETTING_VALUES
            if first >= len(numbers):
                return

    def save(self) -> None:
        self._request(m.SAVE_SETTINGS, timeout_s=max(2.0, self._timeout_s))

    def restart(self) -> None:
        boot = self.info().boot
        try:
            self._request(m.RESTART, boot)
        except Refused as error:
            if error.reason != m.NACK_BOOT:  # its ACK was lost and it has restarted already
                raise

    def raw_frame(
        self,
        progress: Callable[[int, int], object] | None = None,
        stall_s: float = 5.0,
        around_markers: bool = False,
    ) -> RawFrame:
        """One RawFrame, or what of it is around its markers; `progress(received, total)` is called as pixels
        come. Raises UserError."""
        self._raw = None
        self._raw_token = token = self._next_token()
        window = m.RAW_MARKERS if around_markers else m.RAW_WHOLE
        self._request(m.GET_RAW, window, token=token, want_header=True)
        raw: Any = self._raw
        known = raw.received
        silent_s = 4 * self._timeout_s
        last = asked = self._clock()
        boot = self._boot
        while known < raw.size:
            now = self._clock()
            self.poll()
            self._check_boot(boot)
            if raw.received != known:
                known = raw.received
                last = asked = now
                if progress:
                    progress(known, raw.size)
            elif now - last > silent_s + stall_s:
                raise NoAnswer("the raw frame stopped at %d of %d pixels" % (known, raw.size))
            elif now - asked > silent_s:
                self._ask_again(raw)
                asked = self._clock()
        frame = raw.frame()
        if frame is None:
            raise UserError("the raw frame arrived damaged: its checksum differs; try again")
        return frame

    def _ask_again(self, raw):
        """Asks for the first run of pixels that is missing."""
        try:
            self._request(m.GET_RAW_AGAIN, raw.token, *raw.missing())
        except Refused as error:
            if error.reason != m.NACK_BUSY:
                raise

    # requests and answers

    def _next_token(self):
        self._token = self._token % 65535 + 1
        return self._token

    def _request(self, command, *values, token=None, timeout_s=None, want_header=False):
        """Sends a command until it is answered; returns the records that came before the ACK."""
        token = token or self._next_token()
        self._answer = None
        self._data = []
        self._waiting_for = (token, command)
        boot = self._boot
        try:
            for _ in range(self._retries):
                size = self._encoder.encode(command, [token, *values])
                # the leading 0 ends whatever noise the camera may have taken for a frame's beginning
                self._stream.write(b"\0" + bytes(self._encoder.buffer[:size]))
                end = self._clock() + (timeout_s or self._timeout_s)
                is_over = False
                while not is_over:
                    is_over = self._clock() >= end  # what came while this program stood still counts, too
                    self.poll()
                    if command != m.RESTART:
                        self._check_boot(boot)
                    acknowledged = isinstance(self._answer, Ack)
                    if self._answer and not (want_header and acknowledged and not self._raw):
                        return self._result(command)
        finally:
            self._waiting_for = None
        asked = "no answer to %s after %d tries" % (protocol.name(command), self._retries)
        raise NoAnswer("%s; %s" % (asked, self.why_silent()))

    def why_silent(self) -> str:
        """The likely cause when a camera does not answer, by what came meanwhile."""
        if self.decoder.counters.messages:
            return "its messages come, so this TX does not reach its RX, or it is busy"
        return "what came is " + self.watch.explain(self.decoder.counters, getattr(self._stream, "baud", 0))

    def _result(self, command):
        answer = self._answer
        if isinstance(answer, Ack):
            return self._data
        why = codes.name_of("NACK reason", answer.reason)
        field = setting_rules.field(answer.detail) if answer.detail else None
        place = " for %s" % field.name if field else ""
        raise Refused("the camera refused %s%s: %s" % (protocol.name(command), place, why), answer.reason)

    def poll(self) -> None:
        """Reads once and hands on what came. NoAnswer at the end of the line."""
        data = self._stream.read()
        if data is None:
            raise NoAnswer("the line ended")
        self.watch.feed(data)
        self.decoder.feed(data, len(data))

    def _check_boot(self, boot):
        if boot is not None and self._boot != boot:
            raise Restarted("the camera restarted meanwhile: what was not saved is lost; do it again")

    def _arrived(self, number, sequence, values):
        if number in (m.INFO, m.STATUS):
            self._boot = record_of(number, values).boot
        if number not in _ANSWERS:
            if self._on_message:
                self._on_message(number, sequence, values)
            return
        record = record_of(number, values)
        expected = self._waiting_for
        if number in (m.ACK, m.NACK):
            if expected == (record.token, record.command):
                self._answer = record
        elif number == m.RAW_HEADER:
            if record.token == self._raw_token and self._raw is None:
                self._raw = RawAssembly(record)
        elif number == m.RAW_CHUNK:
            if self._raw is not None:
                self._raw.add(record)
        elif expected and record.token == expected[0]:
            self._data.append(record)
        elif self._on_message:  # INFO at start
            self._on_message(number, sequence, values)


def _field(name):
    field = setting_rules.field(name)
    if field is None:
        known = ", ".join(entry.name for entry in setting_rules.FIELDS)
        raise UserError("there is no setting %s; there are: %s" % (name, known))
    return field
