"""Powers a stand-in board: its console on a terminal device, restarted whenever it resets itself.

    python board_console.py DEVICE FLASH_IMAGE IDENTITY MICROPYTHON...

Reads "on" and "off" from standard input, a line each, and answers each. Off is a loss of power: the
interpreter is killed. "on" is answered by the mark that it put on the line, so that what the board said
before, and what is still on its way, can be told from what it says after. Ctrl-C on the line becomes the
signal that interrupts it, for which it needs a session of its own; this program leads that session and so
keeps the line while the power is off.
"""

import fcntl
import os
import signal
import subprocess
import sys
import termios
import threading
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESET = 42
INTERRUPTED = 130  # Ctrl-C before the board's program could catch it, which no board ends on


class Power:
    def __init__(self, line, command):
        self._line = line
        self._command = command
        self._board = None
        self._is_on = False
        self._changed = threading.Lock()
        self._count = 0

    def on(self):
        self.off()
        self._count += 1
        mark = "[power on %d]" % self._count
        os.write(self._line, b"\r\n%s\r\n" % mark.encode())
        self._is_on = True
        self._start()
        return mark

    def off(self):
        with self._changed:
            self._is_on = False
            if self._board is not None:
                self._board.kill()
                self._board.wait()
        termios.tcflush(self._line, termios.TCIOFLUSH)
        return "off"

    def _start(self, after=None):
        """Starts the board; `after`: only if that one, which has reset itself, is still the last."""
        with self._changed:
            if not self._is_on or (after is not None and after is not self._board):
                return
            self._board = subprocess.Popen(
                self._command,
                stdin=self._line,
                stdout=self._line,
                stderr=self._line,
                cwd=ROOT,
                env=dict(os.environ, MICROPYPATH=".frozen"),
            )
        threading.Thread(target=self._watch, args=(self._board,), daemon=True).start()

    def _watch(self, board):
        code = board.wait()
        if code in (RESET, INTERRUPTED):
            self._start(after=board)
        elif code != -signal.SIGKILL:
            print("the board's interpreter ended with %d" % code, file=sys.stderr, flush=True)


def main(device, image, identity, *interpreter):
    os.setsid()
    line = os.open(device, os.O_RDWR)
    fcntl.ioctl(line, termios.TIOCSCTTY, 0)
    attributes = termios.tcgetattr(line)
    attributes[3] |= termios.ISIG
    termios.tcsetattr(line, termios.TCSANOW, attributes)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # also for the interpreter, until it asks for it
    power = Power(line, [*interpreter, str(ROOT / "tests/board/fake_board.py"), image, identity])
    for order in sys.stdin:
        print(getattr(power, order.strip())(), flush=True)
    power.off()


if __name__ == "__main__":
    main(*sys.argv[1:])
