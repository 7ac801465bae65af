"""A way back from every program: safe mode, and the watchdog that is armed only when all is set up.

Safe mode starts nothing and leaves the REPL free: by holding the board's button at power-up, by three resets
that each come within ten seconds of the start, or by Ctrl-C while the watchdog runs (it cannot be stopped, so
the board restarts into safe mode). The next reset starts the program again.
"""

import os

SETTLED_MS = 10000
WATCHDOG_MS = 8000
_FAST_RESETS = 3


class SafeMode:
    """`path`: of a small file that counts the starts that did not last; `pressed()`: the button is held."""

    def __init__(self, path, pressed=None):
        self._path = path
        self._pressed = pressed
        self._settled = False

    def begin(self):
        """Call first at every start. True when this start is to be in safe mode. OSError: not writable."""
        starts = self._count() + 1
        if starts >= _FAST_RESETS or (self._pressed is not None and self._pressed()):
            self.forget()
            return True
        self._write(starts)
        return False

    def settled(self, uptime_s):
        """Call often: a start that lasts is a good one."""
        if not self._settled and uptime_s * 1000 >= SETTLED_MS:
            self._settled = True
            self.forget()

    def ask_for_safe_mode(self):
        """The next start will be in safe mode."""
        self._write(_FAST_RESETS - 1)

    def forget(self):
        try:
            os.remove(self._path)
        except OSError:
            pass

    def _count(self):
        try:
            with open(self._path) as file:
                return int(file.read(4))
        except (OSError, ValueError):
            return 0

    def _write(self, starts):
        with open(self._path, "w") as file:
            file.write(str(starts))


class NoWatchdog:
    def feed(self):
        pass


def make_watchdog():
    """The running watchdog, or one that does nothing where the board has none."""
    try:
        from machine import WDT

        return WDT(timeout=WATCHDOG_MS)
    except (ImportError, ValueError, OSError, TypeError):
        return NoWatchdog()


def was_watchdog():
    """Whether the watchdog made this start necessary."""
    try:
        import machine

        return machine.reset_cause() == machine.WDT_RESET
    except (ImportError, AttributeError):
        return False
