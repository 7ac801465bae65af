"""A camera as a Python object: what it tells, in a loop, and its settings.

with Camera("/dev/ttyACM0") as camera:      # or "tcp://127.0.0.1:7007", or a log of larics log
    for item in camera:
        ...

async with Camera("/dev/ttyACM0") as camera:
    async for item in camera:
        ...
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import threading
import time
from collections import deque
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

import numpy as np

from larics import settings as setting_rules
from larics_host.api.items import Item, Measurement, Pose, item_of
from larics_host.connection.byte_sources import ConnectionLost, ReconnectingSource
from larics_host.connection.client import PATIENT, Client
from larics_host.connection.frame_times import FrameTimes
from larics_host.connection.lines import is_address, open_line
from larics_host.connection.receiver import message_of
from larics_host.errors import UserError
from larics_host.logs.log_reader import read_pieces, start_of
from larics_host.logs.log_source import LogSource
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath

_WAITING_MOST = 10000  # items
_POLL_S = 0.05
_LOG = logging.getLogger("larics_host")


class CameraError(UserError):
    """Whatever goes wrong with a Camera: its text is one line that says what is wrong and what to do."""


@dataclass(frozen=True)
class Picture:
    """A raw frame: (height, width) uint8, its number, and the middle of its exposure, None when that is not
    known."""

    pixels: np.ndarray
    frame: int
    time: datetime | None


class Camera:
    """source: a serial port, tcp://HOST:PORT, or the path of a log (.jsonl, .csv, .mcap, .bin); a path is a
    log when there is such a file.

    baud: of a port. timeout_s: a live camera of which no message comes for so long is an error; None waits
    for ever (a camera tells its health once a second). reconnect: a line that has gone is waited for, as long
    as timeout_s allows. speed: of a log, 1 for its own pace, 0 at once.

    A context manager, for `with` and `async with`. It is iterated once, from whichever side, and yields Items
    as they come; a log ends, a live camera does not. Items that come while something is asked wait; of more
    than ten thousand the oldest are dropped, and counted. Every error is a CameraError. One thread at a time
    may iterate; the commands may be called from others.
    """

    def __init__(
        self,
        source: StrPath,
        *,
        baud: int = 115200,
        timeout_s: float | None = 5.0,
        reconnect: bool = False,
        speed: float = 0.0,
    ) -> None:
        if timeout_s is not None and not timeout_s > 0:
            raise CameraError("timeout_s is %g: give seconds above 0, or None" % timeout_s)
        if not speed >= 0:
            raise CameraError("speed is %g: give 1 for the log's own pace, 0 for at once" % speed)
        self.name = os.fspath(source)
        self.dropped = 0  # items that nobody took in time
        self._baud = baud
        self._timeout_s = timeout_s
        self._reconnect = reconnect
        self._speed = speed
        self._lock = threading.RLock()
        self._items: deque[Item] = deque()
        self._times = FrameTimes()
        self._source: Any = None
        self._client: Client | None = None
        self._start_ns: int | None = None  # wall clock at time_s 0 of a log
        self._dated = True  # whether the time of day is known
        self._start_s = self._heard_s = 0.0
        self._ended = False

    def open(self) -> Camera:
        """Opens the source; `with` does it."""
        with self._lock, _one_error():
            if self._source is not None:
                raise CameraError("%s is open already" % self.name)
            self._ended = False
            if os.path.isfile(self.name) and not is_address(self.name):
                next(read_pieces(self.name))  # what cannot be read is told at once
                self._start_ns = start_of(self.name)
                self._dated = self._start_ns is not None
                self._source = LogSource(self.name, self._speed)
            else:
                self._source = open_line(self.name, self._baud, _POLL_S)
                self._dated = True
                if self._reconnect:
                    self._source = ReconnectingSource(self._source, _LOG.warning)
            self._start_s = self._heard_s = time.monotonic()
            self._client = Client(self._source, self._arrived, retries=PATIENT)
        return self

    def close(self) -> None:
        """Closes the source; what has come and was not taken is gone."""
        with self._lock:
            if self._source is not None:
                self._source.close()
            self._source = self._client = None
            self._items.clear()

    def __enter__(self) -> Camera:
        return self.open()

    def __exit__(self, *_: object) -> None:
        self.close()

    async def __aenter__(self) -> Camera:
        return await asyncio.to_thread(self.open)

    async def __aexit__(self, *_: object) -> None:
        await asyncio.to_thread(self.close)

    # iteration

    def __iter__(self) -> Iterator[Item]:
        return self

    def __next__(self) -> Item:
        since_s = time.monotonic()
        while not self._items:
            if not self._poll(since_s):
                raise StopIteration
        return self._items.popleft()

    def __aiter__(self) -> AsyncIterator[Item]:
        return self

    async def __anext__(self) -> Item:
        since_s = time.monotonic()
        # an item is taken here and not in the thread, so that none is lost when this is cancelled
        while not self._items:
            if not await asyncio.to_thread(self._poll, since_s):
                raise StopAsyncIteration
        return self._items.popleft()

    def measurements(self) -> Iterator[Measurement]:
        """The markers alone."""
        return (item for item in self if isinstance(item, Measurement))

    def poses(self) -> Iterator[Pose]:
        """The poses alone, those that are lost, too."""
        return (item for item in self if isinstance(item, Pose))

    def _poll(self, since_s):
        """Reads once; False when there is no more. since_s: when waiting began."""
        with self._lock, _one_error():
            client = self._opened()
            if self._ended:
                return False
            if not self._source.live:
                data = self._source.read()
                if data is None:
                    self._ended = True
                    return bool(self._items)
                client.decoder.feed(data, len(data))
                return True
            now_s = time.monotonic()  # before reading: what came while this program stood still counts
            client.poll()
            silent_s = now_s - max(since_s, self._heard_s)
            if not self._items and self._timeout_s is not None and silent_s >= self._timeout_s:
                raise CameraError(
                    "no message from %s for %g s; %s" % (self.name, self._timeout_s, self._why_silent())
                )
            return True

    def _why_silent(self):
        counters = self._client.decoder.counters
        if counters.messages:
            return "it fell silent after %s: power, cable, or a program that ended" % counted(
                counters.messages, "message"
            )
        return self._client.why_silent()

    def _opened(self):
        if self._client is None:
            raise CameraError("the camera %s is not open: use `with Camera(...) as camera`" % self.name)
        return self._client

    def _arrived(self, number, sequence, values):
        self._heard_s = time.monotonic()
        if self._source.live:
            time_s, received_ns = self._heard_s - self._start_s, time.time_ns()
        else:
            time_s = self._source.likely_s(self._baud)
            received_ns = round(time_s * 1e9) + (self._start_ns or 0)
        message = message_of(number, sequence, values, time_s)
        told_ns = self._times.of(message.fields, received_ns)
        item = item_of(
            message.fields, message.name, self._time(told_ns), time_s - (received_ns - told_ns) / 1e9
        )
        if item is None:
            return
        if len(self._items) >= _WAITING_MOST:
            self._items.popleft()
            self.dropped += 1
        self._items.append(item)

    def _time(self, ns):
        if not self._dated:
            return None
        return datetime.fromtimestamp(0, UTC) + timedelta(microseconds=ns // 1000)

    # commands

    @property
    def lost(self) -> int:
        """Messages that were sent and did not arrive, by their numbers, or arrived damaged."""
        counters = self._opened().decoder.counters
        return max(counters.gaps, counters.crc + counters.cobs + counters.length + counters.over_long)

    def get(self, name: str) -> Any:
        """The value of a setting, as in `larics settings show`."""
        with self._lock, _one_error():
            return self._live().get(name)

    def set(self, name: str, value: Any) -> None:
        """Changes a setting until the camera's next start; `save` makes that permanent."""
        with self._lock, _one_error():
            self._live().set(name, value)

    def settings(self) -> dict[str, Any]:
        """All settings that the camera has."""
        with self._lock, _one_error():
            return self._live().get_all(field.name for field in setting_rules.FIELDS)

    def save(self) -> None:
        """Keeps the settings over a restart."""
        with self._lock, _one_error():
            self._live().save()

    def restart(self) -> None:
        """Restarts the camera."""
        with self._lock, _one_error():
            self._live().restart()

    def picture(self, around_markers: bool = False) -> Picture:
        """The raw frame of now, or what is around its markers (the rest then repeats the border of that).
        At 115200 baud a frame of 320 x 240 px takes 5 to 10 s beside 60 measurements a second."""
        with self._lock, _one_error():
            raw = self._live().raw_frame(around_markers=around_markers)
            told_ns = self._times.get(raw.frame)
            return Picture(raw.array(), raw.frame, None if told_ns is None else self._time(told_ns))

    def _live(self):
        client = self._opened()
        if not self._source.live:
            raise CameraError("%s is a log, which cannot be asked" % self.name)
        return client


@contextlib.contextmanager
def _one_error():
    try:
        yield
    except CameraError:
        raise
    except (UserError, ConnectionLost) as error:
        raise CameraError(" ".join(str(error).split())) from error
