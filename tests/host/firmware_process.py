"""Starts the firmware on a real MicroPython interpreter, with a pseudo-terminal as its UART."""

import contextlib
import os
import subprocess

from larics_host.connection.byte_sources import SerialSource
from larics_host.connection.pty_pair import PtyPair
from tests.host.test_dual import ROOT, unix_port

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
