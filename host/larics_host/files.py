"""Files that a user names: what goes wrong with them becomes one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


def read_json(path: StrPath) -> Any:
    """What a JSON file holds. UserError when it cannot be read or is none."""
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except ValueError:
        raise UserError("%s is no JSON file" % path) from None


def write_file(path: StrPath, content: bytes | str) -> None:
    """Writes bytes, or text as UTF-8, names of files that are none escaped. UserError when that fails."""
    data = content.encode(errors="backslashreplace") if isinstance(content, str) else content
    try:
        Path(path).write_bytes(data)
    except OSError as error:
        raise UserError("cannot write %s: %s" % (path, error.strerror)) from error


def refuse_existing(path: StrPath, force: bool) -> None:
    """UserError when the file is there already and may not be overwritten."""
    if Path(path).exists() and not force:
        raise UserError("%s exists: choose another name, or --force to overwrite it" % path)
