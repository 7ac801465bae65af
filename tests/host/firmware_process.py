"""Starts the firmware on a real MicroPython interpreter, with a pseudo-terminal as its UART."""

import contextlib
import os
import subprocess
import time

from larics_host.connection.byte_sources import SerialSource
from larics_host.connection.pty_pair import PtyPair
from tests.host.test_dual import ROOT, unix_port
from tests.host.waiting import PATIENCE_S

_END = b"\0the program has ended\0"
SEARCH = ":".join(["shared", "firmware", ".frozen"])


def environment(search=SEARCH):
    return dict(os.environ, MICROPYPATH=search)


def start_firmware(frames, port, *options, heap=None):
    """The process of firmware/pc/replay_main.py; `heap`: bytes, as text for -X heapsize."""
    heap_option = ["-X", "heapsize=" + heap] if heap else []
    program = [*unix_port(), *heap_option, "firmware/pc/replay_main.py"]
    command = [*program, "--frames", str(frames), "--port", port]
    return subprocess.Popen(
        [*command, *options],
        cwd=ROOT,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


@contextlib.contextmanager
def running_firmware(frames, *options, heap=None):
    """(process, PtyPair, SerialSource that was opened first and so misses nothing); all gone afterwards."""
    with PtyPair() as cable:
        source = SerialSource(cable.device_b)
        process = start_firmware(frames, cable.device_a, *options, heap=heap)
        try:
            yield process, cable, source
        finally:
            process.kill()
            process.wait()
            process.stdout.close()
            source.close()


def pieces(process, cable, source):
    """What the program sends, as it comes, until it has ended and all of it was read, however long either of
    them stood still: behind its last byte a mark is put on the line."""
    end_s = time.monotonic() + PATIENCE_S
    waiting, is_marked = b"", False
    while time.monotonic() < end_s:
        has_ended = process.poll() is not None
        data = source.read()
        if has_ended and not is_marked and not data:
            line = os.open(cable.device_a, os.O_WRONLY | os.O_NOCTTY)
            os.write(line, _END)
            os.close(line)
            is_marked = True
        waiting += data
        if _END in waiting:
            yield waiting.partition(_END)[0]
            return
        kept = len(_END) - 1 if is_marked else 0
        yield waiting[: len(waiting) - kept]
        waiting = waiting[len(waiting) - kept :]
    raise AssertionError("no end within %d s" % PATIENCE_S)
