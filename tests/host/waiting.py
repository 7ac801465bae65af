"""Waiting for what a test needs, as long as a machine with other work may take."""

import time

PATIENCE_S = 300  # reached only where something is broken


def wait_until(condition, limit_s=PATIENCE_S):
    """Returns when `condition()` is true."""
    end_s = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end_s, "never came true"
        time.sleep(0.02)


def wait_for_lines(path, count):
    """Returns when the file has that many lines."""

    def there():
        return path.exists() and len(path.read_text().splitlines()) >= count

    wait_until(there)


class Clock:
    """In place of the module `time`: `sleep` lets `now_s` pass at once."""

    def __init__(self):
        self.now_s = 0.0

    def monotonic(self):
        return self.now_s

    def time_ns(self):
        return round(self.now_s * 1e9)

    def sleep(self, seconds):
        self.now_s += seconds
