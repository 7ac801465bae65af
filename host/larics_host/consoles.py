"""rich's Console with the program's own way to end when nobody reads its output."""

from __future__ import annotations

import rich.console


class Console(rich.console.Console):
    """Lets BrokenPipeError through, where rich would end the program with a code of its own."""

    def on_broken_pipe(self) -> None:
        raise  # noqa: PLE0704 (rich calls this while it handles the BrokenPipeError)
