"""What the board starts: the newest whole program on its flash or, if that cannot be loaded, the one before.

A program lies in one of two folders and is whole when the file `complete`, written last, holds its number.
Without such a folder the program is looked for in the library (as `mip` installs it).
"""

import gc
import os
import sys

FOLDERS = ("larics_a", "larics_b")


def root():
    return "/flash/" if "flash" in os.listdir("/") else "/"


def programs():
    """Paths of the whole programs, newest first."""
    found = []
    for name in FOLDERS:
        path = root() + name
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


def threshold(heap_bytes):
    """Bytes between collections while loading: what that leaves cuts up a small heap, but to look for it in a
    large one takes longer than all the rest of the start."""
    if heap_bytes < 320 << 10:
        return 8192
    if heap_bytes <= 512 << 10:
        return 16384
    return heap_bytes >> 3 if heap_bytes <= 2 << 20 else -1


gc.threshold(threshold(gc.mem_free() + gc.mem_alloc()))
load().main()
