"""Serial ports of this computer: opened for one program alone, and found again under another name.

A port that two programs read gives each of them half. So it is locked (flock, which many agree on) and, where
the system has it, closed to all others (TIOCEXCL); who had it open before is named.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import serial
from serial.tools import list_ports

from larics_host.errors import UserError

_BUSY = (errno.EAGAIN, errno.EBUSY, errno.EWOULDBLOCK)


def open_port(port: str, baud: int, timeout_s: float, write_timeout_s: float | None = None) -> serial.Serial:
    """An open serial.Serial that no other program has. UserError, with who has it, when that cannot be."""
    try:
        opened = serial.Serial(port, baud, timeout=timeout_s, write_timeout=write_timeout_s, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise UserError(_why_not_open(port, error)) from error
    others = holders(port) if not _is_pseudo(port) else []
    if others:
        opened.close()
        raise UserError(busy_text(port, others))
    close_to_others(opened, port)
    return opened


def close_to_others(opened: serial.Serial, port: str) -> None:
    """From now on nobody else can open the port. Not a pseudo-terminal: its maker looks at both ends."""
    with contextlib.suppress(ImportError, AttributeError, OSError, serial.SerialException):
        import fcntl
        import termios

        if not _is_pseudo(port):
            fcntl.ioctl(opened.fileno(), termios.TIOCEXCL)


def _is_pseudo(port):
    return os.path.realpath(port).startswith("/dev/pts/")


def holders(port: str) -> list[str]:
    """Other programs that have the port open, as "larics log (process 123)"; as far as this user may see."""
    wanted = os.path.realpath(port)
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        if int(process.name) == os.getpid():
            continue
        with contextlib.suppress(OSError):
            if any(os.readlink(entry) == wanted for entry in os.scandir(process / "fd")):
                found.append("%s (process %s)" % (_program(process), process.name))
    return sorted(found)


def _program(process):
    words = [
        word for word in (process / "cmdline").read_bytes().decode("utf-8", "replace").split("\0") if word
    ]
    names = [os.path.basename(word) for word in words[:1]]
    if names and re.fullmatch(r"python[\d.]*", names[0]):  # the script says more than the interpreter
        rest = words[2:] if words[1:2] == ["-m"] else words[1:]
        names = [os.path.basename(word) for word in rest[:1]] or names
        words = words[len(words) - len(rest) :] or words
    if names and names[0] in ("larics", "larics_host"):
        names = ["larics", *words[1:2]]
    return " ".join(names) or "a program"


def busy_text(port: str, others: Iterable[str] = ()) -> str:
    """The line for a port that somebody else has."""
    who = " and ".join(others) or "another program"
    return "the port %s is in use by %s: two programs on one port would each get half; end that one first" % (
        port,
        who,
    )


def why_shut(port: str) -> str:
    """What keeps a port shut for good: somebody else has it, or it is none; empty where it may yet open."""
    try:
        serial.Serial(port, exclusive=True).close()
    except (serial.SerialException, OSError, ValueError) as error:
        if getattr(error, "errno", None) in _BUSY:
            return busy_text(port, holders(port))
        return why_no_port(port, error) if os.path.exists(port) else ""
    return ""


def why_no_port(port: str, error: Exception | None = None) -> str:
    """What is said of a name that is no serial port's, error: by which opening it failed; empty where it may
    be one."""
    if "://" in port:
        return ""
    if not os.path.exists(port) and ("/" in port or os.name == "posix"):
        found = ", ".join(item.device for item in list_ports.comports()) or "none"
        return "no port %s (serial ports here: %s)" % (port, found)
    other = "(%d, " % errno.ENOTTY in str(error)  # a device, such as /dev/null, without a line's settings
    if other or (os.path.exists(port) and not stat.S_ISCHR(os.stat(port).st_mode)):
        return "%s is no serial port" % port
    return ""


def _why_not_open(port, error):
    if getattr(error, "errno", None) in _BUSY or (os.name == "nt" and "PermissionError" in str(error)):
        return busy_text(port, holders(port))
    if isinstance(error, PermissionError) or getattr(error, "errno", None) == errno.EACCES:
        return "no permission to open %s: add your user to the group that owns it (often dialout)" % port
    return why_no_port(port, error) or "cannot open the port %s: %s" % (port, str(error).splitlines()[0])


class Identity(NamedTuple):
    """What stays of a USB device when its port changes its name; None where there is none."""

    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None

    def text(self) -> str:
        """For a person; empty when nothing is known."""
        if self.serial_number:
            return "USB serial number %s" % self.serial_number
        if self.vid is None or self.pid is None:
            return ""
        return "USB device %04x:%04x" % (self.vid, self.pid)


def identity_of(port: str, ports: Iterable[Any] | None = None) -> Identity:
    """The Identity of what is behind a port; ports: those there are (all of this computer's)."""
    real = os.path.realpath(port)
    for item in list_ports.comports() if ports is None else ports:
        if port == item.device or real == os.path.realpath(item.device):
            return Identity(item.vid, item.pid, item.serial_number)
    return Identity()


def find_again(port: str, identity: Identity, ports: Iterable[Any] | None = None) -> str | None:
    """The name that a device has by now; None while it is not there.

    By its USB serial number; without one the old name when the same kind of device is behind it, else the
    only other port with such a device; without USB the old name.
    """
    found = list(list_ports.comports() if ports is None else ports)
    if identity.vid is None:
        return port if os.path.exists(port) or "/" not in port else None
    same = [item for item in found if Identity(item.vid, item.pid, item.serial_number) == identity]
    by_name = [item for item in same if item.device == port or os.path.realpath(port) == item.device]
    chosen = by_name or same
    return (port if by_name else chosen[0].device) if len(chosen) == 1 else None
