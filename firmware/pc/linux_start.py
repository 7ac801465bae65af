"""Starts linux_main, with its arguments. Its modules take a second to load: Ctrl-C ends it without a
traceback meanwhile, too."""

import signal
import sys


def start(arguments):
    """Never returns."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from pc import linux_main

    linux_main.run(arguments)


if __name__ == "__main__":
    start(sys.argv[1:])
