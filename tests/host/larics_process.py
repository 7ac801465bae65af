"""The command `larics` as a process of its own, and a log for it to read."""

import os
import sys

from larics.wire import messages as m
from tests.host.test_dual import ROOT
from tests.host.test_log import marker_values, status_values, wire

ENVIRONMENT = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
COMMAND = [sys.executable, "-m", "larics_host"]


def recorded(folder):
    """A log of 200 MARKERs and a STATUS in this folder."""
    values = [(m.MARKER, marker_values(k)) for k in range(200)]
    path = folder / "run.bin"
    path.write_bytes(wire(*values, (m.STATUS, status_values())))
    return path
