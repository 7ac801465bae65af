"""Counts what went wrong, by the codes of larics.wire.messages, for the status message."""

from larics.wire.messages import COUNT_MAX


class Faults:
    """total: all faults since the start; last: code of the newest, 0 for none; active: bit n is set while
    the fault with code n lasts."""

    def __init__(self):
        self.total = 0
        self.last = 0
        self.active = 0

    def report(self, code):
        """A fault that is over as soon as it is counted."""
        self.total = (self.total + 1) & COUNT_MAX
        self.last = code

    def begin(self, code):
        """A fault that lasts until `end`; counted once."""
        if not self.active >> code & 1:
            self.active |= 1 << code
            self.report(code)

    def end(self, code):
        self.active &= ~(1 << code)
