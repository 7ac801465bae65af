"""Settings of a camera over the wire, and of files: read, checked together, changed in a safe order."""

from __future__ import annotations

import contextlib
import difflib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from larics import settings as setting_rules
from larics_host import files
from larics_host.connection.byte_sources import ConnectionLost
from larics_host.connection.client import PATIENT, Client
from larics_host.connection.lines import open_line
from larics_host.errors import UserError
from larics_host.progress import watched

if TYPE_CHECKING:
    from larics.settings import Settings
    from larics_host.annotations import StrPath


@contextlib.contextmanager
def connected(
    port: str, baud: int = 115200, on_message: Callable[[int, int, Sequence[Any]], object] | None = None
) -> Iterator[Client]:
    """A Client of the camera at a serial port or address. One that vanishes becomes a UserError."""
    source = open_line(port, baud, timeout_s=0.02)
    try:
        yield Client(source, on_message, retries=PATIENT)
    except ConnectionLost as error:
        raise UserError(str(error)) from None
    finally:
        source.close()


def add_port_arguments(parser: Any, required: bool = True) -> None:
    parser.add_argument(
        "--port", metavar="DEVICE", required=required, help="serial port of the camera, or tcp://HOST:PORT"
    )
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")


def read_all(client: Client) -> dict[str, Any]:
    """{name: value} of all settings that a camera has."""
    names = [f.name for f in setting_rules.FIELDS]
    return client.get_all(watched(names, len(names), "settings", True))


def checked(values: dict[str, Any]) -> Settings:
    """A Settings of these values; UserError in one line when they cannot be."""
    try:
        return setting_rules.Settings(values)
    except ValueError as error:
        raise UserError(str(error)) from None


def differences(before: dict[str, Any], after: dict[str, Any]) -> list[tuple[str, Any, Any]]:
    """[(name, value before, value after)] of the settings that both have and that differ, in the order of the
    table."""
    return [
        (f.name, _plain(before[f.name]), _plain(after[f.name]))
        for f in setting_rules.FIELDS
        if f.name in before and f.name in after and _plain(before[f.name]) != _plain(after[f.name])
    ]


