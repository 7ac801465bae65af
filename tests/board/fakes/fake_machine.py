"""Stand-in for a board's `machine` module. A test sets `world`."""


class World:
    def __init__(self):
        self.cause = 1
        self.button_held = False
        self.fed = 0
        self.watchdog_ms = None
        self.resets = 0
        self.lit = {}
        self.uart = None
        self.uart_arguments = None


world = World()
PWRON_RESET, HARD_RESET, WDT_RESET = 1, 2, 3


class Reset(BaseException):
    """Nothing runs after a reset."""


def reset():
    world.resets += 1
    raise Reset()


def reset_cause():
    return world.cause


def unique_id():
    return b"\x01\x02\x03\x04\x05\x06"


class WDT:
    def __init__(self, *, timeout):
        if not 500 <= timeout <= 32000:
            raise ValueError("WDT timeout out of range")
        world.watchdog_ms = timeout

    def feed(self):
        world.fed += 1


class LED:
    def __init__(self, name):
        if name not in ("LED_RED", "LED_GREEN", "LED_BLUE"):
            raise ValueError("LED doesn't exist")
        self.name = name

    def on(self):
        world.lit[self.name] = True

    def off(self):
        world.lit[self.name] = False


class Pin:
    IN, PULL_UP = 0, 1

    def __init__(self, name, mode=-1, pull=-1):
        if name not in ("SW", 0):
            raise ValueError("Pin doesn't exist")

    def value(self):
        return 0 if world.button_held else 1


class UART:
    """stm32: txbuf is refused."""

    def __init__(self, number, baudrate=9600, *, timeout=0, timeout_char=0, rxbuf=64):
        world.uart_arguments = (number, baudrate)
        self._real = world.uart

    def write(self, *arguments):
        return self._real.write(*arguments)

    def any(self):
        return self._real.any()

    def readinto(self, *arguments):
        return self._real.readinto(*arguments)
