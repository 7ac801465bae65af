"""`larics settings`: what a camera is told, over the wire and in files."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from larics_host.errors import UserError
from larics_host.wording import counted

NAME = "settings"
HELP = "show, change, save and compare the settings of a camera"
EXAMPLE = """
larics settings show --port /dev/ttyACM0
larics settings set --port /dev/ttyACM0 ceiling_mm10=25000 radius_min_px=20 --save
larics settings export --port /dev/ttyACM0 camera.json
larics settings diff --port /dev/ttyACM0 camera.json
larics settings restore --port /dev/ttyACM0 camera.json --save
"""

_TABLE_WIDE = 100  # letters; on a narrower terminal each setting has lines of its own


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")

    def action(name, text, with_port=True):
        from larics_host.connection.camera_settings import add_port_arguments

        added = actions.add_parser(name, help=text, description=text)
        if with_port:
            add_port_arguments(added)
        return added

    show = action("show", "all settings with range, unit and meaning")
    show.add_argument("--json", action="store_true", help="names and values as JSON on standard output")
    action("get", "the values of some settings, as JSON").add_argument("names", metavar="NAME", nargs="+")
    change = action("set", "change settings; all are checked together before any is sent")
    change.add_argument("changes", metavar="NAME=VALUE", nargs="+", help="lists as 1,2,3; tables as JSON")
    diff = action("diff", "what differs from a file, or from the defaults")
    diff.add_argument("file", metavar="FILE.json", nargs="?")
    action("save", "keep the settings through a restart")
    export = action("export", "write all settings to a file")
    export.add_argument("file", metavar="FILE.json")
    export.add_argument("--force", action="store_true", help="overwrite an existing file")
    restore = action("restore", "send what a file has and the camera has not")
    restore.add_argument("file", metavar="FILE.json")
    for added in (change, restore):
        added.add_argument("--save", action="store_true", help="and keep them through a restart")
    action("restart", "restart the camera, for settings that only then count")
    check = action("check", "check a file without a camera", with_port=False)
    check.add_argument("file", metavar="FILE.json")


def run(args: argparse.Namespace) -> int:
    from larics_host.connection import camera_settings as tools
    from larics_host.files import refuse_existing

    # what can be wrong without the camera is told before it is asked
    file: Any = tools.read_file(args.file) if args.action in ("restore", "check") else None
    if args.action == "check":
        print("%s: %s, all allowed" % (args.file, counted(len(file), "setting")))
        for line in tools.doubts(tools.checked(file)):
            print("doubt: " + line)
        return 0
    if args.action == "diff" and args.file:
        file = tools.read_file(args.file)
    changes = tools.parse_changes(args.changes) if args.action == "set" else file
    if args.action == "export":
        refuse_existing(args.file, args.force)
    if args.action == "get":
        _check_names(args.names)
    with tools.connected(args.port, args.baud) as client:
        return _ACTIONS[args.action](args, client, changes)


def _check_names(names):
    from larics.settings import field

    for name in names:
        if field(name) is None:
            raise UserError("there is no setting %s: larics settings show lists them" % name)


def _show(args, client, _):
    from larics.settings import FIELDS
    from larics_host.connection.camera_settings import read_all

    values = read_all(client)
    if args.json:
        print(json.dumps(values, indent=1))
        return 0
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    from larics_host.consoles import Console

    console = Console(width=None if sys.stdout.isatty() else 150)
    is_narrow = console.width < _TABLE_WIDE
    table = Table(box=None, pad_edge=False)
    for heading in ("setting", "value", "unit", "allowed", "meaning"):
        table.add_column(heading, no_wrap=heading == "setting", overflow="fold")
    for field in FIELDS:
        if field.name not in values:
            row, style = [field.name, "-", "", "", ""], "dim"  # older firmware
        else:
            value = values[field.name]
            default = list(field.default) if field.length else field.default
            is_default = (list(value) if field.length else value) == default
            allowed = field.range_text() if field.kind != "table" else "up to %d rows" % field.length
            row = [field.name, json.dumps(value), field.unit, allowed, field.meaning]
            style = "" if is_default else "bold"
        if is_narrow:
            console.print(Text("%s = %s %s" % tuple(row[:3]), style=style))
            more = Text("; ".join(filter(None, row[3:])), style="dim")
            console.print(Padding(more, (0, 0, 0, 4), expand=False))
        else:
            table.add_row(*row, style=style)
    if not is_narrow:
        console.print(table)
    console.print("bold: not the default; -: not in the camera's firmware, which is older", style="dim")
    return 0


def _get(args, client, _):
    for name in args.names:
        print("%s = %s" % (name, json.dumps(client.get(name))))
    return 0


def _set(args, client, changes):
    from larics.settings import field
    from larics.settings.fields import RESTART
    from larics_host.connection.camera_settings import apply, checked, doubts, read_all

    current = read_all(client)
    sent = apply(client, current, changes)
    print("changed: %s" % ", ".join(sent) if sent else "the camera has these values already")
    for line in doubts(checked({**current, **changes})):
        print("doubt: " + line)
    waiting = [name for name in sent if field(name).rebuilds & RESTART]
    if waiting:
        print("in use after a restart: %s" % ", ".join(waiting))
    if args.save:
        client.save()
        print("saved")
    elif sent:
        print("until the next restart; larics settings save keeps them")
    return 0


def _diff(args, client, file):
    from larics.settings import Settings
    from larics_host.connection.camera_settings import differences, read_all

    reference = Settings(file).as_dict()
    found = differences(reference, read_all(client))
    where = args.file or "default"
    for name, expected, value in found:
        print("%s: camera %s, %s %s" % (name, json.dumps(value), where, json.dumps(expected)))
    print("different: %s" % counted(len(found), "setting") if found else "no difference")
    return 1 if found else 0


def _save(args, client, _):
    client.save()
    print("saved")
    return 0


def _export(args, client, _):
    from larics_host.connection.camera_settings import read_all, write_file

    write_file(args.file, read_all(client))
    print("written to %s" % args.file)
    return 0


def _restart(args, client, _):
    client.restart()
    print("restarted")
    return 0


_ACTIONS = {
    "show": _show,
    "get": _get,
    "set": _set,
    "restore": _set,
    "diff": _diff,
    "save": _save,
    "export": _export,
    "restart": _restart,
}
