"""The start of the program on a board: which board, safe mode, settings, camera, line, watchdog."""

import os
import sys

import heap  # noqa: F401  (first of all: it keeps room for the detector)
import larics
import safe_mode
from app import App
from atomic_file import AtomicFile
from faults import Faults
from larics.wire import messages as m
from leds import make_leds
from settings_store import SettingsStore

FOLDER = "larics_data"  # settings, and what else must outlive an update


def identity():
    """What the board says it is."""
    try:
        import omv

        return omv.arch()
    except ImportError:
        pass
    try:
        return os.uname().machine
    except AttributeError:  # some ports leave it out
        return getattr(sys.implementation, "_machine", sys.platform)


def make_camera(board, settings):
    """The driver for the board's camera, not yet started."""
    options = {
        "exposure_us": settings.exposure_us,
        "gain_cdb": settings.gain_db10 * 10,
        "readout_us": board.readout_us,
    }
    if board.camera == "esp32":
        from cameras.esp32 import EspCamera

        return EspCamera(settings.width, settings.height, **options)
    try:
        from cameras.openmv_csi import CsiCamera
    except ImportError:  # firmware older than the csi module
        from cameras.openmv_sensor import SensorCamera

        return SensorCamera(settings.width, settings.height, **options)
    return CsiCamera(settings.width, settings.height, **options)


def make_uart(board, baud):
    from machine import UART

    options = {"timeout": 0, "timeout_char": 2, "rxbuf": 1024}  # a third of a second of odometry
    if board.uart_pins:
        options["tx"], options["rx"] = board.uart_pins
    try:
        return UART(board.uart, baud, txbuf=512, **options)  # then a write does not wait
    except (TypeError, ValueError):
        return UART(board.uart, baud, **options)


def button(board):
    """A function that tells whether the board's button is held; None without a button."""
    if board.button is None:
        return None
    try:
        from machine import Pin

        pin = Pin(board.button, Pin.IN, Pin.PULL_UP)
    except (ImportError, ValueError, OSError, TypeError):
        return None
    return lambda: not pin.value()


def unique_id():
    import machine

    try:
        return machine.unique_id()
    except AttributeError:
        return b""


def main():
    """Runs until a restart is due; returns in safe mode, so that the REPL is free."""
    from larics import boards

    board = boards.find(identity())
    del sys.modules[boards.__name__], boards  # the other boards need not stay in memory
    if hasattr(larics, "boards"):
        del larics.boards
    if board is None:
        print("larics: this board is not in the table: " + identity())
        return
    faults = Faults()
    leds = make_leds(board.leds)
    folder = board.flash.rstrip("/") + "/" + FOLDER
    try:
        os.mkdir(folder)
    except OSError:
        pass  # it is there already, or nothing can be written, which the guard finds
    sentinel = safe_mode.SafeMode(folder + "/starts", button(board))
    try:
        safe = sentinel.begin()
    except OSError:
        faults.begin(m.FAULT_STORAGE)
        safe = False
    keeper = SettingsStore(AtomicFile(folder + "/settings.json"), faults)
    if safe:
        faults.begin(m.FAULT_SAFE_MODE)
    if safe_mode.was_watchdog():
        faults.begin(m.FAULT_WATCHDOG)
    settings = keeper.load()
    uart = make_uart(board, settings.baud)
    camera = make_camera(board, settings)
    app = App(settings, camera, uart, board.name, unique_id(), keeper, faults, leds=leds, sentinel=sentinel)
    if safe:
        leds.all(True)
        app.announce_only()
        print("larics: safe mode; reset to start the program")
        return
    app.banner = "larics %s runs on %s" % (larics.__version__, board.name)
    run(app, sentinel)


def run(app, sentinel):
    import machine

    app.watchdog = safe_mode.make_watchdog()
    if isinstance(app.watchdog, safe_mode.NoWatchdog):
        print("larics: no watchdog here: a program that hangs stays so until a reset")
    try:
        app.run()
    except KeyboardInterrupt:
        if isinstance(app.watchdog, safe_mode.NoWatchdog):
            raise
        try:
            sentinel.ask_for_safe_mode()
        except OSError:
            pass
        print("larics: restarting into safe mode")
    except Exception as error:  # nothing should come here; a restart is better than silence
        sys.print_exception(error)
    machine.reset()
