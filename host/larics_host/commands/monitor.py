"""`larics monitor`: what a camera sees and does, live, in the terminal or on a local web page."""

from __future__ import annotations

import argparse
import sys
import time

from larics_host.errors import UserError
from larics_host.local_server import DEFAULT_PORT

NAME = "monitor"
HELP = "watch a camera or a recorded log, in the terminal or on a local web page"
EXAMPLE = """
larics monitor --port /dev/ttyACM0
larics monitor --port /dev/ttyACM0 --web        # prints the address of a page on this computer
larics monitor --input run.jsonl --speed 2
"""

_REFRESH_S = 0.1
_LINES = 100  # of what is not a terminal


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--port", metavar="DEVICE", help="serial port of the camera, or tcp://HOST:PORT")
    source.add_argument("--input", metavar="FILE", help="a log: .jsonl, .bin or .mcap")
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")
    parser.add_argument("--speed", metavar="X", type=float, default=1.0, help="of a log; 0: at once")
    parser.add_argument("--map", metavar="FILE.json", help="map or settings with a map, to draw its markers")
    parser.add_argument(
        "--web",
        metavar="PORT",
        nargs="?",
        type=int,
        const=DEFAULT_PORT,
        help="serve a page at this port of this computer only (%d)" % DEFAULT_PORT,
    )
    parser.add_argument("--seconds", metavar="N", type=float, help="stop after N seconds")


def run(args: argparse.Namespace) -> int:
    from larics_host.connection.byte_sources import stop_on_signals
    from larics_host.connection.lines import open_line
    from larics_host.logs.log_reader import read_pieces
    from larics_host.logs.log_source import LogSource
    from larics_host.monitor.session import Session
    from larics_host.monitor.state import MonitorState

    _check(args)
    rows = _map_rows(args.map) if args.map else ()
    if args.input:
        next(read_pieces(args.input))  # what cannot be read is told before anything is shown
    source = LogSource(args.input, args.speed) if args.input else open_line(args.port, args.baud)
    session = Session(source, MonitorState(source.name, rows))
    server = None
    if args.web is not None:
        from larics_host.monitor.web import serve

        server = serve(session, args.web)
        print("http://127.0.0.1:%d/  (Ctrl-C ends)" % server.server_port, flush=True)
    session.start()
    try:
        with stop_on_signals(live=True) as stopped:
            _show(args, session, stopped)
    finally:
        session.stop()
        if server:
            server.shutdown()
            server.server_close()
    return _conclude(session)


def _check(args):
    if not args.speed >= 0:
        raise UserError("--speed %g: give a number from 0 on" % args.speed)
    if not args.baud > 0:
        raise UserError("--baud %d: give a number above 0" % args.baud)
    if args.seconds is not None and not args.seconds > 0:
        raise UserError("--seconds %g: give a number above 0" % args.seconds)
    if args.web is not None and not 0 <= args.web <= 65535:
        raise UserError("--web %d: give a port from 0 (any free one) to 65535" % args.web)


def _map_rows(path):
    from larics_host.mapping.mapfile import read_map

    return read_map(path).rows()


def _show(args, session, stopped):
    """Until the user, the time or the source ends it; a page goes on showing a log that has ended."""
    end_s = None if args.seconds is None else time.monotonic() + args.seconds
    if args.web is not None or not sys.stdout.isatty():
        while not stopped() and (end_s is None or time.monotonic() < end_s):
            if session.ended and args.web is None:
                return
            time.sleep(_REFRESH_S)
        return
    from rich.live import Live

    from larics_host.consoles import Console
    from larics_host.monitor.terminal import render

    with Live(console=Console(), auto_refresh=False) as live:
        while not stopped() and (end_s is None or time.monotonic() < end_s):
            with session.lock:
                ended = session.ended  # once: what is shown last is the end
                content = render(session.state, ended, live.console.size)
            live.update(content, refresh=True)
            if ended:
                return
            time.sleep(_REFRESH_S)


def _conclude(session):
    """Without a terminal the last view is all there is."""
    if not sys.stdout.isatty():
        from larics_host.consoles import Console
        from larics_host.monitor.terminal import render

        console = Console()
        console.print(render(session.state, session.ended, (console.width, _LINES)))
    if session.failed:
        raise UserError(session.ended)
    return 0
