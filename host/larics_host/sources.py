"""Where the firmware's sources are: in a checkout beside the package, in an installed wheel within it."""

from __future__ import annotations

from pathlib import Path

from larics_host.errors import UserError

_HERE = Path(__file__).resolve().parent
_PLACES = (_HERE.parents[1], _HERE / "board")


def source_root() -> Path:
    """The folder that holds firmware/ and shared/. Raises UserError when the package came without them."""
    for place in _PLACES:
        if (place / "firmware" / "start.py").is_file() and (place / "shared" / "larics").is_dir():
            return place
    raise UserError(
        "the firmware's sources are not in this installation: install the wheel, or use a checkout"
    )
