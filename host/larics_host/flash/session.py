"""A board's REPL: its running program stopped, code executed, files written and their hashes read."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import struct
import tempfile
import time
from types import SimpleNamespace
from typing import Any

from mpremote.transport import TransportError
from mpremote.transport_serial import SerialTransport

from larics_host.connection import serial_ports
from larics_host.errors import UserError

_CHUNK = 512
_RECONNECT_S = 25  # a running watchdog restarts the board into safe mode
_ANSWER_S = 10  # of a board that answered once, also while it erases flash
_TROUBLE = (TransportError, OSError, EOFError, struct.error)  # the last: half of an answer


class SessionError(UserError):
    """The board did not do what it was told."""


class Session:
    """`port`: device name. Use as a context manager; `open` stops the program that runs."""

    def __init__(self, port: str) -> None:
        self.port = port
        self._link: Any = None

    def open(self, limit_s: float = _RECONNECT_S) -> Session:
        """Stops what runs and enters the raw REPL. Raises UserError when the board does not answer.

        A program with a running watchdog restarts the board, into safe mode; then the port goes away and
        comes back, so several attempts are made."""
        end_s = time.monotonic() + limit_s
        nothing = serial_ports.why_no_port(self.port)
        if nothing:
            raise UserError(nothing)
        while True:
            try:
                self._connect()
                return self
            except _TROUBLE as error:
                self.close()
                shut = serial_ports.why_shut(self.port)
                if shut:
                    raise UserError(shut) from error
                if time.monotonic() > end_s:
                    text = "%s does not answer: is a MicroPython board there?" % self.port
                    raise UserError(text) from error
                time.sleep(0.5)

    def _connect(self):
        self._link = SerialTransport(self.port, timeout=3)
        serial_ports.close_to_others(self._link.serial, self.port)
        with contextlib.redirect_stdout(io.StringIO()):  # it prints what it could not understand
            self._link.enter_raw_repl(soft_reset=False, timeout_overall=3)
            if self._link.exec("print(6 * 7)").strip() != b"42":
                raise TransportError("unexpected answer")
        self._link.serial.timeout = _ANSWER_S

    def close(self) -> None:
        if self._link is not None:
            with contextlib.suppress(*_TROUBLE):
                self._link.close()
            self._link = None

    def __enter__(self):
        return self.open()

    def __exit__(self, *_):
        if self._link is not None:
            with contextlib.suppress(*_TROUBLE):
                self._link.exit_raw_repl()
        self.close()

    def run(self, code: str) -> str:
        """Executes code; returns what it printed, as text."""
        try:
            return self._link.exec(code).decode("utf-8", "replace")
        except _TROUBLE as error:
            raise SessionError("%s: %s" % (self.port, _last_line(error))) from error

    def evaluate(self, expression: str) -> Any:
        """The value of an expression (anything that has a literal)."""
        try:
            return self._link.eval(expression)
        except (*_TROUBLE, ValueError, SyntaxError) as error:
            raise SessionError("%s: %s" % (self.port, _last_line(error))) from error

    def identity(self) -> tuple[str, str, int, str]:
        """(identity text, MicroPython version, sys.implementation._mpy or 0, OpenMV's version or "")."""
        self.run(
            "import sys, os\n"
            "def _version():\n"
            " i = sys.implementation\n"
            " return '.'.join(str(n) for n in i.version[:3]), getattr(i, '_mpy', 0)\n"
            "def _identity():\n"
            " try:\n"
            "  import omv\n"
            "  return omv.arch(), omv.version_string()\n"
            " except (ImportError, AttributeError):\n"
            "  pass\n"
            " try:\n"
            "  return os.uname().machine, ''\n"
            " except AttributeError:\n"
            "  return getattr(sys.implementation, '_machine', sys.platform), ''\n"
        )
        name, release = self.evaluate("_identity()")
        version, mpy = self.evaluate("_version()")
        return name, version, mpy, release

    def heap_bytes(self) -> int:
        """The size of the board's heap."""
        self.run("import gc\ngc.collect()")
        return self.evaluate("gc.mem_free() + gc.mem_alloc()")

    def exists(self, path: str) -> bool:
        self.run(
            "import os\n"
            "def _exists(p):\n"
            " try:\n"
            "  os.stat(p)\n"
            "  return True\n"
            " except OSError:\n"
            "  return False\n"
        )
        return self.evaluate("_exists(%r)" % path)

    def read_text(self, path: str) -> str | None:
        """The text of a small file, None when there is none."""
        if not self.exists(path):
            return None
        self.run("f = open(%r)\nt = f.read()\nf.close()" % path)
        return self.evaluate("t")

    def free_bytes(self, path: str) -> int:
        """Free space of the file system there."""
        self.run("import os")
        return self.evaluate("(lambda s: s[0] * s[3])(os.statvfs(%r))" % path)

    def make_folder(self, path: str) -> None:
        self.run("try:\n os.mkdir(%r)\nexcept OSError:\n pass" % path)

    def remove_tree(self, path: str) -> None:
        """Removes a folder and all below; nothing happens when it is not there."""
        self.run(
            "def _remove(p):\n"
            " try:\n"
            "  names = os.listdir(p)\n"
            " except OSError:\n"
            "  names = None\n"
            " for n in names or ():\n"
            "  _remove(p + '/' + n)\n"
            " try:\n"
            "  (os.remove if names is None else os.rmdir)(p)\n"
            " except OSError:\n"
            "  try:\n"
            "   os.remove(p)\n"
            "  except OSError:\n"
            "   pass\n"
            "_remove(%r)" % path
        )

    def write(self, path: str, data: bytes) -> None:
        """Writes a file and compares its hash; raises SessionError when it differs."""
        try:
            self._link.fs_writefile(path, data, chunk_size=_CHUNK)
            found = self._link.fs_hashfile(path, "sha256", chunk_size=_CHUNK)
        except _TROUBLE as error:
            raise SessionError("writing %s failed: %s" % (path, _last_line(error))) from error
        if bytes(found) != hashlib.sha256(data).digest():
            raise SessionError("%s reads back differently from what was written" % path)

    def rom_bytes(self) -> int:
        """Size of the partition whose files are read in place (ROMFS); 0 without one."""
        self.run(
            "def _rom_bytes():\n"
            " try:\n"
            "  import vfs\n"
            "  if vfs.rom_ioctl(1) < 1:\n"
            "   return 0\n"
            "  dev = vfs.rom_ioctl(2, 0)\n"
            "  return dev.ioctl(4, 0) * dev.ioctl(5, 0) if hasattr(dev, 'ioctl') else len(dev)\n"
            " except (ImportError, AttributeError, TypeError):\n"
            "  return 0\n"
        )
        return self.evaluate("_rom_bytes()")

    def names(self, path: str) -> list[str]:
        """What lies in a folder; nothing when there is none."""
        self.run("import os\ntry:\n n = os.listdir(%r)\nexcept OSError:\n n = []" % path)
        return self.evaluate("n")

    def deploy_rom(self, image: bytes) -> None:
        """Writes the first ROMFS partition and compares its hash; raises SessionError when it differs."""
        from mpremote import commands

        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "program.romfs")
            with open(file, "wb") as opened:
                opened.write(image)
            state = SimpleNamespace(transport=self._link, ensure_raw_repl=int, did_action=int)
            arguments = SimpleNamespace(command=["deploy"], partition=0, path=file, mpy=False)
            try:
                with contextlib.redirect_stdout(io.StringIO()):
                    commands.do_romfs(state, arguments)
            except (*_TROUBLE, commands.CommandError, SystemExit) as error:
                raise SessionError("writing ROMFS failed: %s" % _last_line(error)) from error
        self.run("import vfs, hashlib\nh = hashlib.sha256(memoryview(vfs.rom_ioctl(2, 0))[:%d])" % len(image))
        if self.evaluate("h.digest()") != hashlib.sha256(image).digest():
            raise SessionError("ROMFS reads back differently from what was written")

    def rename(self, source: str, target: str) -> None:
        """On the board; there must be no target."""
        self.run("import os\nos.rename(%r, %r)" % (source, target))

    def reset(self) -> Any:
        """Restarts the board; the session ends. Returns its port (pyserial), still open, so that nothing of
        what the board says first is lost where the port does not go away; None when there is none."""
        with contextlib.suppress(*_TROUBLE):
            self._link.exec_raw_no_follow("import machine\nmachine.reset()")
        link, self._link = self._link, None
        return link and link.serial


def _last_line(error):
    lines = str(error).strip().splitlines()
    return lines[-1] if lines else error.__class__.__name__
