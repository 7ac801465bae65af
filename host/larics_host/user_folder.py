"""Where the tools keep what is the user's own."""

from __future__ import annotations

import os
from pathlib import Path


def user_folder() -> Path:
    """The folder `larics` in the user's configuration folder; it may not be there yet."""
    folder = os.environ.get("XDG_CONFIG_HOME") or os.path.join(os.path.expanduser("~"), ".config")
    return Path(folder) / "larics"
