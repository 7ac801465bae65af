"""Gives the program's modules names that MicroPython has anyway, and joins kernels.

A board holds each module's name, its place and its packages, and for each module a few tables besides. Here
modules lie side by side in one folder, under names from flash.short_names; packages without code of their own
go. Kernels are functions alone and all have different names, so that those that the same parts of the program
load can be one module.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from larics_host.flash import linker, short_names

STARTED = "start"  # by firmware/main.py
_MODULES_OF_BOARDS = {"builtins", "micropython", "main", "boot", "copy"}
_FUNCTIONS = (ast.FunctionDef, ast.Lambda)


@dataclass(frozen=True)
class Flat:
    """texts    {module: text}
    origins  {module: those of the sources that it holds}
    """

    texts: dict[str, str]
    origins: dict[str, list[str]]


def flattened(texts: Mapping[str, str], kernels: Collection[str], keep: Iterable[str]) -> Flat:
    """texts: {module: text} of a whole program, linked; kernels: those of its modules that hold nothing but
    functions; keep: names of modules, or last parts of them, that are loaded from outside."""
    trees = {module: ast.parse(text) for module, text in texts.items()}
    kept = _kept(trees, {*keep, STARTED})
    groups = _groups(trees, {module for module in kernels if module not in kept})
    names = {module: module for module in kept}
    free = _free_names(trees)
    for module, tree in trees.items():
        first = groups.get(module, module)
        if module not in names and (len(tree.body) > bool(ast.get_docstring(tree))):
            if first not in names:
                names[first] = next(free)
            names[module] = names[first]
    flat = Flat({}, {})
    for module, name in names.items():
        text = _with_imports(texts[module], trees[module], names, texts)
        flat.texts[name] = flat.texts.get(name, "") + text
        flat.origins.setdefault(name, []).append(module)
    return flat


def loaded_together(
    texts: Mapping[str, str], kernels: Collection[str], keep: Iterable[str]
) -> dict[str, str]:
    """{module: the first of those that are loaded whenever it is} of all but kernels and what is kept."""
    trees = {module: ast.parse(text) for module, text in texts.items()}
    kept = _kept(trees, {*keep, STARTED})
    return _groups(trees, {module for module in trees if module not in kept and module not in kernels})


def _kept(trees, keep):
    kept = {module for module in trees if module in keep or module.split(".")[-1] in keep}
    for module in list(kept):  # and the packages that they lie in
        parts = module.split(".")
        kept.update(".".join(parts[:count]) for count in range(1, len(parts)))
    return kept & set(trees)


def _free_names(trees: Mapping[str, ast.Module]) -> Iterator[str]:
    """Names for modules: none that the program has for something, nor two that a FAT file system takes for
    the same."""
    taken = {part for module in trees for part in module.split(".")} | _MODULES_OF_BOARDS
    for tree in trees.values():
        for node in ast.walk(tree):
            # fields that hold texts: names of all kinds, and what is looked for by them
            taken.update(value for _, value in ast.iter_fields(node) if isinstance(value, str))
    taken = {name.lower() for name in taken}
    for name in short_names.new_names():
        if name.lower() not in taken:
            taken.add(name.lower())
            yield name


def _groups(trees: Mapping[str, ast.Module], kernels: Collection[str]) -> dict[str, str]:
    """{kernels' module: the first of those that are loaded with it, whatever is loaded}."""
    needs: dict[str, set[str]] = {module: set() for module in trees}
    later: set[str] = set()  # what is loaded when a function is called
    for module, tree in trees.items():
        for node, inside in _imports(tree, False):
            found = {name for name in _imported(node, trees) if name in trees}
            (later if inside else needs[module]).update(found)
    first = set(trees) - later.union(*needs.values())
    at_once = set().union(*[_reached(entry, needs) for entry in first])
    loaded_by: dict[str, set[str]] = {module: set() for module in kernels}
    for entry in first | later - at_once:
        for module in _reached(entry, needs) & set(kernels):
            loaded_by[module].add(entry)
    alike: dict[frozenset[str], str] = {}
    return {module: alike.setdefault(frozenset(loaded_by[module]), module) for module in sorted(kernels)}


def _reached(entry: str, needs: Mapping[str, set[str]]) -> set[str]:
    """What is loaded with a module."""
    reached, waiting = {entry}, [entry]
    while waiting:
        further = needs[waiting.pop()] - reached
        reached |= further
        waiting += further
    return reached


def _imports(top: ast.AST, inside: bool) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """Each import, and whether it is made when a function is called."""
    for node in ast.iter_child_nodes(top):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node, inside
        yield from _imports(node, inside or isinstance(node, _FUNCTIONS))


def _imported(node: ast.Import | ast.ImportFrom, modules: Collection[str]) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    inside = ["%s.%s" % (node.module, alias.name) for alias in node.names]
    return [name if name in modules else str(node.module) for name in inside]


def _with_imports(text, tree, names, modules):
    """The text with the new names where modules are imported or named."""
    edits = []
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            if any(name in modules for name in _imported(node, modules)):
                edits.append((node, "; ".join(_statements(node, names, modules))))
        elif isinstance(node, ast.Constant) and "." in str(node.value) and node.value in names:
            edits.append((node, '"%s"' % names[node.value]))
    return linker.edited(text, edits)


def _statements(node, names, modules):
    """What imports the same by the new names."""
    found = []
    for alias in node.names:
        bound = alias.asname or alias.name
        if isinstance(node, ast.Import):
            if alias.name not in modules:
                found.append("import " + ast.unparse(alias))
            elif "." in alias.name and not alias.asname:
                found.append("import %s as _" % names[alias.name])  # to be loaded
            else:
                found.append("import %s as %s" % (names[alias.name], bound))
            continue
        inside = "%s.%s" % (node.module, alias.name)
        if inside in modules:
            found.append("import %s as %s" % (names[inside], bound))
        else:
            found.append("from %s import %s as %s" % (names[node.module], alias.name, bound))
    return found
