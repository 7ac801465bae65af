"""Asks a camera for settings and raw frames while its messages go on: nothing waits for an answer.

The answers are messages like all others; whoever logs them can make of the log what was asked for.
"""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from larics import settings as setting_rules
from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host.connection.raw_frame import RawAssembly

if TYPE_CHECKING:
    from larics_host.connection.receiver import Message

_ANSWER_S = 0.5
_TRIES = 12
_STALL_S = 2.0  # of a raw frame, before the pixels that are missing are asked for again


class Asker:
    """Give it every message (`note`) and the time now and then (`step`); it writes its questions by
    `write(bytes)`.

    settings: names of those that are asked for at first, and again after each restart of the camera;
    pictures_s: time from the end of one raw frame to the next question, None for none. on_silence() is called
    once when the camera answers nothing at all.
    """

    def __init__(
        self,
        write: Callable[[bytes], object],
        settings: Iterable[str] = (),
        pictures_s: float | None = None,
        on_silence: Callable[[], object] | None = None,
    ) -> None:
        self._write = write
        self._settings = tuple(settings)
        self._pictures_s = pictures_s
        self._on_silence = on_silence
        self._encoder = protocol.Encoder()
        self._token = random.randrange(1, 65536)
        self._waiting: deque[tuple[int, tuple[int, ...]]] = deque()
        self._asked: tuple[int, tuple[int, ...]] | None = None
        self._asked_s = 0.0
        self._tries = 0
        self._answered = False
        self._boot: int | None = None
        self._transfer: RawAssembly | None = None  # the frame that comes
        self._raw_token: int | None = None
        self._again = 0
        self._chunk_s = 0.0
        self._picture_s: float | None = None  # when the next one is due
        self._now_s = 0.0
        self._ask_all()

    def _ask_all(self):
        self._waiting.clear()
        self._waiting.append((m.GET_INFO, ()))
        for name in self._settings:
            self._waiting.append((m.GET_SETTING, (setting_rules.field(name).key,)))

    def step(self, now_s: float) -> None:
        """Sends what is due; now_s on any clock that only goes forward. Raises what `write` raises."""
        self._now_s = now_s
        if self._asked is not None:
            if now_s - self._asked_s >= _ANSWER_S:
                if self._tries >= _TRIES:
                    self._give_up()
                else:
                    self._send()
            return
        if self._waiting:
            self._begin(*self._waiting.popleft())
        elif self._transfer is not None:
            if now_s - self._chunk_s >= _STALL_S:
                self._ask_again()
        elif self._pictures_s is not None and (self._picture_s is None or now_s >= self._picture_s):
            self._picture_s = now_s + self._pictures_s
            self._begin(m.GET_RAW, (m.RAW_WHOLE,))
            self._raw_token = self._token

    def note(self, message: Message) -> None:
        """Takes a message that came."""
        handler = getattr(self, "_of_" + message.name.lower(), None)
        if handler is not None:
            handler(message.fields)

    def _begin(self, command, values):
        self._token = self._token % 65535 + 1
        self._asked = command, values
        self._tries = 0
        self._send()

    def _send(self):
        command, values = self._asked
        self._tries += 1
        self._asked_s = self._now_s
        size = self._encoder.encode(command, [self._token, *values])
        # the leading 0 ends whatever noise the camera may have taken for a frame's beginning
        self._write(b"\0" + bytes(self._encoder.buffer[:size]))

    def _give_up(self):
        self._asked = None
        if not self._answered and self._on_silence is not None:
            self._waiting.clear()  # who is not heard need not ask on
            self._on_silence()
            self._on_silence = None

    def _of_ack(self, fields):
        if self._asked is not None and (fields.token, fields.command) == (self._token, self._asked[0]):
            self._answered = True
            self._asked = None

    _of_nack = _of_ack

    def _of_info(self, fields):
        self._note_boot(fields.boot)

    def _of_status(self, fields):
        self._note_boot(fields.boot)

    def _note_boot(self, boot):
        if self._boot not in (None, boot):
            self._transfer = self._raw_token = self._asked = None
            self._ask_all()
        self._boot = boot

    def _of_raw_header(self, fields):
        if fields.token == self._raw_token:  # before its ACK or after it
            if self._transfer is None or self._transfer.token != fields.token:
                self._transfer = RawAssembly(fields)
                self._again = 0
            self._chunk_s = self._now_s

    def _of_raw_chunk(self, fields):
        if self._transfer is None or not self._transfer.add(fields):
            return
        self._chunk_s = self._now_s
        self._again = 0
        if self._transfer.missing() is None:
            self._end_transfer()

    def _end_transfer(self):
        self._transfer = self._raw_token = None
        if self._pictures_s is not None:
            self._picture_s = self._now_s + self._pictures_s

    def _ask_again(self):
        """Asks for the first run of pixels that is missing."""
        self._again += 1
        self._chunk_s = self._now_s
        if self._again > _TRIES:
            self._end_transfer()
            return
        self._begin(m.GET_RAW_AGAIN, (self._transfer.token, *self._transfer.missing()))
