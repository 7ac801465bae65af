"""Takes out of the program what a board need not hold in memory, before it is compiled.

    constants   numbers that have a name are written where they are used, across modules, and the names go
    functions   that nothing calls go
    imports     of what is gone go, and with them whole modules that were read for a constant alone
    meanings    texts in the tables of messages and settings that only people read become empty

Nothing is moved: every line keeps its number, so that a board's traceback names the line of the sources.
A name is taken for used when anything of the program has it as a name, as an attribute or as a text, so that
`getattr(x, "name")` finds it. What is called from outside must be among ROOTS.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping

ROOTS = ("main",)  # what firmware/main.py calls
_OPERATIONS = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.FloorDiv: lambda a, b: a // b,
    ast.LShift: lambda a, b: a << b,
    ast.RShift: lambda a, b: a >> b,
    ast.BitOr: lambda a, b: a | b,
    ast.BitAnd: lambda a, b: a & b,
}
_DEFINITIONS = (ast.FunctionDef, ast.ClassDef)
_SCOPES = (ast.FunctionDef, ast.Lambda)
_FOR_PEOPLE = ("larics.wire.messages", "larics.settings.fields")


class _Module:
    """One source file: its tree, the constants it defines or imports, and the edits to its text."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.text = text
        self.tree = ast.parse(text)
        self.mentioned = {node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)}
        self.modules: dict[str, str] = {}  # local name -> module of the program
        self.imported: dict[str, tuple[str, str]] = {}  # local name -> (module, name there)
        self.defined: dict[str, ast.expr] = {}  # name -> expression, where it may be a constant
        self.constants: dict[str, int] = {}
        self.edits: list[tuple[ast.stmt | ast.expr, str]] = []

    def result(self) -> str:
        return edited(self.text, self.edits)


def edited(text: str, edits: Iterable[tuple[ast.stmt | ast.expr, str]]) -> str:
    """A text with other texts in the place of nodes, every line with its number; edits inside another one are
    dropped with it."""
    lines = text.encode().splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    data = bytearray(text.encode())
    spans = []
    for node, replaced in edits:
        assert node.end_lineno is not None and node.end_col_offset is not None
        first = min([node.lineno, *[d.lineno for d in getattr(node, "decorator_list", ())]])
        start = starts[first - 1] + node.col_offset  # a decorator stands as far right as its function
        spans.append((start, starts[node.end_lineno - 1] + node.end_col_offset, replaced))
    outer: list[tuple[int, int, str]] = []
    for span in sorted(spans, key=lambda s: (s[0], -s[1])):
        if not outer or span[0] >= outer[-1][1]:
            outer.append(span)
    for first, end, replaced in reversed(outer):
        kept = data[first:end].count(b"\n")
        data[first:end] = replaced.encode() + b"\n" * kept
    return data.decode()


def link(sources: Mapping[str, str], numbers: Mapping[tuple[str, str], int] | None = None) -> dict[str, str]:
    """{module name: text} of a whole program, packages as "larics.wire", with less in it.

    numbers: {(module, name): value} of constants that have another value in this build."""
    modules = {name: _Module(name, text) for name, text in sources.items()}
    for module in modules.values():
        _without_fallbacks(module)
        _read_imports(module, modules)
        _read_definitions(module)
    for (where, name), value in (numbers or {}).items():
        if where in modules and name in modules[where].defined:
            modules[where].constants[name] = value
    _evaluate(modules)
    used = _Uses(modules)
    for module in modules.values():
        _edit(module, used)
        if module.name in _FOR_PEOPLE:
            _empty_meanings(module)
    return {name: module.result() for name, module in modules.items()}


def _is_fallback(node: ast.AST) -> bool:
    """Whether this is `try: ... except ImportError: from larics._cpython import ...`, and what goes along."""
    if not isinstance(node, ast.Try) or len(node.handlers) != 1 or node.orelse or node.finalbody:
        return False
    body = node.handlers[0].body
    return any(isinstance(s, ast.ImportFrom) and s.module == "larics._cpython" for s in body)


