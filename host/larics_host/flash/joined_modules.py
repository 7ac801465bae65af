"""Joins modules of the program that are loaded together into one.

Each module costs a board the tables of its own names, of what it imports and of the constants of its code; in
a joined one each of these is there once, and what one module takes from another is simply there. Lines are
not kept, so it is for programs whose tracebacks have none. Names that two modules have for different things
are changed; what is called from outside must be in modules that are kept apart.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from larics_host.flash.module_names import Source, Thing, bound_at_once, local_names

# of one joined module: with more, a board has to hold further names to tell them apart
_MOST_NAMES = 75


@dataclass(frozen=True)
class Joined:
    """texts    {module: text}; a joined one has the name of one of its modules
    parts    {module: {module of the sources that it holds: its part of the text}}
    """

    texts: dict[str, str]
    parts: dict[str, dict[str, str]]


def joined(texts: Mapping[str, str], groups: Mapping[str, str], apart: Collection[str]) -> Joined:
    """texts: {module: text} of a whole program, linked; groups: {module: one that is loaded whenever it is};
    apart: modules that are left as they are, which import none of the others."""
    sources = {name: Source(name, text, texts) for name, text in texts.items() if name not in apart}
    group = dict.fromkeys(texts, "") | _grouped(sources, groups)
    group = {name: place or name for name, place in group.items()}
    ordered: dict[str, list[Source]] = {}
    for name in _imported_first(sources):
        ordered.setdefault(group[name], []).append(sources[name])
    names = _Names(sources, group)
    for members in ordered.values():
        names.choose(members)
    made = Joined({name: texts[name] for name in apart}, {name: {name: texts[name]} for name in apart})
    for name, members in ordered.items():
        made.parts[name] = {source.name: _part(source, names) for source in members}
        made.texts[name] = _imports(members, names) + "".join(made.parts[name].values())
    return made


def _grouped(sources, groups):
    """{module: the one whose name its joined module gets}. No joined module imports itself through one that
    stays alone: those that do import such a one are joined apart from the others."""
    alone = {name for source in sources.values() for name in source.alone}
    alone.update(name for name in sources if name not in groups)
    reached: dict[str, set[str]] = {}
    for name in _imported_first(sources):
        needs = [other for other in sources[name].needs if other in sources]
        reached[name] = set(needs).union(*[reached[other] for other in needs])
    between = {name for name in alone if name in reached and not reached[name] <= alone}
    group: dict[str, str] = {}
    current: dict[tuple[str, frozenset[str]], tuple[str, set[Thing]]] = {}
    for name, found in reached.items():
        group[name] = name
        if name in alone:
            continue
        kind = groups[name], frozenset(found & between)
        first, things = current.get(kind, (name, set()))
        more = set(sources[name].bound.values())
        if len(things | more) > _MOST_NAMES:
            first, things = name, set()
        current[kind] = first, things | more
        group[name] = first
    return group


def _imported_first(sources):
    """The modules' names, each behind those that it imports."""
    found: dict[str, None] = {}

    def take(name):
        waiting.add(name)
        for other in sources[name].needs:
            if other in sources and other not in waiting:
                take(other)
        found[name] = None

    waiting: set[str] = set()
    for name in sorted(sources):
        if name not in waiting:
            take(name)
    return list(found)


class _Names:
    """What everything is called in its joined module."""

    def __init__(self, sources: Mapping[str, Source], group: Mapping[str, str]) -> None:
        self._sources = sources
        self.group = group
        self._names: dict[str, dict[Thing, str]] = {}  # of each joined module

    def resolved(self, thing: Thing) -> Thing:
        """The same, where it is defined rather than where it is imported."""
        while len(thing) == 2 and thing[0] in self._sources:
            where = self._sources[thing[0]].bound.get(thing[1], thing)
            if where == thing:
                break
            thing = where
        return thing

    def choose(self, members: Iterable[Source]) -> None:
        members = list(members)
        place = self.group[members[0].name]
        chosen = self._names[place] = {}
        taken = set(dir(builtins)) if len(members) > 1 else set()
        wanted: dict[Thing, list[str]] = {}
        for source in members:
            for name, thing in source.bound.items():
                wanted.setdefault(self.resolved(thing), []).append(name)
        shadowed = set().union(*[source.locals for source in members])
        for thing, names in wanted.items():
            if len(thing) == 1 and self.group[thing[0]] == place:
                continue  # this module itself
            for name in _variants(names[0]):
                # what is a variable somewhere may be used there by another name or through its module
                if name not in taken and (len(members) == 1 or name not in shadowed):
                    break
            chosen[thing] = name
            taken.add(name)

    def of(self, thing: Thing, place: str) -> str:
        return self._names[place][self.resolved(thing)]

    def own(self, thing: Thing) -> tuple[str, str]:
        """(joined module, name there) of what a module defines or imports from outside."""
        place = self.group[thing[0]]
        return place, self._names.get(place, {}).get(self.resolved(thing), thing[-1])


