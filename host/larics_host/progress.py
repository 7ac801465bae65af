"""A progress bar on standard error, for a person who would otherwise see nothing happen."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")


def watched(
    items: Iterable[T], total: int | None = None, label: str = "frames", quiet_stdout: bool = False
) -> Iterator[T]:
    """Passes `items` through and shows how far they are; `total` is their number, None when unknown.

    Silent unless standard error is a terminal and standard output is not: a table there shows the same.
    quiet_stdout: nothing goes to standard output meanwhile, so the bar is shown beside it, too.
    """
    if not sys.stderr.isatty() or (sys.stdout.isatty() and not quiet_stdout):
        yield from items
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from larics_host.consoles import Console

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=total)
        for item in items:
            yield item
            bar.advance(task)


@contextlib.contextmanager
def measured(total: int, label: str = "frames") -> Iterator[Callable[[float], object]]:
    """A function to call with how much is done, parts of an item too, shown as a bar on a terminal."""
    from rich.progress import Progress

    from larics_host.consoles import Console

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(label, total=total)
        yield lambda done: bar.update(task, completed=done)
