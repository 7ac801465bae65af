"""A recorded log played as a source of bytes, at the pace at which they came."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from larics_host.logs.log_reader import Piece, read_pieces

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_LONGEST_SLEEP_S = 1e6  # the operating system takes no more than some hundred years


class Pacer:
    """Waits until a Piece is due: at the speed of the recording times `speed`, not at all when that is 0.
    Bytes whose time is unknown take as long as on a line of `baud`."""

    def __init__(self, speed: float = 1.0, baud: int = 115200) -> None:
        self._speed = speed
        self._byte_s = 10 / baud
        self._origin_s: float | None = None
        self._recorded_s = 0.0

    def wait(self, piece: Piece) -> None:
        """Returns when the piece is due, at once where it is overdue."""
        if not self._speed:
            return
        if self._origin_s is None:
            self._origin_s = time.monotonic() - (piece.time_s or 0.0) / self._speed
        if piece.time_s is None:
            self._recorded_s += self._byte_s * len(piece.data)
        else:
            self._recorded_s = piece.time_s
        delay_s = self._origin_s + self._recorded_s / self._speed - time.monotonic()
        while delay_s > 0:
            time.sleep(min(delay_s, _LONGEST_SLEEP_S))
            delay_s -= _LONGEST_SLEEP_S


class LogSource:
    """A log as a source of bytes, like byte_sources.SerialSource, at the pace of a Pacer.

    `time_s` is when the bytes that were read last had come, as far as the log tells."""

    live = False

    def __init__(self, path: StrPath, speed: float = 0.0) -> None:
        self.name = str(path)
        self.time_s = 0.0
        self._untimed_bytes = 0  # since then
        self._pacer = Pacer(speed)
        self._pieces = read_pieces(path)

    def read(self) -> bytes | None:
        """The next bytes when they are due, or None at the end. UserError when the log cannot be read."""
        piece = next(self._pieces, None)
        if piece is None:
            return None
        self._pacer.wait(piece)
        self._untimed_bytes += len(piece.data)
        if piece.time_s is not None:
            self.time_s = piece.time_s
            self._untimed_bytes = 0
        return piece.data

    def likely_s(self, baud: int) -> float:
        """`time_s`, and for bytes whose time the log does not tell how long they take on a line of `baud`."""
        return self.time_s + self._untimed_bytes * 10 / baud

    def close(self) -> None:
        self._pieces.close()
