"""The program on a Linux computer: frames from a video source in, the wire out. `larics camera` runs it.

    python firmware/pc/linux_start.py OPTIONS [--check]

OPTIONS: as JSON what `larics camera` checked, {"source", "size", "fps", "every", "port", "baud", "tcp",
"link", "stdout", "settings", "set"}. Settings are kept in the file `settings`, as a board keeps its own.
--check opens source and line, which tells what is wrong with them, and ends.
"""

import hashlib
import json
import os
import signal
import sys

from app import App
from atomic_file import AtomicFile
from cameras import CameraError
from faults import Faults
from larics.wire import messages as m
from pc import byte_lines, host_clock
from pc.video_camera import VideoCamera
from pc.video_source import VideoSource
from settings_store import SettingsStore

BOARD = "linux"
ENDING = "SIGINT", "SIGTERM", "SIGHUP"
# an exception in the middle of loading a compiled loop leaves it half loaded, and the process crashes
_NOT_WITHIN = "/numba/", "/llvmlite/"
_AGAIN_S = 0.02


class Stop(BaseException):
    """A signal asked for the end; no handler of exceptions takes it."""


def make_line(options, baud):
    if options.get("stdout"):
        return byte_lines.StandardOutput()
    if options.get("tcp") is not None:
        return byte_lines.TcpServer(options["tcp"])
    if options.get("port"):
        return byte_lines.SerialPort(options["port"], options.get("baud") or baud)
    return byte_lines.PseudoTerminal(options.get("link"))


def unique_id():
    """Twelve bytes that stay the same on this computer and tell nothing else about it."""
    try:
        with open("/etc/machine-id", "rb") as file:
            text = file.read()
    except OSError:
        text = os.uname().nodename.encode()
    return hashlib.sha256(b"larics camera " + text.strip()).digest()[:12]


def open_ends(options):
    """(settings, store, faults, camera, line). ValueError, OSError or CameraError tell what is wrong."""
    faults = Faults()
    store = SettingsStore(AtomicFile(options["settings"]), faults)
    settings = store.load()
    for name, value in options.get("set", {}).items():
        settings.set(name, value)
    size = tuple(options["size"]) if options.get("size") else None
    camera = VideoCamera(
        lambda: VideoSource(options["source"], size, options.get("fps")),
        every=options.get("every", False),
        tell=lambda text: say("%s: %s" % (options["source"], text)),
    )
    camera.open()  # a source that is not there is told now, in one line
    return settings, store, faults, camera, make_line(options, settings.baud)


def tell_settings(faults, path):
    """One line when the file of settings could not be read as it is."""
    if faults.active >> m.FAULT_SETTINGS_CORRUPT & 1:
        say("%s: what is damaged or not allowed in it has its default" % path)
    elif faults.active >> m.FAULT_SETTINGS_VERSION & 1:
        say("%s is of another version: what is not known in it is left out" % path)


def make_app(settings, store, faults, camera, line):
    app = App(settings, camera, line, BOARD, unique_id(), store, faults, clock=host_clock, baud=line.baud)
    camera.ready = lambda: app.outbox.empty()
    return app


def stop(_, frame):
    """Ends the program where that may be; elsewhere it is tried again soon."""
    while frame:
        if any(folder in frame.f_code.co_filename for folder in _NOT_WITHIN):
            signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
            return
        frame = frame.f_back
    raise Stop


def stop_by_signals():
    """Lets Stop come of what ends a program. Only within the main thread."""
    for name in ENDING + ("SIGALRM",):  # noqa: RUF005, mpy-cross takes no star there
        signal.signal(getattr(signal, name), stop)


def main(arguments):
    options = json.loads(arguments[0])
    locks = []
    try:
        os.makedirs(os.path.dirname(options["settings"]), exist_ok=True)
        locks.append(byte_lines.lock_of(options["settings"] + ".lock"))
    except BlockingIOError:
        return fail("another larics camera uses %s: give --settings FILE" % options["settings"])
    except OSError:
        pass  # nothing can be kept there, which a save will tell
    stop_by_signals()
    try:
        ends = open_ends(options)
        camera, line = ends[-2:]
        if "--check" in arguments:
            camera.stop()
            line.close()
            return 0
        tell_settings(ends[2], options["settings"])
        app = make_app(*ends)
    except (ValueError, OSError, CameraError) as error:
        return fail(str(error))
    except Stop:
        return 0
    try:
        say("%dx%d from %s to %s" % (camera.width, camera.height, options["source"], line.name))
        if camera.turned:
            text = (
                "%s: a tag asks to show it turned by %d degrees; that is ignored: settings turn the picture"
            )
            say(text % (options["source"], camera.turned))
        app.run()
        if camera.ended and app.watch.missed:
            counts = app.status.frames, app.watch.missed
            say("%d frames processed, %d missed while the computer was busy; --every processes each" % counts)
    except Stop:
        app.loop.close(300)
    except byte_lines.Closed:
        pass
    finally:
        camera.stop()
        line.close()
    if app.commands.restart_due:
        os.execv(sys.executable, [sys.executable] + sys.argv)
    return 0


def say(text):
    sys.stderr.write("larics camera: %s\n" % text.splitlines()[0])
    sys.stderr.flush()


def fail(text):
    sys.stderr.write("larics: %s\n" % text.splitlines()[0])
    return 2


def run(arguments):
    """Never returns: a thread that hangs in OpenCV would abort an interpreter that ends in order."""
    os._exit(main(arguments))
