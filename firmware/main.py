"""What the board starts: the newest whole program on its flash or, if that cannot be loaded, the one before.

A program lies in one of two folders or in ROMFS, and is whole when the file `complete`, written last, holds
its number.
Without such a folder the program is looked for in the library (as `mip` installs it).
"""

import os
import sys

FOLDERS = ("larics_a", "larics_b")
ROM = "/rom"  # files that are read in place


def root():
    return "/flash/" if "flash" in os.listdir("/") else "/"


def programs():
    """Paths of the whole programs, newest first."""
    found = []
    for path in [root() + name for name in FOLDERS] + [ROM]:
        try:
            with open(path + "/complete") as file:
                found.append((int(file.read()), path))
        except (OSError, ValueError):
            pass
    return [path for _, path in sorted(found, reverse=True)]


def forget(path):
    """Takes back what was imported from there."""
    sys.path.remove(path)
    for name in list(sys.modules):
        if getattr(sys.modules[name], "__file__", "").startswith(path):
            del sys.modules[name]


def load():
    """The module that starts the program."""
    for path in programs():
        sys.path.insert(0, path)
        try:
            import start

            return start
        except Exception as error:
            print("larics: the program in %s cannot be loaded" % path)
            sys.print_exception(error)
            forget(path)
    import start

    return start


load().main()