def _without_fallbacks(module: _Module) -> None:
    """A board is always MicroPython: what CPython needs instead goes, and what it alone looks at."""
    text = module.text.splitlines(keepends=True)
    for node in module.tree.body:
        if isinstance(node, ast.Try) and _is_fallback(node):
            text[node.lineno - 1] = "if 1:\n"
            for line in range(node.handlers[0].lineno - 1, node.end_lineno or node.lineno):
                text[line] = "\n"
    module.text = edited("".join(text), _slots(ast.parse("".join(text))))
    module.tree = ast.parse(module.text)


def _slots(tree: ast.Module) -> list[tuple[ast.stmt | ast.expr, str]]:
    return [
        (node, "pass")
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__slots__"
    ]


def _read_imports(module: _Module, modules: Mapping[str, _Module]) -> None:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name in modules and (alias.asname or "." not in alias.name):
                    module.modules[alias.asname or alias.name] = alias.name
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                inside = "%s.%s" % (node.module, alias.name)
                if inside in modules:
                    module.modules[alias.asname or alias.name] = inside
                elif node.module is not None and node.module in modules and alias.name != "*":
                    module.imported[alias.asname or alias.name] = (node.module, alias.name)


def _read_definitions(module: _Module) -> None:
    """Names that are set once, at the top of the module, and nowhere else in it."""
    stores: dict[str, int] = {}
    for node in ast.walk(module.tree):
        name = None
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            name = node.id
        elif isinstance(node, ast.arg):
            name = node.arg
        elif isinstance(node, _DEFINITIONS):
            name = node.name
        if name is not None:
            stores[name] = stores.get(name, 0) + 1
    for node in module.tree.body:
        if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            if stores[name] == 1:
                module.defined[name] = node.value
    for name in stores:
        module.modules.pop(name, None)
        module.imported.pop(name, None)


def _evaluate(modules: Mapping[str, _Module]) -> None:
    """Finds the numbers, until no further one is found: they rest on each other."""
    changed = True
    while changed:
        changed = False
        for module in modules.values():
            for name, expression in module.defined.items():
                if name not in module.constants:
                    value = _number(expression, module, modules)
                    if value is not None:
                        module.constants[name] = value
                        changed = True
            for name, (where, there) in module.imported.items():
                if name not in module.constants and there in modules[where].constants:
                    module.constants[name] = modules[where].constants[there]
                    changed = True


def _number(node: ast.expr, module: _Module, modules: Mapping[str, _Module]) -> int | None:
    if isinstance(node, ast.Constant):
        return node.value if type(node.value) is int else None
    if isinstance(node, ast.Name):
        return module.constants.get(node.id)
    if isinstance(node, ast.Attribute):
        if isinstance(node.value, ast.Name) and node.value.id in module.modules:
            return modules[module.modules[node.value.id]].constants.get(node.attr)
        return None
    if isinstance(node, ast.Call):
        is_const = isinstance(node.func, ast.Name) and node.func.id == "const" and len(node.args) == 1
        return _number(node.args[0], module, modules) if is_const else None
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = _number(node.operand, module, modules)
        return None if value is None else -value
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        left, right = _number(node.left, module, modules), _number(node.right, module, modules)
        if left is not None and right is not None:
            return _OPERATIONS[type(node.op)](left, right)
    return None


