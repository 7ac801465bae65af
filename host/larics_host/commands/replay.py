"""`larics replay`: what a log holds, byte for byte, to a pseudo-terminal, a port or standard output."""

from __future__ import annotations

import argparse
import sys
import time

from larics_host.errors import UserError
from larics_host.wording import counted

NAME = "replay"
HELP = "send a recorded log once more: to a pseudo-terminal, a serial port or standard output"
EXAMPLE = """
larics replay run.jsonl                          # prints the name of a pseudo-terminal to open
larics replay run.bin --port /dev/ttyUSB0 --speed 0.5
larics replay run.bin --stdout --fast | larics log --input - -o again
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("log", metavar="FILE", help="of larics log: .jsonl, .bin, .mcap, or .csv (markers)")
    target = parser.add_mutually_exclusive_group()
    target.add_argument("--port", metavar="DEVICE", help="send to this serial port, not to a pseudo-terminal")
    target.add_argument("--stdout", action="store_true", help="write to standard output")
    parser.add_argument("--baud", type=int, default=115200, help="of the port, or where a .bin has no times")
    pace = parser.add_mutually_exclusive_group()
    pace.add_argument("--fast", action="store_true", help="without waiting")
    pace.add_argument("--speed", metavar="X", type=float, default=1.0, help="times the original speed (1)")
    parser.add_argument("--rounds", metavar="N", type=int, default=1, help="how often; 0: for ever")


class _StdoutTarget:
    def begin(self):
        pass

    def write(self, data):
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()

    def end(self):
        pass


class _PortTarget:
    def __init__(self, port, baud):
        from larics_host.connection.byte_sources import SerialSource

        self._port = SerialSource(port, baud)

    def begin(self):
        pass

    def write(self, data):
        from larics_host.connection.byte_sources import ConnectionLost

        try:
            self._port.write(data)
        except ConnectionLost as error:
            raise UserError(str(error)) from None

    def end(self):
        self._port.flush()
        self._port.close()


class _PtyTarget:
    def __init__(self):
        from larics_host.connection.pty_port import PtyPort

        self._port = PtyPort()

    def begin(self):
        print("%s: open this as the camera's port; replay begins then" % self._port.device, flush=True)
        self._port.wait_for_reader()

    def write(self, data):
        try:
            self._port.write(data)
        except BrokenPipeError as error:
            raise UserError(str(error)) from None

    def end(self):
        self._port.drain()
        self._port.close()


def _target(args):
    if args.stdout:
        return _StdoutTarget()
    if args.port:
        return _PortTarget(args.port, args.baud)
    return _PtyTarget()


def run(args: argparse.Namespace) -> int:
    from larics_host.logs.log_reader import read_pieces
    from larics_host.logs.log_source import Pacer

    if not args.speed > 0:
        raise UserError("--speed %g: give a number above 0, or --fast" % args.speed)
    if not args.baud > 0:
        raise UserError("--baud %d: give a number above 0" % args.baud)
    if args.rounds < 0:
        raise UserError("--rounds %d: give a number from 0 on" % args.rounds)
    next(read_pieces(args.log))  # what cannot be read is told before anybody waits for it
    target = _target(args)
    target.begin()
    start_s = time.monotonic()
    count = size = done = 0
    while not args.rounds or done < args.rounds:
        pacer = Pacer(0 if args.fast else args.speed, args.baud)
        for piece in read_pieces(args.log):
            pacer.wait(piece)
            target.write(piece.data)
            count += 1
            size += len(piece.data)
        done += 1
    target.end()
    elapsed_s = time.monotonic() - start_s
    line = "%s, %s in %.1f s" % (counted(count, "message"), counted(size, "byte"), elapsed_s)
    print(line, file=sys.stderr if args.stdout else sys.stdout)
    return 0
