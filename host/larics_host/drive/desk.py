"""A camera on the desk: the firmware with recorded frames behind a pseudo-terminal, for others to open.

Nobody has to listen: what the firmware sends meanwhile is lost, as on a real line. What it is told to save it
keeps in the folder of the frames, and a restart starts it again with that.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
import tty
from pathlib import Path

from larics_host.connection.byte_sources import stop_on_signals
from larics_host.connection.pty_port import PtyPort
from larics_host.drive.firmware import interpreter_command
from larics_host.errors import UserError
from larics_host.sources import source_root

SAVED = "saved-settings"  # what the camera on the desk keeps, in the folder of its frames
_START_S = 120.0
_POLL_S = 0.01


class _Camera:
    """The process of the firmware and the end of its line. Use as a context manager."""

    def __init__(self, command):
        self._command = command
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the camera)
        self._start()

    def _start(self):
        root = source_root()
        path = os.pathsep.join([str(root / "shared"), str(root / "firmware")])
        environment = dict(os.environ, MICROPYPATH=path + os.pathsep + ".frozen", PYTHONPATH=path)
        self._process = subprocess.Popen(
            [*self._command, "--port", os.ttyname(self._slave)],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=self._errors,
            stderr=self._errors,
            start_new_session=True,  # Ctrl-C ends the desk, which ends the camera
        )

    def read(self):
        """What it sent, b"" after a short wait. Starts it again after a restart it was told to make."""
        code = self._process.poll()
        if code == 0:
            self._start()
        elif code is not None:
            raise UserError("the firmware stopped: " + self.last_words())
        if not select.select([self._master], [], [], _POLL_S)[0]:
            return b""
        try:
            return os.read(self._master, 4096)
        except BlockingIOError:
            return b""

    def write(self, data):
        os.write(self._master, data)

    def last_words(self):
        self._errors.seek(0)
        text = self._errors.read().decode("utf-8", "replace").strip()
        return text.splitlines()[-1].removeprefix("desk: ") if text else "no message"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        self._errors.close()
        os.close(self._master)
        os.close(self._slave)


def _command(args):
    """The firmware's command line without its port."""
    folder = Path(args.desk)
    if not folder.is_dir():
        raise UserError("there is no folder %s with frames for the camera to see" % folder)
    if not 1 <= args.fps <= 1000:
        raise UserError("--fps %d: give a number from 1 to 1000" % args.fps)
    program = source_root() / "firmware" / "pc" / "replay_main.py"
    if not program.exists():
        raise UserError(
            "a camera on the desk needs the firmware's sources beside the package: use a checkout"
        )
    frames = ["--frames", str(folder.resolve()), "--fps", str(args.fps), "--rounds", "0"]
    command = [*interpreter_command("micropython"), str(program), *frames]
    settings = Path(args.settings) if args.settings else folder / "settings.json"
    if args.settings or settings.exists():
        from larics_host.connection.camera_settings import checked, read_file

        checked(read_file(settings))
        command += ["--settings", str(settings.resolve())]
    return [*command, "--keep", str(folder.resolve() / SAVED)]


def _make_link(link, device):
    if link.is_symlink() and not link.exists():
        link.unlink()  # of one that was killed
    try:
        link.symlink_to(device)
    except OSError as error:
        raise (
            _taken(link) if os.path.lexists(link) else UserError("%s: %s" % (link, error.strerror))
        ) from None


def _taken(link):
    return UserError("%s: it is there already: choose another --link" % link)


def run_desk(args: argparse.Namespace) -> int:
    """Runs until Ctrl-C or SIGTERM; with --detach, until the camera has spoken. Returns the exit code."""
    command = _command(args)
    if args.detach:
        return _detach(args)
    port = PtyPort()
    link = Path(args.link) if args.link else None
    if link:
        _make_link(link, port.device)
    try:
        with _Camera(command) as camera, stop_on_signals(True) as stopped:
            _relay(camera, port, stopped, link or port.device)
    finally:
        if link:
            link.unlink(missing_ok=True)
            _forget_process(link)
        port.close()
    return 0


def _process_file(link):
    return link.with_name(link.name + ".pid")


def _forget_process(link):
    """A number that is left behind may be another process' one day."""
    kept = _process_file(link)
    with contextlib.suppress(OSError):
        if kept.read_text(encoding="utf-8").strip() == str(os.getpid()):
            kept.unlink()


def _relay(camera, port, stopped, name):
    told = False
    while not stopped():
        data = camera.read()
        if data and not told:
            print("%s: open this as the camera's port; Ctrl-C ends it" % name, flush=True)
            told = True
        if not port.has_reader():
            continue
        try:
            port.write(data)
        except BrokenPipeError:
            continue  # whoever listened has gone
        request = port.read()
        if request:
            camera.write(request)


def _detach(args):
    if not args.link:
        raise UserError("--detach needs --link NAME, by which the port and the process are found again")
    link = Path(args.link)
    if link.exists():
        raise _taken(link)  # its log is that of a camera that runs
    said = link.with_name(link.name + ".log")
    command = [sys.executable, "-m", "larics_host", "simulate", "--desk", args.desk, "--link", args.link]
    command += ["--fps", str(args.fps)]
    command += ["--settings", args.settings] if args.settings else []
    with open(said, "w", encoding="utf-8") as file:
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=file, stderr=file, start_new_session=True
        )
    end_s = time.monotonic() + _START_S
    while process.poll() is None and "open this" not in said.read_text(encoding="utf-8"):
        if time.monotonic() > end_s:
            os.kill(process.pid, signal.SIGTERM)
            raise UserError("the camera said nothing within %d s: see %s" % (_START_S, said))
        time.sleep(0.05)
    if process.poll() is not None:
        text = said.read_text(encoding="utf-8").strip() or "no message"
        said.unlink()
        raise UserError(text.splitlines()[-1].removeprefix("larics: "))
    _process_file(link).write_text("%d\n" % process.pid)
    print("%s: open this as the camera's port; kill $(cat %s.pid) ends it" % (link, link))
    return 0
