"""Tracebacks of a small-heap build, and the names that translate them.

A build's names are a JSON object {"lines": whether its tracebacks have lines, "files": {what stands for a
file: {"file": its path, "names": {a name there: attributes and functions of the sources that it may stand
for}, "classes": the same of classes, "functions": [[first line, last line, name, name there], ...]}}}, with
the path behind each function's names where a file stands for several, kept in the user's configuration folder
under the program's hash.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from larics_host.errors import UserError
from larics_host.user_folder import user_folder

_PLACE = re.compile(r'File "([^"]*)", line (\d+)(?:, in (\S+))?')
_ERROR = re.compile(r"\w+(Error|Exception)\b")
_OF_CLASS = re.compile(r"(')(\w+)(' object)")
_ATTRIBUTE = re.compile(r"(attribute ')(\w+)(')")


def described(name: str, text: str, renamed: Mapping[str, str]) -> dict[str, Any]:
    """What is kept of one file: its name on the board, its source text, {name: its new name}."""
    tree = ast.parse(text)
    names: dict[str, list[str]] = {}
    classes: dict[str, list[str]] = {}
    functions = [_function(node, "", renamed) for node in tree.body if isinstance(node, ast.FunctionDef)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            _note(names, node.attr, renamed)
        elif isinstance(node, ast.FunctionDef):
            _note(names, node.name, renamed)
        elif isinstance(node, ast.ClassDef):
            _note(classes, node.name, renamed)
            methods = [child for child in node.body if isinstance(child, ast.FunctionDef)]
            functions += [_function(child, node.name + ".", renamed) for child in methods]
    return {
        "file": name.removesuffix(".mpy") + ".py",
        "names": names,
        "classes": classes,
        "functions": sorted(functions),
    }


def together(files: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What is kept of several, as `described`, that a board holds as one without lines; each function's file
    is told with it."""
    names: dict[str, list[str]] = {}
    classes: dict[str, list[str]] = {}
    for file in files:
        for all_of_them, its_own in ((names, file["names"]), (classes, file["classes"])):
            for short, meant in its_own.items():
                known = all_of_them.setdefault(short, [])
                known += [name for name in meant if name not in known]
    functions = [[*function, file["file"]] for file in files for function in file["functions"]]
    return {"file": files[0]["file"], "names": names, "classes": classes, "functions": functions}


def _note(found, name, renamed):
    if name in renamed and name not in found.setdefault(renamed[name], []):
        found[renamed[name]].append(name)


def _function(node, prefix, renamed):
    return [node.lineno, node.end_lineno, prefix + node.name, renamed.get(node.name, node.name)]


def translate(text: str, names: Mapping[str, Any]) -> str:
    """What a board said, with the names of the sources in its tracebacks. A name that stands for several is
    given as "one|other"."""
    classes: dict[str, list[str]] = {}
    for file in names["files"].values():
        for short, meant in file["classes"].items():
            classes.setdefault(short, []).extend(meant)
    lines, last = [], None
    for line in text.splitlines(keepends=True):
        place = _PLACE.search(line)
        if place is not None and place[1] in names["files"]:
            last = names["files"][place[1]]
            line = line.replace(place[0], _place(place, last, names["lines"]))
        elif last is not None and _ERROR.match(line):  # of the innermost place
            line = _OF_CLASS.sub(_meanings(classes), line)
            line = _ATTRIBUTE.sub(_meanings(last["names"]), line)
        lines.append(line)
    return "".join(lines)


def _meanings(known):
    return lambda found: found[1] + "|".join(known.get(found[2], [found[2]])) + found[3]


def _place(place, known, has_lines):
    number, function = int(place[2]), place[3]
    meant = [f for f in known["functions"] if f[3] == function and (not has_lines or f[0] <= number <= f[1])]
    files = dict.fromkeys([f[4] for f in meant if len(f) > 4]) or [known["file"]]
    text = 'File "%s"' % "|".join(files)
    if has_lines:
        text += ", line %d" % number
    if function:
        text += ", in " + ("|".join(f[2] for f in meant) or function)
    return text


def _folder() -> Path:
    return user_folder() / "programs"


def save(program_hash: str, names: Mapping[str, Any]) -> Path:
    """Keeps a build's names; returns the file. OSError when it cannot be written."""
    _folder().mkdir(parents=True, exist_ok=True)
    path = _folder() / (program_hash + ".json")
    path.write_text(json.dumps(names))
    return path


def load(path: Path | None = None) -> dict[str, Any]:
    """A build's names; of the one that was put on a board last, without a path. Raises UserError."""
    if path is None:
        found = sorted(_folder().glob("*.json"), key=lambda file: file.stat().st_mtime)
        if not found:
            raise UserError("no small-heap build was made here: name its file with --names")
        path = found[-1]
    try:
        names = json.loads(path.read_text())
        if not isinstance(names["files"], dict) or not isinstance(names["lines"], bool):
            raise ValueError
    except OSError as error:
        raise UserError("%s: %s" % (path, error.strerror)) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UserError("%s does not hold the names of a build" % path) from error
    return names
