"""Takes out of the sources what they say to people where a board has no one who reads it.

errors    are raised without their text: their kind and where they come from are told as before
reasons   why a setting is refused: on the wire there is but that it is
units     of settings
"""

from __future__ import annotations

import ast

from larics_host.flash import linker

_REASON = '"no"'  # a reason is a text that is not empty
_UNIT = 7  # which argument of a Field


def silent(text: str) -> str:
    """A module's text without them; every line keeps its number."""
    edits: list[tuple[ast.stmt | ast.expr, str]] = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and len(node.exc.args) == 1:
            if _is_text(node.exc.args[0]):
                edits.append((node.exc.args[0], ""))
        elif isinstance(node, ast.FunctionDef) and _tells_a_reason(node.name):
            returns = [inner for inner in ast.walk(node) if isinstance(inner, ast.Return)]
            edits += [(inner.value, _REASON) for inner in returns if inner.value and _is_text(inner.value)]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Field":
            edits.append((node.args[_UNIT], '""'))
    return linker.edited(text, edits)


def _tells_a_reason(name: str) -> bool:
    return name.endswith("reason") or name in ("conflict", "validate")


def _is_text(node: ast.expr) -> bool:
    """Whether this is a text, or one with values put in."""
    while isinstance(node, ast.BinOp):
        node = node.left
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