def _plain(value):
    return [_plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def apply(client: Client, current: dict[str, Any], changes: dict[str, Any]) -> list[str]:
    """Sends changes {name: value} to a camera that has the values `current`; returns the names sent.

    All is checked before anything is sent, and one setting after the other goes when it fits those that
    the camera has by then. Raises UserError, also for a change of what the camera's firmware does not have,
    unless that is the default, by which it does without.
    """
    wanted = checked({**current, **changes}).as_dict()
    for name, _, value in differences(checked(current).as_dict(), wanted):
        if name not in current:
            text = "%s = %s: the camera's firmware is older and has no such setting; larics flash renews it"
            raise UserError(text % (name, json.dumps(value)))
    _refuse_other_size(current, wanted, changes)
    steps = differences(current, wanted)
    camera = checked(current)
    order = []
    while steps:
        for step in steps:
            with contextlib.suppress(ValueError):
                camera.set(step[0], step[2])
                break
        else:
            names = ", ".join(name for name, _, _ in steps)
            raise UserError("%s cannot be changed one after the other: change others first" % names)
        steps.remove(step)
        order.append(step)
    for name, _, value in watched(order, len(order), "settings", True):
        client.set(name, value)
        if _plain(client.get(name)) != value:
            raise UserError("the camera took %s but reports another value" % name)
    return [name for name, _, _ in order]


def _refuse_other_size(current, wanted, changes):
    """A calibration is for the frame size that it was made with: width and height stand beside it."""
    size, before = (wanted["width"], wanted["height"]), (current["width"], current["height"])
    if size == before or not wanted["focal_q8"] or "focal_q8" in changes:
        return
    raise UserError(
        "the calibration is for frames of %d x %d px, not %d x %d: calibrate anew for those, or set "
        "focal_q8 with the size (0: not calibrated)" % (*before, *size)
    )


def calibrated_for(settings: Any, width: int, height: int) -> str | None:
    """None when frames of this size suit the calibration in the settings, else why not."""
    if not settings.focal_q8 or (settings.width, settings.height) == (width, height):
        return None
    sizes = (settings.width, settings.height, width, height)
    return "the settings are calibrated for frames of %d x %d px, these are %d x %d" % sizes


def doubts(settings: Any) -> list[str]:
    """What is allowed and yet does not fit together, one line each."""
    if not settings.focal_q8 or not settings.ceiling_mm10:
        return []
    height_mm10 = settings.ceiling_mm10 - settings.camera_z_mm10
    radius_px = settings.focal_q8 / 256 * settings.outer_mm10 / height_mm10
    low, high = settings.radius_min_px, settings.radius_max_px
    if low <= radius_px <= high:
        return []
    ring = settings.outer_mm10, settings.ceiling_mm10, radius_px
    text = "a ring of outer_mm10 = %d at ceiling_mm10 = %d has a radius of %.0f px, " % ring
    return [text + "outside radius_min_px = %d to radius_max_px = %d: one of them is wrong" % (low, high)]


def parse_value(name: str, text: str) -> Any:
    """The value of a setting from the text that a user typed: JSON, a bare word, 1,2,3 or, for IDs, 1-7,9."""
    field = setting_rules.field(name)
    if field is None:
        known = ", ".join(entry.name for entry in setting_rules.FIELDS)
        raise UserError("there is no setting %s; there are: %s" % (name, known))
    if field.kind == "ranges" and not text.startswith("["):
        text = "[%s]" % re.sub(r"(\d+)-(\d+)", r"[\1,\2]", text)
    if field.kind == "list" and not text.startswith("["):
        text = "[%s]" % text
    try:
        value = files.parse_json(text)
    except ValueError:
        value = text
    reason = field.reason(value)
    if reason:
        raise UserError(reason)
    return value


def parse_changes(words: Iterable[str]) -> dict[str, Any]:
    """{name: value} of words NAME=VALUE. Raises UserError."""
    changes: dict[str, Any] = {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals:
            raise UserError("%s is not NAME=VALUE" % word)
        if name in changes:
            raise UserError("%s is given twice" % name)
        changes[name] = parse_value(name, text)
    return changes


def _misfit(name, value):
    """Why a name or a value of a file cannot be, where another reason than the table's own is nearer."""
    field = setting_rules.field(name)
    if field is None and name != "version":
        near = difflib.get_close_matches(name, [entry.name for entry in setting_rules.FIELDS], 1)
        hint = "; is %s meant?" % near[0] if near else "; larics settings show lists them"
        return "there is no setting %s%s" % (name, hint)
    if field is not None and field.kind not in ("int", "bool"):
        return None
    allowed = "1" if field is None else field.range_text()
    if isinstance(value, str):
        return "%s is the text %s: write it without quotes, %s" % (name, json.dumps(value), allowed)
    if value is None or (isinstance(value, (bool, float)) and getattr(field, "kind", "") != "bool"):
        return "%s is %s: give a whole number, %s" % (name, json.dumps(value), allowed)
    return None


def read_file(path: StrPath) -> dict[str, Any]:
    """{name: value} of the settings in a JSON file, the version left out; the values are those allowed."""
    values = files.read_json(path)
    if not isinstance(values, dict):
        raise UserError("%s is no table of names and values" % path)
    for name, value in values.items():
        reason = _misfit(name, value)
        if reason:
            raise UserError("%s: %s" % (path, reason))
    try:
        checked(values)
    except UserError as error:
        raise UserError("%s: %s" % (path, error)) from None
    values.pop("version", None)
    return values


def write_file(path: StrPath, values: dict[str, Any]) -> None:
    """Writes all settings, those not in `values` with their defaults, one a line."""
    complete = checked(values).as_dict()
    lines = ["%s: %s" % (json.dumps(name), json.dumps(complete[name])) for name in sorted(complete)]
    files.write_file(path, "{\n " + ",\n ".join(lines) + "\n}\n")
