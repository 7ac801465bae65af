"""What is made once for all processes of the tests."""

import fcntl
import os


def made_once(tmp_path_factory, name, make):
    """The folder `name` that `make(folder)` has filled, in the first process that asks for it."""
    base = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        base = base.parent
    whole, part = base / name, base / (name + "-part")
    with open(base / (name + ".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not whole.exists():
            part.mkdir(exist_ok=True)  # there is one already when an earlier try failed
            make(part)
            part.rename(whole)
    return whole
