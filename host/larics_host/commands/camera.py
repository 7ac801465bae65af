"""`larics camera`: the sensor on a Linux computer, a webcam, a video or an address in place of the board."""

from __future__ import annotations

import argparse
import codecs
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from larics_host.errors import UserError
from larics_host.user_folder import user_folder

NAME = "camera"
HELP = "be the sensor on a Linux computer: frames from a webcam, a video or an address, the wire out"
EXAMPLE = """
larics camera                                        # /dev/video0; prints the pseudo-terminal to open
larics camera --source 2 --size 640x480 --port /dev/ttyAMA0
larics camera --source http://127.0.0.1:8080/stream --tcp 7007
larics camera --source drive.mp4 --stdout | larics log --input - -o run
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--source", metavar="WHAT", default="0",
        help="number or path of a V4L2 device (0), a video file, or an MJPEG or RTSP address",
    )  # fmt: skip
    parser.add_argument(
        "--size", metavar="WxH", help="to ask a device for; larger frames than 1024 px are reduced"
    )
    parser.add_argument("--fps", type=float, metavar="N", help="to ask a device for")
    parser.add_argument(
        "--every",
        action="store_true",
        help="process every frame of a file, at any speed, instead of playing it in its own time",
    )
    line = parser.add_mutually_exclusive_group()
    line.add_argument("--port", metavar="DEVICE", help="send to this serial port")
    line.add_argument(
        "--tcp", metavar="PORT", type=int, help="serve one listener on 127.0.0.1 (0: a free port)"
    )
    line.add_argument("--stdout", action="store_true", help="send to standard output")
    line.add_argument("--link", metavar="PATH", help="the pseudo-terminal under this name, too")
    parser.add_argument("--baud", type=int, metavar="N", help="of the port, instead of the setting")
    parser.add_argument(
        "--settings", metavar="FILE", help="where settings are kept (%s)" % default_settings("camera")
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting for this run; may be repeated",
    )


def default_settings(name: str) -> Path:
    """The file in the user's configuration folder."""
    return user_folder() / (name + ".json")


def run(args: argparse.Namespace) -> int:
    import larics
    from larics_host.compilation import compile_once, is_compiled
    from larics_host.connection.camera_settings import parse_changes
    from larics_host.files import encoding_of, read_bytes
    from larics_host.sources import source_root

    if not sys.platform.startswith("linux"):
        raise UserError("larics camera runs on Linux; here is %s" % sys.platform)
    root = source_root()
    program = root / "firmware" / "pc" / "linux_start.py"
    options: dict[str, Any] = {
        "source": args.source, "size": _size(args.size), "fps": args.fps, "every": args.every,
        "port": args.port, "baud": args.baud, "tcp": args.tcp, "stdout": args.stdout, "link": args.link,
        "settings": os.path.abspath(args.settings or default_settings("camera")),
        "set": parse_changes(args.set),
    }  # fmt: skip
    if args.tcp is not None and not 0 <= args.tcp <= 65535:
        raise UserError("--tcp %d is no port: 0 to 65535" % args.tcp)
    if args.fps is not None and not 0 < args.fps <= 1000:
        raise UserError("--fps %g: give a number above 0, up to 1000" % args.fps)
    if args.baud is not None and not args.baud > 0:
        raise UserError("--baud %d: give a number above 0" % args.baud)
    if args.settings and Path(args.settings).exists():
        head = read_bytes(args.settings)
        encoding = encoding_of(head[:4])
        if not encoding.startswith("utf-8"):
            raise UserError("%s is a text in %s: save it as UTF-8" % (args.settings, encoding.upper()))
        head = head.removeprefix(codecs.BOM_UTF8).strip()
        if head and not head.startswith(b"{"):
            text = "%s is no file of settings, and saving would overwrite it: choose another name"
            raise UserError(text % args.settings)
    # the package that is imported here is imported there, too, with the loops that are compiled for it
    paths = root / "firmware", Path(larics.__file__).parents[1]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(map(str, paths)))
    command = [sys.executable, str(program), json.dumps(options)]
    if not is_compiled():
        # what cannot be opened is told before anybody waits for the compiler
        code = subprocess.run([*command, "--check"], env=environment).returncode
        if code:
            return code
        compile_once()  # or the first frames would wait for it
    sys.stdout.flush()
    # the program takes the place of this one, so that signals and a service manager reach it directly
    os.execve(sys.executable, command, environment)


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise UserError("--size %s is no size: write WIDTHxHEIGHT, as 640x480" % text)
    return int(width), int(height)
