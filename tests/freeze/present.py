"""What the tables of this folder freeze, as the program has it now: rows of texts."""

import argparse
import dataclasses
import hashlib
import importlib
import inspect
import json
import re
import struct
from pathlib import Path

import larics_host
from larics.detect.detector import Detector
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.marker import CELL_CDEG, CODE_ANGLES_CDEG, CODED, GROUPS_CDEG, LARICS3
from larics.settings import FIELDS
from larics.wire import codec
from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder
from larics_host import cli, wire_names
from larics_host.connection.receiver import message_of
from larics_host.fleet.findings import examine
from larics_host.fleet.report import tables as tables_of
from larics_host.fleet.tally import NO_DATE, Tally
from larics_host.logs.log_writer import MARKER_COLUMNS, json_line
from larics_host.mapping import mapfile
from larics_host.truth import COLUMNS as TRUTH_COLUMNS
from larics_vehicle.approach import Approach
from larics_vehicle.odometer import Odometer

ROOT = Path(__file__).resolve().parents[2]
_DIRECTIVE = re.compile(r"^\.\. auto(class|function|module):: (\S+)((?:\n   :.*)*)", re.MULTILINE)
_PROTOCOLS = (
    "__enter__",
    "__exit__",
    "__aenter__",
    "__aexit__",
    "__iter__",
    "__next__",
    "__aiter__",
    "__anext__",
)


def messages():
    for name, number, meaning, fields in m.MESSAGES:
        empty = dict.fromkeys(("byte", "field", "code", "unit", "least", "most"), "")
        yield {"type": str(number), "message": name, **empty, "meaning": meaning}
        place = 0
        for field, code, unit, least, most, text in fields:
            numbers = {"least": str(least), "most": str(most)}
            told = {
                "byte": str(place),
                "field": field,
                "code": code,
                "unit": unit,
                **numbers,
                "meaning": text,
            }
            yield {"type": str(number), "message": name, **told}
            place += struct.calcsize("<" + code)


def codes():
    for group, entries in wire_names.ENUMS:
        for name, value, meaning in entries:
            assert getattr(codec, name) == value
            yield {"group": group, "value": str(value), "name": name, "meaning": meaning}


def settings():
    for field in FIELDS:
        allowed = "%d..%d" % (field.low, field.high)
        if field.kind == "choice":
            allowed = json.dumps(field.choices)
        elif field.kind == "table":
            allowed = " ".join("%s %d..%d" % column for column in field.columns)
            allowed += "; the first %d at least" % field.needed
        yield {
            "key": str(field.key),
            "name": field.name,
            "kind": field.kind,
            "default": json.dumps(field.default),
            "allowed": allowed,
            "most": str(field.length or ""),
            "unit": field.unit,
            "meaning": field.meaning,
        }


def _takes(action):
    if action.nargs == 0:
        return "nothing"
    if isinstance(action, argparse._AppendAction):
        return "a value, may be repeated"
    return {None: "a value", "?": "a value or nothing", "+": "values", "*": "values or nothing"}.get(
        action.nargs, "%s values" % action.nargs
    )


def _options(command, parser):
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield from _options("%s %s" % (command, name), inner)
            continue
        default = action.default
        kept = not isinstance(default, bool | list | None) and default != argparse.SUPPRESS
        yield {
            "command": command,
            "option": " ".join(action.option_strings) or action.metavar or action.dest,
            "takes": _takes(action),
            "choices": " ".join(map(str, action.choices or ())),
            "default": str(default) if kept else "",
        }


def commands():
    return [row for row in _options("larics", cli.build_parser()) if row["option"] != "-h --help"]


def _signature(function):
    """Names, order and defaults of the arguments, without `self` and types."""
    parameters = []
    for parameter in list(inspect.signature(function).parameters.values()):
        if parameter.name != "self":
            default = parameter.default
            if default is not parameter.empty and not isinstance(default, int | float | str | tuple | None):
                parameter = parameter.replace(default="...")  # an object; its address would tell nothing
            parameters.append(parameter.replace(annotation=parameter.empty))
    return str(inspect.Signature(parameters)).replace("'...'", "...")


def _fields_of(thing):
    """(name, type) of what an instance holds, where its class says so."""
    if dataclasses.is_dataclass(thing):
        return [(field.name, str(field.type).replace(" | ", " or ")) for field in dataclasses.fields(thing)]
    return [(name, "") for name in (getattr(thing, "_fields", None) or getattr(thing, "__slots__", ()))]


def _members(name, thing, chosen):
    """(name, what, told) of a class or function; `chosen`: those methods and properties alone, None: all."""
    if not inspect.isclass(thing):
        yield name, "function", _signature(thing)
        return
    if issubclass(thing, Exception):
        yield name, "exception", ""
        return
    yield name, "class", _signature(thing)
    for field, kind in _fields_of(thing):
        if field[0] != "_":
            yield "%s.%s" % (name, field), "field", kind
    for member, value in vars(thing).items():
        if chosen is not None and member not in chosen or member[0] == "_" and member not in _PROTOCOLS:
            continue
        if inspect.isfunction(value):
            yield "%s.%s" % (name, member), "method", _signature(value)
        elif isinstance(value, property):
            yield "%s.%s" % (name, member), "attribute", ""  # whichever way it is made


