"""Gives the program's own names to names that every MicroPython has in its flash: those take no memory.

A board holds each name of a program once, with its text and its place in a list that doubles when it is full.
A name that two different classes or modules have for different things does as well, so that a few dozen are
enough. Not renamed is what the program does not define itself, what stands in a text (`getattr(x, "name")`,
settings), names of modules, and what hardware or MicroPython may know by that name.

The renaming is one for the whole program, so that `x.name` stays right whatever x is. Two names may become
the same one only if no module, and no class together with its bases, has both.
"""

from __future__ import annotations

import ast
import io
import re
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeGuard

from larics_host.flash import linker

# py/makeqstrdata.py of MicroPython for .mpy version 6: their numbers are part of the format, from 1 on
STATIC = (
    "", "__dir__", "\n", " ", "*", "/", "<module>", "_", "__call__", "__class__", "__delitem__", "__enter__",
    "__exit__", "__getattr__", "__getitem__", "__hash__", "__init__", "__int__", "__iter__", "__len__",
    "__main__", "__module__", "__name__", "__new__", "__next__", "__qualname__", "__repr__", "__setitem__",
    "__str__", "ArithmeticError", "AssertionError", "AttributeError", "BaseException", "EOFError", "Ellipsis",
    "Exception", "GeneratorExit", "ImportError", "IndentationError", "IndexError", "KeyError",
    "KeyboardInterrupt", "LookupError", "MemoryError", "NameError", "NoneType", "NotImplementedError",
    "OSError", "OverflowError", "RuntimeError", "StopIteration", "SyntaxError", "SystemExit", "TypeError",
    "ValueError", "ZeroDivisionError", "abs", "all", "any", "append", "args", "bool", "builtins", "bytearray",
    "bytecode", "bytes", "callable", "chr", "classmethod", "clear", "close", "const", "copy", "count", "dict",
    "dir", "divmod", "end", "endswith", "eval", "exec", "extend", "find", "format", "from_bytes", "get",
    "getattr", "globals", "hasattr", "hash", "id", "index", "insert", "int", "isalpha", "isdigit",
    "isinstance", "islower", "isspace", "issubclass", "isupper", "items", "iter", "join", "key", "keys",
    "len", "list", "little", "locals", "lower", "lstrip", "main", "map", "micropython", "next", "object",
    "open", "ord", "pop", "popitem", "pow", "print", "range", "read", "readinto", "readline", "remove",
    "replace", "repr", "reverse", "rfind", "rindex", "round", "rsplit", "rstrip", "self", "send", "sep",
    "set", "setattr", "setdefault", "sort", "sorted", "split", "start", "startswith", "staticmethod", "step",
    "stop", "str", "strip", "sum", "super", "throw", "to_bytes", "tuple", "type", "update", "upper", "utf-8",
    "value", "values", "write", "zip",
)  # fmt: skip
# static names that MicroPython itself may look for in an object or a module
_LOOKED_FOR = {"args", "close", "main", "micropython", "read", "readinto", "send", "throw", "value", "write"}
# modules of MicroPython whose objects are not handed on; what one that imports others calls may be theirs
_PLAIN = {"gc", "sys", "os", "time", "array", "micropython", "json", "binascii", "io"}
_OF_TYPES = {
    name
    for kind in (int, str, bytes, bytearray, memoryview, list, tuple, dict, set, Exception, array, io.FileIO)
    for name in dir(kind)
}
# modules whose texts name what is on the wire, which nothing looks for in an object
_FOR_PEOPLE = {"larics.wire.messages"}
_CLOCK = {"ticks_us", "ticks_ms", "ticks_diff", "ticks_add", "sleep_ms", "time"}  # `time` is handed on


