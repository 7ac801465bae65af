"""Files that a user names: what goes wrong with them becomes one line."""

import json
from pathlib import Path

from larics_host.errors import UserError


def read_json(path):
    """What a JSON file holds. UserError when it cannot be read or is none."""
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except ValueError:
        raise UserError("%s is no JSON file" % path) from None


def write_file(path, content):
    """Writes bytes, or text as UTF-8, names of files that are none escaped. UserError when that fails."""
    data = content.encode(errors="backslashreplace") if isinstance(content, str) else content
    try:
        Path(path).write_bytes(data)
    except OSError as error:
        raise UserError("cannot write %s: %s" % (path, error.strerror)) from error


def refuse_existing(path, force):
    """UserError when the file is there already and may not be overwritten."""
    if Path(path).exists() and not force:
        raise UserError("%s exists: choose another name, or --force to overwrite it" % path)
