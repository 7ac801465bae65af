"""What a module of the program defines, imports and shadows, for joining it with others."""

from __future__ import annotations

import ast
from collections.abc import Collection

Thing = tuple[str, ...]  # (module, name) of what a module defines; (module,) of the module itself
FUNCTIONS = (ast.FunctionDef, ast.Lambda)
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
_DEFINING = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.ClassDef, ast.Assign, ast.Pass)


class Source:
    """One module of the program.

    body    its statements but for imports at its top
    bound   {name: what it stands for} at its top
    outside [what imports from outside the program]
    needs   modules that it imports at its top
    alone   modules, itself or others, that cannot be joined: they do something when they are loaded, set
            their names anew later, or are used as an object
    locals  names of arguments and variables in its functions
    """

    def __init__(self, name: str, text: str, modules: Collection[str]) -> None:
        self.name = name
        self.body: list[ast.stmt] = []
        self.bound: dict[str, Thing] = {}
        self.outside: list[ast.stmt] = []
        self.needs: list[str] = []
        self.alone: set[str] = set()
        self._modules = modules
        tree = ast.parse(text)
        for node in _statements(tree.body):
            self._read(node)
        self.locals = set()
        for node in ast.walk(tree):
            if isinstance(node, (*FUNCTIONS, *COMPREHENSIONS)):
                self.locals |= local_names(node)
            elif isinstance(node, ast.Global):
                self.alone.add(name)
        self._find_objects()

    def thing(self, module: str | None, name: str) -> Thing:
        """What `from module import name` gives."""
        inside = "%s.%s" % (module, name)
        return (inside,) if inside in self._modules else (str(module), name)

    def _read(self, node):
        if not isinstance(node, _DEFINING):
            self.alone.add(self.name)
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name not in self._modules:
                    self._take_outside(node, alias.asname or alias.name.split(".")[0], alias.name)
                    continue
                self.needs.append(alias.name)
                if not alias.asname and "." in alias.name:
                    self.alone.update((self.name, alias.name))  # to be loaded
                self.bound[alias.asname or alias.name] = (alias.name,)
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                thing = self.thing(node.module, alias.name)
                if thing[0] in self._modules:
                    self.needs.append(thing[0])
                    self.bound[alias.asname or alias.name] = thing
                else:
                    self._take_outside(node, alias.asname or alias.name, *thing)
        elif not (isinstance(node, ast.Pass) or _is_text(node)):
            self.body.append(node)
            for name in bound_at_once(node):
                self.bound[name] = (self.name, name)

    def _take_outside(self, node, name, *thing):
        self.bound[name] = ("", *thing)
        self.outside.append(node)

    def _find_objects(self):
        """Modules that are used other than for something in them, or are loaded by a function as such."""
        waiting: list[tuple[ast.AST, frozenset[str]]] = [(node, frozenset()) for node in self.body]
        while waiting:
            node, shadowed = waiting.pop()
            if isinstance(node, (*FUNCTIONS, *COMPREHENSIONS)):
                shadowed |= local_names(node)
            if isinstance(node, ast.Name) and node.id not in shadowed:
                thing = self.bound.get(node.id, ())
                if len(thing) == 1:
                    self.alone.add(thing[0])
            elif isinstance(node, ast.Import):
                self.alone.update(
                    alias.name if alias.asname else alias.name.split(".")[0] for alias in node.names
                )
            elif isinstance(node, ast.ImportFrom):
                things = [self.thing(node.module, alias.name) for alias in node.names]
                self.alone.update(thing[0] for thing in things if len(thing) == 1)
            if isinstance(node, ast.Attribute) and _is_read(node) and isinstance(node.value, ast.Name):
                continue
            waiting.extend((child, shadowed) for child in ast.iter_child_nodes(node))


def local_names(top: ast.AST) -> set[str]:
    """Names that a function, a lambda or a comprehension binds for itself."""
    found: set[str] = set()
    shared: set[str] = set()
    if isinstance(top, FUNCTIONS):
        args = top.args
        every = [*args.posonlyargs, *args.args, *args.kwonlyargs, args.vararg, args.kwarg]
        found = {arg.arg for arg in every if arg is not None}
    waiting: list[ast.AST] = list(top.body) if isinstance(top, ast.FunctionDef) else []
    if not waiting:
        waiting.extend(ast.iter_child_nodes(top))
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Global):
            shared.update(node.names)
        elif isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            found.add(node.id)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found.update((alias.asname or alias.name).split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ExceptHandler) and node.name:
            found.add(node.name)
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif not isinstance(node, (ast.Lambda, *COMPREHENSIONS)):
            waiting.extend(ast.iter_child_nodes(node))
    return found - shared


def _statements(body):
    """Statements at the top, those of `if 1:` among them."""
    for node in body:
        if isinstance(node, ast.If) and isinstance(node.test, ast.Constant) and node.test.value:
            yield from _statements(node.body)
        elif not _is_text(node):
            yield node


def _is_text(node):
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_read(node):
    return isinstance(node.ctx, ast.Load)


def bound_at_once(node: ast.AST) -> list[str]:
    """Names that a statement binds where it stands."""
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return [node.name]
    return [
        inner.id
        for inner in ast.walk(node)
        if isinstance(inner, ast.Name) and not isinstance(inner.ctx, ast.Load)
    ]