def _names(text, option):
    """The names of `:option: a, b` in a directive, None without it or without names."""
    found = re.search(r":%s: *(\S.*)" % option, text)
    return found and [name.strip() for name in found.group(1).split(",")]


def _documented():
    """(module, name, object, chosen members) of what docs/python.md shows."""
    for kind, target, options in _DIRECTIVE.findall((ROOT / "docs" / "python.md").read_text()):
        chosen = _names(options, "members")
        if kind != "module":
            module_name, _, name = target.rpartition(".")
            yield module_name, name, getattr(importlib.import_module(module_name), name), chosen
            continue
        module = importlib.import_module(target)
        hidden = _names(options, "exclude-members") or ()
        for name, thing in vars(module).items():
            own = getattr(thing, "__module__", "") == target and callable(thing)
            if name in (chosen or (name,)) and own and name[0] != "_" and name not in hidden:
                yield target, name, thing, None


def api():
    for module_name, name, thing, chosen in _documented():
        for member, what, told in _members(name, thing, chosen):
            yield {"module": module_name, "name": member, "what": what, "told": told}
    for name in larics_host.__all__:
        yield {"module": "larics_host", "name": name, "what": "name", "told": ""}
    made = Detector(320, 240), Localizer(MarkerMap(())), Encoder(), Decoder(print), Approach(), Odometer()
    for thing in made:
        kind = type(thing)
        told = re.findall(r"\w+", inspect.getdoc(kind))  # what the docstring does not name is not promised
        for name in vars(thing):
            if name[0] != "_" and name in told:
                row = {"module": kind.__module__, "name": "%s.%s" % (kind.__name__, name)}
                yield {**row, "what": "attribute", "told": ""}


def markers():
    """What hangs on ceilings: measures at an outer radius of 150 mm, angles, and the code."""
    for name in ("coded", "plain"):
        family = {"coded": CODED, "plain": LARICS3}[name]
        for measure in family.__slots__:
            yield {"family": name, "what": measure, "value": str(getattr(family, measure))}
        yield {"family": name, "what": "IDs", "value": str(len(list(family.ids())))}
    yield {"family": "plain", "what": "angles of the lines, 0.01 deg", "value": str(CODE_ANGLES_CDEG)}
    groups = "%s + 3 x %d" % (GROUPS_CDEG, CELL_CDEG)
    yield {"family": "coded", "what": "groups of cells, 0.01 deg", "value": groups}
    lines = {number: LARICS3.bits(number) for number in LARICS3.ids()}
    yield {"family": "plain", "what": "lines of each ID", "value": str(lines)}
    words = b"".join(struct.pack("<HI", number, CODED.cells(number)) for number in sorted(CODED.ids()))
    for number in (9, 1261, 4094):
        yield {"family": "coded", "what": "cells of %d" % number, "value": "0x%06x" % CODED.cells(number)}
    yield {"family": "coded", "what": "SHA-256 of IDs and cells", "value": hashlib.sha256(words).hexdigest()}


def columns():
    """Of files that other programs read."""
    marker = message_of(m.MARKER, 0, [0] * len(codec.fields(m.MARKER)), 0.0)
    tally = Tally()
    tally.readings[1, NO_DATE] = [1, 200, 40000, 7680]
    fleet = examine({"vehicle": tally}, {"vehicle": 1})
    files = {
        "log .csv": ("time_s", "sequence", *MARKER_COLUMNS),
        "log .jsonl, MARKER": json.loads(json_line(marker, 0)),
        "truth.csv": TRUTH_COLUMNS,
        "map .json and survey .csv": mapfile._FIELDS,
        **{"fleet " + name: columns for name, (columns, _) in tables_of(fleet).items()},
    }
    for file, names in files.items():
        for place, name in enumerate(names):
            yield {"file": file, "place": str(place), "column": name}


_LIBRARY = ROOT / "firmware" / "vehicle" / "src"
_STRUCT = re.compile(r"typedef struct \{((?:[^{}]|\{[^{}]*\})*)\} (\w+);(?! /\* private)", re.DOTALL)
_DEFINED = re.compile(r"^#define (LARICS_\w+) (\S+)", re.MULTILINE)
_FUNCTION = re.compile(r"^(\w[\w ]*?[ *]+)(larics_\w+)\(([^;{}]*)\);", re.MULTILINE)


def _without_comments(text):
    return " ".join(re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL).split())


def vehicle():
    """What the headers of the C library declare and do not call private: numbers, members, functions."""
    for path in sorted(_LIBRARY.glob("*.h")):
        text = path.read_text()
        if "private to the library" in text.partition("#")[0]:
            continue
        for name, value in _DEFINED.findall(text):
            yield {"header": path.name, "name": name, "what": "number", "told": value}
        for body, name in _STRUCT.findall(text):
            marked = _without_comments(body.replace("/* private from here on", "@ /*"))
            public = re.sub(r"[^;]*; @.*", "", re.sub(r"\{[^{}]*\}", "{...}", marked))
            members = public.split("; ")
            for place, member in enumerate(members):
                what = "member %d" % place
                yield {"header": path.name, "name": name, "what": what, "told": member.rstrip(";")}
        for returned, name, arguments in _FUNCTION.findall(_STRUCT.sub("", text)):
            told = "%s(%s)" % (returned.strip(), _without_comments(arguments))
            yield {"header": path.name, "name": name, "what": "function", "told": told}
