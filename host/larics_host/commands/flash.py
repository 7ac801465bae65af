"""`larics flash`: puts the firmware on a board."""

from __future__ import annotations

import argparse
import re
import sys
import time

from larics_host.errors import UserError, missing_package

NAME = "flash"
HELP = "put the firmware on the connected board; settings and map on it are kept"
EXAMPLE = """
larics flash --dry-run             # says what it would do
larics flash                       # the one board that is connected
larics flash --port /dev/ttyACM0
larics flash --romfs               # less of the heap, on boards that have a ROMFS partition
larics flash --small-heap no       # readable tracebacks on a board with little memory
"""

_BANNER_S = 30
_LAST_LINES = 3  # of the console, when the program does not report
_PROMPTS = (">>>", "Type ", "MicroPython ", "OpenMV ")  # what a board says that starts nothing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--port", metavar="DEVICE", help="serial port of the board's USB")
    parser.add_argument("--serial", metavar="NUMBER", help="the board with this USB serial number")
    parser.add_argument("--dry-run", action="store_true", help="look at the board, write nothing")
    parser.add_argument("--wire", metavar="DEVICE", help="also wait for the first message on this UART")
    parser.add_argument(
        "--romfs",
        action="store_true",
        help="where files are read in place: for boards with little memory",
    )
    parser.add_argument(
        "--small-heap",
        choices=("auto", "yes", "no"),
        nargs="?",
        const="yes",
        default="auto",
        help="the build that takes the least memory, whose tracebacks larics traceback translates; "
        "auto: where the board's heap is small",
    )
    parser.add_argument("--no-restart", action="store_true", help="leave the board at its REPL")


def run(args: argparse.Namespace) -> int:
    try:
        from larics_host.flash.session import Session
    except ModuleNotFoundError as error:
        raise missing_package("larics flash", "mpremote") from error
    from larics import boards
    from larics_host import sources
    from larics_host.connection.serial_ports import identity_of
    from larics_host.flash import build, install
    from larics_host.flash.ports import find_port

    root = sources.source_root()
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
        files, names = _program(root, march, session.heap_bytes(), args)
        loader, rescue = [(root / "firmware" / name).read_bytes() for name in ("main.py", "boot.py")]
        plan = install.Plan(session, files, loader, rescue, args.romfs)
        plan.check_space(session)
        _describe(plan, march)
        if args.dry_run:
            print("dry run: nothing was written")
            return 0
        if names:
            _keep(plan.version_hash(), names)
        install.install(session, plan, _progress)
        session.remove_tree(plan.root + install.DATA_FOLDER + "/starts")  # no fast resets in a row
        if args.no_restart:
            print("installed; the program starts at the next reset")
            return 0
        device = identity_of(port)
        console = session.reset()
    return _wait_for_start(console, port, device, args.wire, board, plan, names)


def _program(root, march, heap_bytes, args):
    """The files of the usual program or of the small one, for a heap of this size; what translates the
    tracebacks of the latter, else None."""
    from larics_host.flash import build, small_heap

    if args.small_heap == "no" or (args.small_heap == "auto" and heap_bytes >= small_heap.HEAP_BYTES):
        return build.compile_program(root, march), None
    print("  heap of %d KB: compiling the small-heap build" % (heap_bytes // 1024))
    small = small_heap.compile_small(root, march, args.romfs)
    if small.lacks:
        print("larics: %s: the kernels take twice the memory" % small.lacks, file=sys.stderr)
    return small.files, small.names


def _keep(program_hash, names):
    from larics_host.flash import tracebacks

    try:
        print("  names for larics traceback: %s" % tracebacks.save(program_hash, names))
    except OSError as error:
        print("larics: the names for larics traceback cannot be kept: %s" % error, file=sys.stderr)


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
    elif name in ("ROMFS", "main.py", "done"):
        print(text.rstrip())


def _wait_for_start(console, port, device, wire, board, plan, names):
    """Waits for the program's own line on the console and, when asked, its message on the UART."""
    from larics import __version__
    from larics_host.flash.tracebacks import translate

    print("restarting")
    wanted = "larics %s runs on %s" % (__version__, board.name)
    text, back = _read_until(console, port, device, wanted.encode(), _BANNER_S)
    if names:
        text = translate(text, names)
    failed = "the program in %s cannot be loaded" % plan.folder
    if wanted not in text or failed in text:
        raise UserError(_why_not_started(text, back, port, device, wanted, failed, plan))
    print("  " + wanted)
    if wire:
        _wait_on_wire(wire)
    return 0


def _why_not_started(text, back, port, device, wanted, failed, plan):
    """What is known of a board that did not report the new program, and no more."""
    if failed in text:
        runs = "; the one before runs" if wanted in text else ""
        errors = re.findall(r"^\w*(?:Error|Exception)\b.*", text.partition(failed)[2], re.MULTILINE)
        why = ": " + errors[0].strip() if errors else ""
        return "the board cannot load the new program%s%s" % (why, runs)
    if not back:
        who = device.text() or "port %s" % port
        return (
            "the board (%s) has not come back within %d s: whether the new program runs is not known; "
            "unplug it, plug it in and look with larics flash --dry-run" % (who, _BANNER_S)
        )
    before = "there was no program on it before"
    if plan.is_update:
        before = "the program before is still on its flash"
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith(_PROMPTS)]
    said = "it says: " + " / ".join(lines[-_LAST_LINES:]) if lines else "it says nothing"
    return "the board did not report the new program within %d s, %s; whether it runs is not known, %s" % (
        _BANNER_S,
        said,
        before,
    )


def _read_until(link, port, device, wanted, limit_s):
    """(what the board says until `wanted` comes, as text; whether its port is there). link: the open port, or
    None. The port may go away and come back, under another name, too."""
    import serial

    from larics_host.connection.serial_ports import find_again, open_port

    end_s = time.monotonic() + limit_s
    data, back = b"", False
    if link is not None:
        link.timeout = 0.2
    while time.monotonic() < end_s and wanted not in data:
        try:
            if link is None:
                link = open_port(find_again(port, device) or port, 115200, 0.2)
            data += link.read(256)
            back = True
        except (serial.SerialException, OSError, UserError):
            if link is not None:
                link.close()
            link, back = None, False
            time.sleep(0.2)
    if link is not None:
        link.close()
    return data.decode("utf-8", "replace"), back


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
