"""Runs the program on a PC: recorded frames in, the wire on a terminal device out. See _USAGE."""

import json
import os
import sys

from atomic_file import AtomicFile
from cameras import CameraError
from cameras.replay import Replay
from faults import Faults
from larics.device.factory import make_detector
from larics.settings import Settings, field
from pc.uart_unix import UART
from settings_store import SettingsStore

_USAGE = """usage: micropython firmware/pc/replay_main.py --frames FOLDER --port /dev/pts/3 [--fps 60]
                                    [--rounds 1] [--settings FILE.json] [--set name=value]...
                                    [--keep FILE]

Runs the program on a PC: recorded frames in, the wire on a terminal device out.

--fps 0 delivers the frames as fast as they are processed; --rounds 0 repeats them for ever. A --set counts
more than the file. --keep names the file that saved settings go to; once it is there, it counts instead."""
_NUMBERS = ("fps", "rounds")


def parse(arguments):
    """Options as a dict; SystemExit with one line for what is wrong, or after --help."""
    if "--help" in arguments or "-h" in arguments:
        print(_USAGE)
        raise SystemExit(0)
    options = {"fps": 0, "rounds": 1, "set": {}}
    position = 0
    while position < len(arguments):
        name = arguments[position][2:]
        if not arguments[position].startswith("--") or position + 1 == len(arguments):
            _fail("unexpected " + arguments[position])
        value = arguments[position + 1]
        position += 2
        if name == "set":
            setting, _, text = value.partition("=")
            options["set"][setting] = _setting_value(setting, text)
        elif name in _NUMBERS:
            if not value.isdigit():
                _fail("--%s wants a whole number, not %s" % (name, value))
            options[name] = int(value)
        elif name in ("frames", "port", "settings", "keep"):
            options[name] = value
        else:
            _fail("unknown option --" + name)
    for name in ("frames", "port"):
        if name not in options:
            _fail("--%s is missing" % name)
    return options


def _setting_value(name, text):
    entry = field(name)
    if entry is None:
        _fail("there is no setting " + name)
    if entry.kind == "bool":
        return text == "true"
    if entry.kind == "choice" and text in entry.choices:
        return text
    try:
        return (
            [int(part) for part in text.split(",") if part] if entry.kind in ("list", "ranges") else int(text)
        )
    except ValueError:
        _fail("%s is no value for %s" % (text, name))


def _fail(line):
    sys.stderr.write("desk: %s\n" % line)
    raise SystemExit(2)


def _must_exist(name, path):
    try:
        os.stat(path)
    except OSError as error:
        _fail("--%s: there is no %s (%s)" % (name, path, error))


def _exists(path):
    try:
        os.stat(path)
    except OSError:
        return False
    return True


def _settings(options, keeper):
    """The settings that were saved, or those of the command line."""
    if keeper and _exists(options["keep"]):
        return keeper.load()
    values = {}
    if "settings" in options:
        with open(options["settings"]) as file:
            values = json.load(file)
    values.update(options["set"])
    return Settings(values)


def main(arguments):
    options = parse(arguments)
    for name in ("frames", "port", "settings"):
        if name in options:
            _must_exist(name, options[name])
    camera = Replay(options["frames"], fps=options["fps"], rounds=options["rounds"])
    faults = Faults()
    keeper = SettingsStore(AtomicFile(options["keep"]), faults) if "keep" in options else None
    try:
        settings = _settings(options, keeper)
        camera.start()
        settings.update({"width": camera.width, "height": camera.height})
        detector = make_detector(settings)
        # a small heap is not cut up yet: only now comes the rest of the program
        from app import App

        app = App(
            settings, camera, UART(options["port"]), "desk", keeper=keeper, faults=faults, detector=detector
        )
    except (ValueError, OSError, CameraError) as error:
        _fail(str(error))
    app.run()


if __name__ == "__main__":
    main(sys.argv[1:])
