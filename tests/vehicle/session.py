"""A vehicle in C, driven line by line: see session.c."""

import subprocess
from collections import namedtuple

NAMES = (
    *("waiting", "silent", "foreign", "restarted", "unproven", "faulty", "stalled", "frozen", "damaged"),
    *("overrun", "no_marker", "unusable", "strayed", "imprecise", "good", "no_status"),
)
NEVER = 0xFFFFFFFF
View = namedtuple("View", "state age_ms id x y")


class Session:
    """limits: those that differ from the usual ones. `now` is the vehicle's clock in ms."""

    def __init__(self, program, now=1000, seed=1, **limits):
        self._process = subprocess.Popen(
            [str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for name, value in limits.items():
            self._say("set", name, value)
        self._say("init", now, seed)
        self.now = now

    def _say(self, *words):
        self._process.stdin.write(" ".join(map(str, words)) + "\n")

    def _ask(self, *words):
        self._say(*words)
        self._process.stdin.flush()
        return self._process.stdout.readline().strip()

    def turn(self, now, data=b""):
        """One turn of the loop: the time is read, then what has come is."""
        self.now = now
        self._say("drain", now % 2**32)
        if data:
            self._say("feed", data.hex())

    def at(self, now, data=b""):
        """Turns of the loop until then that find nothing, and one that finds this."""
        self._say("idle", now % 2**32)
        self.turn(now, data)

    def later(self, data, wait_ms=2):
        """The same, so much later."""
        self.at(self.now + wait_ms, data)

    def blocked(self, data, wait_ms):
        """The next turn comes so much later."""
        self.turn(self.now + wait_ms, data)

    def feed(self, data):
        self._say("feed", data.hex())

    def _view(self, kind, now):
        numbers = self._ask(kind, (self.now if now is None else now) % 2**32).split()
        return View(NAMES[int(numbers[0])], *map(int, numbers[1:]))

    def marker(self, now=None):
        return self._view("marker", now)

    def pose(self, now=None):
        return self._view("pose", now)

    def status_age_ms(self):
        return int(self._ask("status", self.now % 2**32))

    def may_search(self):
        return self._ask("search", self.now % 2**32) == "1"

    def may_drive_by(self):
        """Whether the last message may be driven by."""
        return self._ask("by", self.now % 2**32) == "1"

    def challenge(self):
        """Bytes of the challenge that is due now, b"" for none."""
        return bytes.fromhex(self._ask("ask", self.now % 2**32).replace("-", ""))

    def follow(self, here, following):
        self._say("follow", here, following)

    def noticed(self):
        return {name: int(n) for name, n in (pair.split("=") for pair in self._ask("noticed").split())}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        assert self._process.wait(timeout=300) == 0  # a sanitizer would have ended it otherwise
        self._process.stdout.close()


def started(program, camera, **limits):
    """A Session that has heard INFO, STATUS and one marker of a recorded.Stream."""
    session = Session(program, **limits)
    session.later(camera.info() + camera.status(1))
    session.later(camera.marker())
    return session
