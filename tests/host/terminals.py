"""What a command shows in a real terminal."""

import contextlib
import fcntl
import os
import struct
import subprocess
import sys
import termios

from tests.host.test_dual import ROOT
from tests.host.waiting import PATIENCE_S


def shown_in_terminal(*options, lines=24, columns=80):
    """The bytes that `larics OPTIONS` writes to a terminal of that size, until it ends well."""
    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("4H", lines, columns, 0, 0))
    environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"), TERM="xterm")
    environment.pop("COLUMNS", None)
    command = [sys.executable, "-m", "larics_host", *map(str, options)]
    process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=environment)
    os.close(slave)
    shown = b""
    with contextlib.suppress(OSError):
        while data := os.read(master, 65536):
            shown += data
    assert process.wait(timeout=PATIENCE_S) == 0
    os.close(master)
    return shown
