"""The wire's decoder, for whoever reads recordings as well as cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host.connection.records import record_of


class _Status(NamedTuple):
    """What a STATUS told, and what had been counted then."""

    boot: int
    uptime_s: int
    sequence: int
    gaps: int
    restarts: int


class Decoder(protocol.Decoder):
    """larics.wire.codec.Decoder that knows recordings.

    A STATUS whose uptime goes back within a boot tells that a recording begins anew, as where logs are
    joined: what is missing since the STATUS before is then a restart and no loss."""

    def __init__(self, on_message: Callable[[int, int, Sequence[Any]], object]) -> None:
        super().__init__(self._take)
        self._hand_on = on_message
        self._status: _Status | None = None

    def _take(self, number, sequence, values):
        if number == m.STATUS:
            self._hear_status(record_of(number, values), sequence)
        self._hand_on(number, sequence, values)

    def _hear_status(self, fields, sequence):
        counters, before = self.counters, self._status
        if before and before.boot == fields.boot and fields.uptime_s < before.uptime_s:
            if (before.sequence - sequence) & 0xFFFF < protocol.LATE:
                return  # it was overtaken
            counters.gaps, counters.restarts = before.gaps, (before.restarts + 1) & m.COUNT_MAX
        self._status = _Status(fields.boot, fields.uptime_s, sequence, counters.gaps, counters.restarts)
