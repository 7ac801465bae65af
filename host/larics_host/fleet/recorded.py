"""Frames that `larics record` kept beside a log: what the camera told of them, and what they read here."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import PurePosixPath
from typing import Any, NamedTuple

from larics_host.commands.record import MESSAGES, SETTINGS
from larics_host.connection.camera_settings import checked, read_file
from larics_host.errors import UserError, withheld
from larics_host.fleet.sources import Block, Source, local_copy
from larics_host.fleet.tally import Tally, Told, Work, read_block
from larics_host.images.frame_folder import number_of
from larics_host.images.frame_sources import open_frames
from larics_host.logs.log_records import read_objects
from larics_host.validation.board import begin
from larics_host.validation.sources import base_name


class FramesWork(NamedTuple):
    """A task: the frames beside the log that is `block.source`."""

    block: Block


def with_frames(logs: Iterable[Source]) -> Iterator[Source]:
    """Those of the logs that lie in a folder of larics record."""
    for source in logs:
        path = PurePosixPath(source.path)
        if path.name == MESSAGES + ".jsonl" and _exists(source, str(path.with_name(SETTINGS))):
            yield source


def _exists(source, path):
    try:
        source._replace(path=path).open().close()
    except OSError:
        return False
    return True


def do(work: Work | FramesWork) -> Told:
    """The work on a block or on frames, in whatever process."""
    if isinstance(work, Work):
        return read_block(work)
    source = work.block.source
    with withheld() as told:
        try:
            return Told(_compare(source), None, told)
        except UserError as error:
            return Told(None, "the frames beside %s: %s" % (source.name, error), told)
        except OSError as error:
            return Told(None, "cannot read %s: %s" % (source.name, error.strerror or error), told)


def _compare(source):
    folder = PurePosixPath(source.path).parent
    with contextlib.ExitStack() as stack:
        beside = source._replace(path=str(folder / SETTINGS))
        settings = checked(read_file(stack.enter_context(local_copy(beside))))
        reported = _reported(stack.enter_context(local_copy(source)))
    where = str(folder) if source.system is None else source.system.unstrip_protocol(str(folder))
    # seconds lie between two recorded frames: none is looked at as the next one of the one before
    settings.set("confirm_needed", 1)
    settings.set("tracking", False)
    tally = Tally()
    for name, frame in open_frames([where]):
        number = number_of(base_name(name))
        if number not in reported:
            continue
        told, here = reported[number], _ids(begin(settings, frame).messages(number, frame))
        if told != here:  # as a board with a small heap reads it
            small = _ids(begin(settings, frame, weigh_all=False).messages(number, frame))
            here = small if told == small else here
        tally.recorded += 1
        tally.recorded_alike += told == here
        if told != here and told and here:
            tally.conflicts += 1
            tally.conflict_frames.append((name, told, here))
    return tally


def _reported(path):
    """{frame number: the IDs that were told without doubt, sorted} of a log."""
    found: dict[int, list[dict[str, Any]]] = {}
    for record in read_objects(path):
        if record["message"] == "MARKER":
            found.setdefault(record["frame"], []).append(record)
    return {number: _ids(records) for number, records in found.items()}


def _ids(records):
    return sorted(record["id"] for record in records if record["id"] is not None)
