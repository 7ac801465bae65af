"""Peers' figures of an earlier run: what they make of a frame does not change with our code."""

import json

from . import methods


def load(path, now):
    """The results.json at `path` (a Path), whose frames must be those of the run that begins as `now`
    ({"frames": ..., "seed": ..., "renderer": ...}). ValueError, in one line, for any other file."""
    try:
        results = json.loads(path.read_text(encoding="utf-8"))
        other = [key for key, value in now.items() if results[key] != value]
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise ValueError("%s is no results.json of the bench: %r" % (path, error)) from error
    if other:
        raise ValueError(
            "%s is of other frames (%s), so it cannot stand beside this run; measure it again"
            % (path, ", ".join("%s %s, now %s" % (key, results[key], now[key]) for key in other))
        )
    return results


def in_order(rows_of):
    """{method: rows} in the order of all methods."""
    return {name: rows_of[name] for name in methods.METHODS if name in rows_of}