def chosen(
    texts: Mapping[str, str],
    taken: Iterable[str],
    keep: Iterable[str] = (),
    sources: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """{name: its new name} for a program {module: text}, linked.

    taken: all names that its compiled files have; keep: further names that are to stay; sources: the program
    before its modules were joined, which tells better what is not of the program."""
    taken = set(taken)
    program = _Program(texts, texts if sources is None else sources)
    stays = program.stays | set(keep) | set(STATIC) | set(linker.ROOTS)
    free = (name for name in new_names() if name not in taken)
    targets: list[str] = []
    used: dict[int, set[int]] = {}
    places: dict[str, list[int]] = {name: [] for name in program.loose}
    for index, space in enumerate(program.spaces):
        used[index] = set()
        for name in space:
            places.setdefault(name, []).append(index)
    renamed = {}
    for name in sorted(places, key=lambda n: (-len(places[n]), n)):
        if name in stays or (name.startswith("__") and name.endswith("__")):
            continue
        forbidden = set().union(*[used[index] for index in places[name]])
        number = next(n for n in range(len(forbidden) + 1) if n not in forbidden)
        if number == len(targets):
            targets.append(next(free))
        for index in places[name]:
            used[index].add(number)
        renamed[name] = targets[number]
    return renamed


def file_names(modules: Sequence[str]) -> dict[str, str]:
    """{module: what a traceback says instead of its file's name}, all different."""
    names = [name for name in STATIC if name.strip()]
    names += ["f%d" % index for index in range(len(names), len(modules))]
    return dict(zip(modules, names, strict=False))


def new_names() -> Iterator[str]:
    """Names that MicroPython has, then short ones."""
    for name in STATIC:
        if name.isidentifier() and not name.startswith("__") and name not in _LOOKED_FOR:
            yield name
    for first in "abcdefghijklmnopqrstuvwxyz":
        for second in "0123456789":
            yield first + second


class _Program:
    """stays   names that must not change
    spaces  sets of names that must remain different: of each module, of each class with its bases, and the
            arguments of each function of which some are given by their names
    loose   names of arguments, which nothing looks for
    """

    def __init__(self, texts: Mapping[str, str], sources: Mapping[str, str]) -> None:
        self.stays = _CLOCK | _OF_TYPES
        self.spaces: list[set[str]] = []
        self.loose: set[str] = set()
        self._sources = sources
        self._keywords: set[str] = set()  # by which arguments are given
        self._anywhere: set[str] = set()  # stored in objects of whatever class
        classes: dict[str, list[tuple[set[str], list[str]]]] = {}
        modules = []
        for module, text in sources.items():
            self._read_foreign(ast.parse(text), module in _FOR_PEOPLE)
        for module, text in texts.items():
            self.stays.update(module.split("."))
            tree = ast.parse(text)
            modules.append(self._globals(tree))
            owned: set[ast.AST] = set()
            for node in ast.walk(tree):
                if isinstance(node, ast.ClassDef):
                    names, stores = self._class_names(node)
                    owned |= stores
                    bases = [ast.unparse(base).split(".")[-1] for base in node.bases]
                    classes.setdefault(node.name, []).append((names, bases))
                if isinstance(node, ast.arguments):
                    args = [*node.posonlyargs, *node.args, *node.kwonlyargs, node.vararg, node.kwarg]
                    own = {arg.arg for arg in args if arg is not None}
                    self.loose |= own
                    if own & self._keywords:
                        self.spaces.append(own)
            for node in ast.walk(tree):
                if node not in owned and _is_stored(node):
                    self._anywhere.add(node.attr)
        for found in classes.values():
            for names, bases in found:
                self.spaces.append(names | self._inherited(bases, classes) | self._anywhere)
        self.spaces += [names | self._anywhere for names in modules]

    def _read_foreign(self, tree: ast.Module, for_people: bool) -> None:
        """Notes what a module takes from outside the program, hands on or may look for there."""
        if not for_people:
            self._read_texts(tree)
        foreign = self._foreign(tree)
        attributes = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
        self.stays |= foreign
        self.stays.update(
            node.attr for node in attributes if isinstance(node.value, ast.Name) and node.value.id in foreign
        )
        keywords = {node.arg for node in ast.walk(tree) if isinstance(node, ast.keyword) and node.arg}
        self._keywords |= keywords
        if foreign - _PLAIN - {"const"}:
            # private ones are never of others
            self.stays.update(node.attr for node in attributes if not node.attr.startswith("_"))
            self.stays.update(keywords)

    def _read_texts(self, tree: ast.Module) -> None:
        descriptions = {
            node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)
        }  # docstrings, which are not compiled
        for node in ast.walk(tree):
            text = node.value if isinstance(node, ast.Constant) and node not in descriptions else None
            if isinstance(text, str) and re.fullmatch(r"\w+", text):
                self.stays.add(text)

    def _foreign(self, tree: ast.Module) -> set[str]:
        """Names that a module imports from outside the program."""
        names: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                found = [alias for alias in node.names if alias.name not in self._sources]
            elif isinstance(node, ast.ImportFrom) and node.module not in self._sources:
                found = node.names
                names.add(str(node.module))
            else:
                continue
            names.update(name for alias in found for name in (alias.name, alias.asname) if name)
        return names

    def _globals(self, tree: ast.Module) -> set[str]:
        """Names that a module defines, or that its functions declare to be global."""
        names = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Global):
                names.update(node.names)
        for node in _own_nodes(tree):
            names.update(_bound(node))
        return names

    def _class_names(self, top: ast.ClassDef) -> tuple[set[str], set[ast.AST]]:
        """Names of a class and of what its methods store in their object; and these stores."""
        names: set[str] = set()
        stores: set[ast.AST] = set()
        for node in _own_nodes(top):
            names.update(_bound(node))
            if isinstance(node, ast.FunctionDef) and node.args.args:
                first = node.args.args[0].arg
                for inner in ast.walk(node):
                    if _is_stored(inner) and isinstance(inner.value, ast.Name) and inner.value.id == first:
                        names.add(inner.attr)
                        stores.add(inner)
        return names, stores

    def _inherited(self, bases: Sequence[str], classes: Mapping[str, list]) -> set[str]:
        names: set[str] = set()
        for base in bases:
            for own, further in classes.get(base, ()):
                names |= own | self._inherited(further, classes)
        return names


def _is_stored(node: ast.AST) -> TypeGuard[ast.Attribute]:
    return isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load)


def _own_nodes(top: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a module or a class, without what is inside its functions and classes."""
    for node in ast.iter_child_nodes(top):
        yield node
        if not isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.Lambda)):
            yield from _own_nodes(node)


def _bound(node: ast.AST) -> list[str]:
    """Names that a statement or a part of it defines."""
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return [node.name]
    if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
        return [node.id]
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        return [(alias.asname or alias.name).split(".")[0] for alias in node.names]
    return []
