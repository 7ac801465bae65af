"""Tasks on this computer's cores or on a Dask cluster: the same results in the same order.

What a task returns must not depend on where it runs; then nothing that follows does. A task is given out
again when the worker that had it dies, and results are fetched as soon as they are there, so that what lay on
a dead worker is not computed twice.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import multiprocessing
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeVar

from larics_host.errors import UserError, missing_package, report_once

Task = TypeVar("Task")
Answer = TypeVar("Answer")

_AHEAD = 4  # tasks a worker that are under way or done before their turn
_CONNECT_S = 20
_RETRIES = 3  # of a task whose worker died
_POLL_S = 0.01
_PATIENCE_S = 20  # without a worker, until that is told


def run(
    function: Callable[[Task], Answer],
    tasks: Iterable[Task],
    jobs: int = 1,
    scheduler: str | None = None,
) -> Iterator[Answer]:
    """Yields function(task) for all tasks, in their order; at most a few per worker are under way at a time.

    function   of a module, so that another process finds it;  jobs  processes here
    scheduler  address of a Dask scheduler instead, "tcp://host:8786". UserError when there is none, when it
               is of another version, or when it dies
    """
    if scheduler:
        yield from _on_cluster(function, tasks, scheduler)
    elif jobs == 1:
        yield from map(function, tasks)
    else:
        yield from _here(function, tasks, jobs)


def _here(function, tasks, jobs):
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, context) as pool:
        waiting = deque()
        try:
            for task in tasks:
                waiting.append(pool.submit(function, task))
                if len(waiting) >= _AHEAD * jobs:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        except BrokenProcessPool:
            raise UserError(
                "a process was ended from outside, for want of memory? give fewer --jobs"
            ) from None
        finally:
            for future in waiting:
                future.cancel()


@functools.cache
def fingerprint() -> str:
    """Of the sources that make the results, so that no worker mixes in those of another version."""
    import larics
    import larics_host

    digest = hashlib.sha256()
    for package in (larics, larics_host):
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*.py")):
            inside = path.relative_to(folder)
            if inside.parts[0] != "board":  # a wheel's copy for boards
                digest.update(str(inside).encode() + path.read_bytes())
    return digest.hexdigest()


class _OtherVersion(Exception):
    """A worker's larics is not that of this computer."""


def guarded(function: Callable[[Task], Answer], task: Task, wanted: str) -> Answer:
    """function(task) on a worker, if its sources are the wanted ones."""
    if fingerprint() != wanted:
        raise _OtherVersion
    return function(task)


def _on_cluster(function, tasks, address):
    try:
        import distributed
    except ImportError:
        raise missing_package("--scheduler", "distributed") from None
    for name in ("distributed", "tornado", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what goes wrong is one line, said here
    with warnings.catch_warnings(), contextlib.closing(_connect(distributed, address)) as client:
        warnings.simplefilter("ignore")
        _check_versions(distributed, client, address)
        yield from _submitted(distributed, client, function, tasks, address)


def _connect(distributed, address):
    from distributed.comm.addressing import get_address_host_port

    try:
        get_address_host_port(address)
    except (ValueError, RuntimeError):
        text = "--scheduler %s is no address: give one as tcp://127.0.0.1:8786"
        raise UserError(text % address) from None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of versions: those are checked
        try:
            return distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, TimeoutError):
            text = "no Dask scheduler answers at %s: start one by `dask scheduler`, or leave --scheduler out"
            raise UserError(text % address) from None


def _check_versions(distributed, client, address):
    try:
        scheduler = client.get_versions()["scheduler"]
    except Exception:
        raise _lost(address) from None
    theirs = scheduler["packages"].get("distributed") if scheduler else None
    if theirs != distributed.__version__:
        raise UserError(
            "the scheduler at %s has distributed %s, this computer %s: install the same on all"
            % (address, theirs, distributed.__version__)
        )


def _lost(address):
    return UserError(
        "the scheduler at %s is gone: start it and its workers again, then this command; nothing was written"
        % address
    )


def _workers(client):
    return len(client.scheduler_info(n_workers=-1)["workers"])


class _UnderWay:
    """Tasks that were given out and whose turn has not come: {key of a future: (number, task, how often)}."""

    def __init__(self, distributed, client, function):
        self.queue = distributed.as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self._client = client
        self._function = function
        self._wanted = fingerprint()
        self._tasks = {}

    def give(self, number, task, times=0):
        future = self._client.submit(
            guarded, self._function, task, self._wanted, pure=False, retries=_RETRIES
        )
        self._tasks[future.key] = number, task, times
        self.queue.add(future)

    def take(self, future):
        return self._tasks.pop(future.key)


def _submitted(distributed, client, function, tasks, address) -> Generator[Any]:
    under_way = _UnderWay(distributed, client, function)
    ready: dict[int, Any] = {}
    numbered = enumerate(tasks)
    given = done = 0
    more = True
    while more or done < given:
        limit = _AHEAD * max(2, _workers(client))
        while more and given - done < limit:
            number, task = next(numbered, (-1, None))
            more = number >= 0
            if more:
                under_way.give(number, task)
                given += 1
        if done == given:
            return
        future, answer = _next(client, under_way.queue, address)
        number, task, times = under_way.take(future)
        if future.status == "finished":
            ready[number] = answer
        elif future.status == "error":
            raise _failed(distributed, answer, address)
        elif client.status != "running" or times == _RETRIES:
            raise _lost(address)
        else:  # its worker died with the result
            under_way.give(number, task, times + 1)
        future.release()
        while done in ready:
            yield ready.pop(done)
            done += 1


def _next(client, queue, address):
    """The next future that is done, with its result; who waits in vain for workers is told so."""
    waited_s = 0.0
    while not queue.has_ready():
        time.sleep(_POLL_S)
        waited_s += _POLL_S
        if client.status != "running":
            raise _lost(address)
        if waited_s > _PATIENCE_S:
            waited_s = 0.0
            if not _workers(client):
                text = "the scheduler at %s has no worker, and one is waited for: dask worker %s"
                report_once("workers", text % (address, address))
    return next(queue)


def _failed(distributed, answer, address):
    """The error for what a task raised; `answer` as of as_completed: (type, error, traceback)."""
    error = answer[1]
    if isinstance(error, _OtherVersion):
        return UserError("a worker of %s has another version of larics: install the same on all" % address)
    if isinstance(error, ModuleNotFoundError):
        return missing_package("a worker of %s" % address, str(error.name))
    if isinstance(error, distributed.KilledWorker):
        return UserError("a task ended one worker of %s after the other, for want of memory?" % address)
    return error
