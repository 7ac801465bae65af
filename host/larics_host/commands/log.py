"""`larics log`: records what the camera sends."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import time
from pathlib import Path
from typing import Any

from larics_host.errors import UserError, report
from larics_host.ros import options as ros_options
from larics_host.ros.topics import TREE
from larics_host.wording import counted

NAME = "log"
HELP = "record what the camera sends as CSV, JSON lines and bags of ROS 2 (MCAP), with a live table"
EXAMPLE = """
larics log --port /dev/ttyACM0                   # until Ctrl-C, into larics-<date>.csv and .jsonl
larics log --port /dev/ttyUSB0 -o run --seconds 60 --raw
larics log --port /dev/ttyACM0 -o day --mcap --reconnect    # for Foxglove; goes on after unplugging
larics log --port /dev/ttyACM0 -o - | jq .message
larics log --port tcp://127.0.0.1:7007 -o run    # of larics camera --tcp 7007
larics log --input run.bin -o again              # decodes recorded bytes once more
larics log --convert run.jsonl -o again --bag --map hall.json   # a folder for ros2 bag play
larics log --convert seen -o again --mcap        # of larics record, with its pictures
"""

_REFRESH_S = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--port", metavar="DEVICE", help="serial port, as /dev/ttyACM0, or tcp://HOST:PORT")
    source.add_argument("--input", metavar="FILE", help="a file of raw bytes, - for standard input")
    source.add_argument(
        "--convert", metavar="LOG", help="a log, or a folder of larics record, written once more"
    )
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")
    parser.add_argument(
        "-o",
        "--output",
        metavar="PREFIX",
        help="PREFIX.csv, PREFIX.jsonl ...; - for JSON lines on standard output",
    )
    parser.add_argument("--seconds", type=float, metavar="N", help="stop after N seconds")
    parser.add_argument("--raw", action="store_true", help="also keep every byte, in PREFIX.bin")
    parser.add_argument(
        "--mcap", action="store_true", help="also PREFIX.mcap, for Foxglove and ros2 bag play"
    )
    parser.add_argument("--bag", action="store_true", help="also the folder PREFIX, a bag with metadata.yaml")
    parser.add_argument("--reconnect", action="store_true", help="wait for a port that has gone to return")
    parser.add_argument("--force", action="store_true", help="overwrite existing files")
    parser.add_argument("--quiet", action="store_true", help="no live table")
    ros_options.add_arguments(parser.add_argument_group("of --mcap and --bag"), TREE)


def run(args: argparse.Namespace) -> int:
    from larics_host.connection.byte_sources import ConnectionLost, ReconnectingSource, stop_on_signals
    from larics_host.files import CannotWrite
    from larics_host.logs.log_writer import LogWriter, StdoutLog

    _check(args)
    ros = ros_options.options_of(args, TREE, background=bool(args.port))
    pictures: dict[int, Path] = {}
    if args.convert:
        source, start_ns, pictures = _converted(args, ros)
    else:
        source = _opened(args)
        # when the bytes of a file came is not known
        start_ns = time.time_ns() if args.port or args.input == "-" else None
    start_s = time.monotonic()
    recorder: Any = StdoutLog(start_ns)
    if args.output != "-":
        prefix = args.output or time.strftime("larics-%Y%m%d-%H%M%S")
        recorder = LogWriter(prefix, args.raw, args.force, args.mcap, start_ns, args.bag, ros)
    if args.port and args.reconnect:
        source = ReconnectingSource(source)
    work = _Log(args, source, recorder, start_s, pictures)
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


def _check(args):
    if args.seconds is not None and not args.seconds > 0:
        raise UserError("--seconds %g: give a number above 0" % args.seconds)
    if not args.baud > 0:
        raise UserError("--baud %d: give a number above 0" % args.baud)
    if args.output == "-" and (args.raw or args.mcap or args.bag):
        raise UserError("-o - writes JSON lines alone: --raw, --mcap and --bag need the name of a file")
    if args.convert and args.raw:
        raise UserError("--raw keeps bytes as they come from a line; with --convert none do")
    if args.pictures is not None and not args.port:
        raise UserError("--pictures asks a camera: it needs --port")


def _opened(args):
    from larics_host.connection.byte_sources import FileSource
    from larics_host.connection.lines import open_line

    if args.port:
        return open_line(args.port, args.baud)
    _refuse_to_overwrite(args.input, args)
    return FileSource(args.input)


def _refuse_to_overwrite(path, args):
    """UserError when a file that is read would be written: it would be emptied first."""
    written = {".csv": True, ".jsonl": True, ".mcap": args.mcap, ".bin": args.raw}
    outputs = [args.output + suffix for suffix, is_written in written.items() if is_written and args.output]
    if os.path.realpath(path) in map(os.path.realpath, outputs):
        raise UserError("-o %s would overwrite %s, which is read: choose another -o" % (args.output, path))


def _converted(args, ros):
    """(source, wall clock at its time 0, {number: path of a raw frame}) of a log or a folder of larics
    record."""
    from larics_host.commands.record import MESSAGES, SETTINGS
    from larics_host.connection.camera_settings import read_file
    from larics_host.images.frame_folder import number_of
    from larics_host.logs.log_reader import read_pieces, start_of
    from larics_host.logs.log_source import LogSource

    path, pictures = Path(args.convert), {}
    if path.is_dir():
        pictures = {number: file for file in path.iterdir() if (number := number_of(file.name)) is not None}
        if not ros.settings and (path / SETTINGS).exists():
            ros.settings = read_file(path / SETTINGS)
        path = path / (MESSAGES + ".jsonl")
    _refuse_to_overwrite(path, args)
    next(read_pieces(path))  # what cannot be read replaces nothing
    start_ns = start_of(path)
    if start_ns is None and (args.mcap or args.bag):
        report("%s does not tell the time of day: the bag begins now" % path)
    return LogSource(path), start_ns, pictures


class _Log:
    """What is read, decoded, written and shown."""

    def __init__(self, args, source, recorder, start_s, pictures):
        from larics_host.connection.line_watch import LineWatch
        from larics_host.connection.receiver import Receiver
        from larics_host.connection.source_watch import SourceWatch

        self._args = args
        self._start_s = start_s
        self._source = source
        self._recorder = recorder
        self._receiver = Receiver()
        self._watch = LineWatch()
        self._sources = SourceWatch()
        self._pictures = pictures
        self._asker = self._make_asker() if args.pictures is not None else None

    def _make_asker(self):
        from larics_host.connection.asker import Asker

        def on_silence():
            report("the camera does not answer, so no settings and no pictures: does this TX reach its RX?")

        return Asker(self._source.write, ros_options.asked_settings(True), self._args.pictures, on_silence)

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
                if self._asker is not None:
                    self._asker.step(now_s)
                time_s = now_s - start_s
                if self._args.convert:
                    time_s = self._source.likely_s(self._args.baud)
                for message in self._receiver.feed(data or b"", time_s):
                    self._recorder.write(message)
                    view.add(message)
                    self._note(message)
                over = self._args.seconds is not None and now_s - start_s > self._args.seconds
                if data is None or over or stopped():
                    show(lambda width: view.render(self._receiver.counters, width))
                    return
                if now_s - shown_s >= _REFRESH_S:
                    show(lambda width: view.render(self._receiver.counters, width))
                    shown_s = now_s

    def _note(self, message):
        if self._asker is not None:
            self._asker.note(message)
        fields = message.fields
        if message.name == "MARKER" and fields.frame in self._pictures and fields.index + 1 >= fields.count:
            self._add_picture(fields.frame)
        told = None
        if message.name == "INFO":
            told = self._sources.info(fields.unique_id.hex())
        elif message.name == "STATUS":
            told = self._sources.status(fields.boot)
        if told:
            report(told)

    def _add_picture(self, number):
        from larics_host.files import read_bytes
        from larics_host.images.stills import decode_still

        path = self._pictures.pop(number)
        self._recorder.picture(number, decode_still(read_bytes(path), str(path)))

    def conclude(self, lost):
        """Tells what was received and kept; the exit code."""
        from larics_host.logs.live_table import reception

        counters = self._receiver.counters
        received, missing, damaged = reception(counters)
        counts = counted(received, "message"), missing, damaged
        kept = ", ".join(self._recorder.files)
        kept = "; written to " + kept if kept else "; nothing written"
        summary = "%s received, %d lost, %d damaged%s" % (*counts, kept)
        if self._args.convert:  # what the log does not have was told when it was made
            summary = "%s read%s" % (counts[0], kept)
        if lost:
            raise UserError("%s; %s" % (lost, summary))
        if self._pictures and (self._args.mcap or self._args.bag):
            report("%s of which the log says nothing left out" % counted(len(self._pictures), "picture"))
        if not received:
            what = self._watch.explain(counters, getattr(self._source, "baud", None))
            raw = "" if not self._recorder.files else "; the bytes are in " + kept.split()[-1]
            raise UserError("no message came from %s, %s%s" % (self._source.name, what, raw))
        rest = self._watch.explain_rest(
            counters, self._receiver.message_bytes, getattr(self._source, "baud", None)
        )
        if rest:
            report(rest)
        print(summary, file=sys.stderr if self._args.output == "-" else sys.stdout)
        return 0


@contextlib.contextmanager
def _display(quiet):
    """A function that shows what another one makes for a width, in place of what it showed before; without a
    terminal, nothing."""
    from rich.live import Live

    from larics_host.consoles import Console

    console = Console()
    if quiet or not console.is_terminal:
        yield lambda made: None
        return
    with Live(console=console, auto_refresh=False) as live:
        yield lambda made: live.update(made(console.width), refresh=True)
