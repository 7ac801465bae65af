"""`larics log`: records what the camera sends."""

from __future__ import annotations

import argparse
import contextlib
import time
from typing import Any

from larics_host.errors import UserError
from larics_host.wording import counted

NAME = "log"
HELP = "record what the camera sends as CSV, JSON lines and MCAP, with a live table"
EXAMPLE = """
larics log --port /dev/ttyACM0                   # until Ctrl-C, into larics-<date>.csv and .jsonl
larics log --port /dev/ttyUSB0 -o run --seconds 60 --raw
larics log --port /dev/ttyACM0 -o day --mcap --reconnect    # for Foxglove; goes on after unplugging
larics log --input run.bin -o again              # decodes recorded bytes once more
"""

_REFRESH_S = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--port", metavar="DEVICE", help="serial port, such as /dev/ttyACM0 or COM3")
    source.add_argument("--input", metavar="FILE", help="a file of raw bytes, - for standard input")
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")
    parser.add_argument("-o", "--output", metavar="PREFIX", help="PREFIX.csv, PREFIX.jsonl ...")
    parser.add_argument("--seconds", type=float, metavar="N", help="stop after N seconds")
    parser.add_argument("--raw", action="store_true", help="also keep every byte, in PREFIX.bin")
    parser.add_argument("--mcap", action="store_true", help="also PREFIX.mcap, which Foxglove opens")
    parser.add_argument("--reconnect", action="store_true", help="wait for a port that has gone to return")
    parser.add_argument("--force", action="store_true", help="overwrite existing files")
    parser.add_argument("--quiet", action="store_true", help="no live table")


def run(args: argparse.Namespace) -> int:
    from larics_host.connection.byte_sources import (
        ConnectionLost,
        FileSource,
        ReconnectingSource,
        SerialSource,
        stop_on_signals,
    )
    from larics_host.connection.receiver import Receiver
    from larics_host.logs.log_writer import LogWriter

    if args.seconds is not None and not args.seconds > 0:
        raise UserError("--seconds %g: give a number above 0" % args.seconds)
    if not args.baud > 0:
        raise UserError("--baud %d: give a number above 0" % args.baud)
    source: Any = SerialSource(args.port, args.baud) if args.port else FileSource(args.input)
    prefix = args.output or time.strftime("larics-%Y%m%d-%H%M%S")
    recorder = LogWriter(prefix, raw=args.raw, force=args.force, mcap=args.mcap)
    if args.port and args.reconnect:
        source = ReconnectingSource(source)
    receiver = Receiver()
    lost = None
    try:
        with stop_on_signals(source.live) as stopped, contextlib.suppress(KeyboardInterrupt):
            _record(source, receiver, recorder, args, stopped)
    except ConnectionLost as error:
        lost = error
    finally:
        recorder.close()
        source.close()
    return _conclude(source, receiver, recorder, lost)


def _record(source, receiver, recorder, args, stopped):
    from larics_host.logs.live_table import LiveTable

    view = LiveTable(source.name)
    start_s = time.monotonic()
    with _display(args.quiet) as show:
        shown_s = start_s
        while True:
            data = source.read()
            now_s = time.monotonic()
            recorder.write_bytes(data or b"")
            for message in receiver.feed(data or b"", now_s - start_s):
                recorder.write(message)
                view.add(message)
            over = args.seconds is not None and now_s - start_s > args.seconds
            if data is None or over or stopped():
                show(view.render(receiver.counters))
                return
            if now_s - shown_s >= _REFRESH_S:
                show(view.render(receiver.counters))
                shown_s = now_s


@contextlib.contextmanager
def _display(quiet):
    """A function that shows something in place of what it showed before; without a terminal, nothing."""
    from rich.console import Console
    from rich.live import Live

    console = Console()
    if quiet or not console.is_terminal:
        yield lambda content: None
        return
    with Live(console=console, auto_refresh=False) as live:
        yield lambda content: live.update(content, refresh=True)


def _conclude(source, receiver, recorder, lost):
    from larics_host.logs.live_table import reception

    received, missing, damaged = reception(receiver.counters)
    files = ", ".join(recorder.files)
    counts = counted(received, "message"), missing, damaged
    summary = "%s received, %d lost, %d damaged; written to %s" % (*counts, files)
    if lost:
        raise UserError("%s; %s" % (lost, summary))
    if not received:
        hint = "check the wiring (TX to RX), the baud rate and the power"
        if not source.live:
            hint = "it takes the bytes of larics log --raw"
        raise UserError("no message came from %s: %s" % (source.name, hint))
    print(summary)
    return 0
