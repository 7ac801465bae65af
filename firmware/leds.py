"""Lights that a person can read.

green steady       TRACKING
green blinking     COASTING, or carried by odometry
blue flash         LOST: alive, no marker; one flash a second
red flashes        a fault lasts: as many flashes as its code, then a pause
all steady         safe mode
"""

_PERIOD_MS = 1000
_FLASH_MS = 60
_COAST_MS = 125
_RED_MS = 300  # one flash and the gap behind it
_PAUSE_MS = 1500


class Leds:
    """`red`, `green`, `blue`: objects with on() and off(), as machine.LED."""

    def __init__(self, red, green, blue):
        self._leds = (red, green, blue)
        self._lit = [True, True, True]
        self._phase_ms = 0
        self._red_ms = 0
        self._last_ms = None
        self.all(False)

    def all(self, on):
        for index in range(3):
            self._set(index, on)

    def _set(self, index, on):
        if self._lit[index] != on:
            self._lit[index] = on
            if on:
                self._leds[index].on()
            else:
                self._leds[index].off()

    def show(self, tracking, coasting, active_faults, elapsed_ms):
        """Call often; elapsed_ms: since the call before. `active_faults`: bit n for the fault with code n."""
        self._phase_ms = (self._phase_ms + elapsed_ms) % _PERIOD_MS
        self._set(1, tracking or (coasting and self._phase_ms // _COAST_MS & 1 == 0))
        self._set(2, not tracking and not coasting and self._phase_ms < _FLASH_MS)
        self._show_fault(active_faults, elapsed_ms)

    def _show_fault(self, active_faults, elapsed_ms):
        if not active_faults:
            self._red_ms = 0
            self._set(0, False)
            return
        code = 0
        while not active_faults >> code & 1:
            code += 1
        self._red_ms = (self._red_ms + elapsed_ms) % (code * _RED_MS + _PAUSE_MS)
        self._set(0, self._red_ms < code * _RED_MS and self._red_ms % _RED_MS < _RED_MS // 2)


class NoLeds:
    """For boards without."""

    def all(self, on):
        pass

    def show(self, tracking, coasting, active_faults, elapsed_ms):
        pass


def make_leds(names):
    """The board's LEDs; `names` as in larics.boards."""
    if names:
        try:
            from machine import LED

            return Leds(*[LED(name) for name in names])
        except (ImportError, ValueError, OSError):
            pass
    return NoLeds()