def _variants(name: str) -> Iterator[str]:
    yield name
    for number in range(2, 1000):
        yield "%s_%d" % (name, number)


def _imports(members, names):
    """The imports of a joined module."""
    place = names.group[members[0].name]
    outside = []
    for source in members:
        for node in source.outside:
            for alias in node.names:
                bound = alias.asname or alias.name.split(".")[0]
                outside.append(_outside(node, alias, names.of(source.bound[bound], place)))
    lines = list(dict.fromkeys(outside))
    needed = {names.resolved(thing): None for source in members for thing in source.bound.values()}
    for thing in needed:
        if thing[0] == "" or names.group[thing[0]] == place:
            continue
        if len(thing) == 1:
            lines.append("import %s as %s" % (names.group[thing[0]], names.of(thing, place)))
        else:
            lines.append("from %s import %s as %s" % (*names.own(thing), names.of(thing, place)))
    return "".join(line + "\n" for line in lines)


def _outside(node, alias, name):
    text = alias.name if alias.name.split(".")[0] == name else "%s as %s" % (alias.name, name)
    return "import " + text if isinstance(node, ast.Import) else "from %s import %s" % (node.module, text)


def _part(source, names):
    writer = _Writer(source, names)
    body = [writer.visit(node) for node in source.body]
    return ast.unparse(ast.fix_missing_locations(ast.Module(body, []))) + "\n"


class _Writer(ast.NodeTransformer):
    """Puts the new names into a module."""

    def __init__(self, source: Source, names: _Names) -> None:
        self._source = source
        self._names = names
        self._place = names.group[source.name]
        self._scopes: list[set[str]] = []

    def _is_own(self, name: str) -> bool:
        return name in self._source.bound and not any(name in scope for scope in self._scopes)

    def _new(self, name: str) -> str:
        return self._names.of(self._source.bound[name], self._place) if self._is_own(name) else name

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return ast.Name(self._new(node.id), node.ctx)

    def visit_Global(self, node: ast.Global) -> ast.AST:
        return ast.Global([self._new(name) for name in node.names])

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if isinstance(node.value, ast.Name) and self._is_own(node.value.id):
            thing = self._source.bound[node.value.id]
            if len(thing) == 1:
                found = self._names.resolved(self._source.thing(thing[0], node.attr))
                if self._names.group[thing[0]] == self._place:
                    return ast.Name(self._names.of(found, self._place), node.ctx)
                if len(found) == 2 and found[0] in self._names.group:
                    name = self._names.own((thing[0], node.attr))[1]
                    return ast.Attribute(self.visit(node.value), name, node.ctx)
        return self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str) and "." in node.value and node.value in self._names.group:
            return ast.Constant(self._names.group[node.value])
        return node

    def visit_Import(self, node: ast.Import) -> ast.AST:
        """Of a function: what is to be loaded."""
        for alias in node.names:
            alias.name = self._names.group.get(alias.name, alias.name)
        return node

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST:
        found = [self._source.thing(node.module, alias.name) for alias in node.names]
        if found[0][0] not in self._names.group or len(found[0]) == 1:
            return node
        pairs = [self._names.own(thing) for thing in found]
        aliases = [
            ast.alias(name, alias.asname or alias.name)
            for (_, name), alias in zip(pairs, node.names, strict=True)
        ]
        return ast.ImportFrom(pairs[0][0], aliases, 0)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.decorator_list = [self.visit(one) for one in node.decorator_list]
        node.args.defaults = [self.visit(one) for one in node.args.defaults]
        if not self._scopes:
            node.name = self._new(node.name)
        self._scopes.append(local_names(node))
        node.body = [self.visit(one) for one in node.body]
        self._scopes.pop()
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        node.args.defaults = [self.visit(one) for one in node.args.defaults]
        self._scopes.append(local_names(node))
        node.body = self.visit(node.body)
        self._scopes.pop()
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        node.bases = [self.visit(one) for one in node.bases]
        node.name = self._new(node.name)
        own = {name for child in node.body for name in bound_at_once(child)}
        for index, child in enumerate(node.body):
            # names of the class are those of its statements, not of its functions
            self._scopes.append(own)
            if isinstance(child, ast.FunctionDef):
                child.decorator_list = [self.visit(one) for one in child.decorator_list]
                child.args.defaults = [self.visit(one) for one in child.args.defaults]
                self._scopes[-1] = local_names(child)
                child.body = [self.visit(one) for one in child.body]
            else:
                node.body[index] = self.visit(child)
            self._scopes.pop()
        return node

    def _visit_comprehension(self, node: ast.AST) -> ast.AST:
        self._scopes.append(local_names(node))
        self.generic_visit(node)
        self._scopes.pop()
        return node

    visit_ListComp = visit_SetComp = visit_DictComp = visit_GeneratorExp = _visit_comprehension
