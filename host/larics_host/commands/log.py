"""`larics log`: records what the camera sends."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from typing import Any

from larics_host.errors import UserError, report
from larics_host.wording import counted

NAME = "log"
HELP = "record what the camera sends as CSV, JSON lines and MCAP, with a live table"
EXAMPLE = """
larics log --port /dev/ttyACM0                   # until Ctrl-C, into larics-<date>.csv and .jsonl
larics log --port /dev/ttyUSB0 -o run --seconds 60 --raw
larics log --port /dev/ttyACM0 -o day --mcap --reconnect    # for Foxglove; goes on after unplugging
larics log --port /dev/ttyACM0 -o - | jq .message
larics log --input run.bin -o again              # decodes recorded bytes once more
"""

_REFRESH_S = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--port", metavar="DEVICE", help="serial port, such as /dev/ttyACM0 or COM3")
    source.add_argument("--input", metavar="FILE", help="a file of raw bytes, - for standard input")
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")
    parser.add_argument(
        "-o",
        "--output",
        metavar="PREFIX",
        help="PREFIX.csv, PREFIX.jsonl ...; - for JSON lines on standard output",
    )
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
    from larics_host.files import CannotWrite
    from larics_host.logs.log_writer import LogWriter, StdoutLog

    if args.seconds is not None and not args.seconds > 0:
        raise UserError("--seconds %g: give a number above 0" % args.seconds)
    if not args.baud > 0:
        raise UserError("--baud %d: give a number above 0" % args.baud)
    to_stdout = args.output == "-"
    if to_stdout and (args.raw or args.mcap):
        raise UserError("-o - writes JSON lines alone: --raw and --mcap need the name of a file")
    source: Any = SerialSource(args.port, args.baud) if args.port else FileSource(args.input)
    prefix = args.output or time.strftime("larics-%Y%m%d-%H%M%S")
    start_s = time.monotonic()
    # when the bytes of a file came is not known
    start_ns = time.time_ns() if args.port or args.input == "-" else None
    recorder: Any = StdoutLog(start_ns)
    if not to_stdout:
        recorder = LogWriter(prefix, args.raw, args.force, args.mcap, start_ns)
    if args.port and args.reconnect:
        source = ReconnectingSource(source)
    work = _Log(args, source, recorder, start_s)
    lost: UserError | ConnectionLost | None = None
    try:
        with stop_on_signals(source.live) as stopped, contextlib.suppress(KeyboardInterrupt):
            work.run(stopped)
    except (ConnectionLost, CannotWrite) as error:
        lost = error
    finally:
        source.close()
        try:
            recorder.close()
        except CannotWrite as error:
            lost = lost or error
    return work.conclude(lost)


class _Log:
    """What is read, decoded, written and shown."""

    def __init__(self, args, source, recorder, start_s):
        from larics_host.connection.line_watch import LineWatch
        from larics_host.connection.receiver import Receiver

        self._args = args
        self._start_s = start_s
        self._source = source
        self._recorder = recorder
        self._receiver = Receiver()
        self._watch = LineWatch()
        self._unique_id = None

    def run(self, stopped):
        from larics_host.logs.live_table import LiveTable

        view = LiveTable(self._source.name)
        start_s = self._start_s
        with _display(self._args.quiet or self._args.output == "-") as show:
            shown_s = start_s
            while True:
                data = self._source.read()
                now_s = time.monotonic()
                self._recorder.write_bytes(data or b"")
                self._watch.feed(data or b"")
                for message in self._receiver.feed(data or b"", now_s - start_s):
                    self._recorder.write(message)
                    view.add(message)
                    self._note_camera(message)
                over = self._args.seconds is not None and now_s - start_s > self._args.seconds
                if data is None or over or stopped():
                    show(view.render(self._receiver.counters))
                    return
                if now_s - shown_s >= _REFRESH_S:
                    show(view.render(self._receiver.counters))
                    shown_s = now_s

    def _note_camera(self, message):
        """A port that came back may have another camera behind it."""
        if message.name != "INFO":
            return
        unique_id = message.fields.unique_id
        if self._unique_id not in (None, unique_id):
            report("another camera is on the line: unique ID %s, before %s" % (unique_id, self._unique_id))
        self._unique_id = unique_id

    def conclude(self, lost):
        """Tells what was received and kept; the exit code."""
        from larics_host.logs.live_table import reception

        counters = self._receiver.counters
        received, missing, damaged = reception(counters)
        counts = counted(received, "message"), missing, damaged
        kept = ", ".join(self._recorder.files)
        kept = "; written to " + kept if kept else "; nothing written"
        summary = "%s received, %d lost, %d damaged%s" % (*counts, kept)
        if lost:
            raise UserError("%s; %s" % (lost, summary))
        if not received:
            what = self._watch.explain(counters, self._args.baud if self._source.live else None)
            raw = "" if not self._recorder.files else "; the bytes are in " + kept.split()[-1]
            raise UserError("no message came from %s, %s%s" % (self._source.name, what, raw))
        print(summary, file=sys.stderr if self._args.output == "-" else sys.stdout)
        return 0


@contextlib.contextmanager
def _display(quiet):
    """A function that shows something in place of what it showed before; without a terminal, nothing."""
    from rich.live import Live

    from larics_host.consoles import Console

    console = Console()
    if quiet or not console.is_terminal:
        yield lambda content: None
        return
    with Live(console=console, auto_refresh=False) as live:
        yield lambda content: live.update(content, refresh=True)