class _Uses:
    """What of the program is reached from its modules' own statements and ROOTS, by name.

    names   that the reached code has as a name, an attribute or a text, numbers taken out
    dead    definitions that nothing reaches
    """

    def __init__(self, modules: Mapping[str, _Module]) -> None:
        self.modules = modules
        self.names = set(ROOTS)
        self.dead: set[ast.AST] = set()
        self._local: dict[str, set[str]] = {name: set() for name in modules}  # loaded in each module
        waiting: list[tuple[_Module, ast.AST]] = []
        for module in modules.values():
            waiting.extend(self._visit(module, module.tree))
        while True:
            reached = [pair for pair in waiting if self._is_wanted(pair[1])]
            if not reached:
                break
            waiting = [pair for pair in waiting if not self._is_wanted(pair[1])]
            for module, node in reached:
                waiting.extend(self._visit(module, node))
        self.dead = {node for _, node in waiting}
        self.exported = {
            (node.module, alias.name)
            for module in modules.values()
            for node in ast.walk(module.tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
            if (alias.asname or alias.name) in self._local[module.name]
        }

    def _is_wanted(self, node: ast.AST) -> bool:
        assert isinstance(node, _DEFINITIONS)
        return node.name in self.names or (node.name.startswith("__") and node.name.endswith("__"))

    def _visit(self, module: _Module, top: ast.AST) -> list[tuple[_Module, ast.AST]]:
        """Notes the names of this code; returns the definitions in it, which may be wanted or not."""
        found: list[tuple[_Module, ast.AST]] = []
        inside_function = isinstance(top, ast.FunctionDef)
        nodes = list(ast.iter_child_nodes(top))
        while nodes:
            node = nodes.pop()
            if isinstance(node, _DEFINITIONS) and not inside_function:
                found.append((module, node))
                nodes.extend(node.decorator_list)
                continue
            if constant_of(node, module, self.modules) is not None:
                continue
            if isinstance(node, ast.Name):
                if isinstance(node.ctx, ast.Load):
                    self._use(module, node.id)
            elif isinstance(node, ast.Attribute):
                self.names.add(node.attr)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                self.names.add(node.value)
            nodes.extend(ast.iter_child_nodes(node))
        return found

    def _use(self, module: _Module, name: str) -> None:
        self.names.add(name)
        self._local[module.name].add(name)
        if name in module.imported:
            self.names.add(module.imported[name][1])

    def keeps_import(self, module: _Module, node: ast.Import | ast.ImportFrom, alias: ast.alias) -> bool:
        """Whether an imported name is needed in its module, or by those that import it from there. What is
        not of the program stays: that it is missing may be what an import is to tell."""
        name = (alias.asname or alias.name).split(".")[0]
        where = alias.name if isinstance(node, ast.Import) else str(node.module)
        if where not in self.modules and where != "micropython":
            return True
        if isinstance(node, ast.Import) and name not in module.mentioned:
            return True  # imported to be loaded
        return name in self._local[module.name] or (module.name, name) in self.exported


def constant_of(node: ast.AST, module: _Module, modules: Mapping[str, _Module]) -> int | None:
    """The number that a name or an attribute of a module stands for."""
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        return module.constants.get(node.id)
    if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
        return _number(node, module, modules)
    return None


def _edit(module: _Module, used: _Uses) -> None:
    for node in _alive(module.tree, used):
        if isinstance(node, _DEFINITIONS) and node in used.dead:
            module.edits.append((node, "pass"))
            continue
        value = constant_of(node, module, used.modules)
        if value is not None and isinstance(node, ast.expr):
            module.edits.append((node, "(%d)" % value if value < 0 else "%d" % value))
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            _edit_import(node, module, used)
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            if node in module.tree.body and name in module.constants and name not in used.names:
                module.edits.append((node, "pass"))


def _alive(top: ast.AST, used: _Uses) -> Iterator[ast.AST]:
    for node in ast.iter_child_nodes(top):
        yield node
        if node not in used.dead:
            yield from _alive(node, used)


def _edit_import(node: ast.Import | ast.ImportFrom, module: _Module, used: _Uses) -> None:
    if isinstance(node, ast.ImportFrom) and node.names[0].name == "*":
        module.edits.append((node, "pass"))  # constants alone
        return
    kept = [alias for alias in node.names if used.keeps_import(module, node, alias)]
    if len(kept) == len(node.names):
        return
    names = ", ".join(a.name + (" as " + a.asname if a.asname else "") for a in kept)
    if not kept:
        module.edits.append((node, "pass"))
    elif isinstance(node, ast.Import):
        module.edits.append((node, "import " + names))
    else:
        module.edits.append((node, "from %s import %s" % (node.module, names)))


def _empty_meanings(module: _Module) -> None:
    for node in ast.walk(module.tree):
        text = None
        if isinstance(node, ast.Tuple):
            place = {4: 2, 6: 5}.get(len(node.elts))  # a message's and a field's meaning
            if place is not None and isinstance(node.elts[0], ast.Constant):
                text = node.elts[place]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Field":
            text = node.args[8]
        if isinstance(text, ast.Constant) and isinstance(text.value, str):
            module.edits.append((text, '""'))
