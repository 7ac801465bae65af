"""Translates the kernels from viper's language to C, whose compilers make far less machine code of it.

The language is that of `larics.kernels`: 32-bit integers, items of ptr8, ptr16 and ptr32 arguments, while and
if. Whatever else there is raises Untranslatable. The C function is called as MicroPython calls its own
machine code: it takes its arguments from objects and makes one of its result through the interpreter's
table of functions.
"""

from __future__ import annotations

import ast

_ITEMS = {"ptr8": "uint8_t", "ptr16": "uint16_t", "ptr32": "int32_t"}
_OPERATORS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.LShift: "<<", ast.RShift: ">>", ast.BitAnd: "&",
    ast.BitOr: "|", ast.BitXor: "^",
}  # fmt: skip
_CALLED = {ast.FloorDiv: "floor_divided", ast.Mod: "floor_rest"}
_COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
_INT_MOST = (1 << 31) - 1

# what of MicroPython's py/nativeglue.h and py/runtime0.h (.mpy version 6.3) is used
PRELUDE = """
#include <stddef.h>
#include <stdint.h>
typedef uintptr_t (*convert_t)(uintptr_t, uintptr_t);
enum { NONE = 0, FROM_OBJECT = 3, TO_OBJECT = 4, INT = 2, POINTER = 4, CONTEXT = 1, OBJECTS = 3 };
"""
# all of a function's code in one section, its entry first; // and % of Python round down
_HELPERS = """
#define IN __attribute__((section(".code%(number)d.rest")))
IN static inline int32_t floor_rest%(number)d(int32_t a, int32_t b) {
    int32_t rest = a %% b;
    return rest && (rest ^ b) < 0 ? rest + b : rest;
}
IN static inline int32_t floor_divided%(number)d(int32_t a, int32_t b) {
    return a / b - (a %% b && (a ^ b) < 0);
}
"""
_ENTRY = """
__attribute__((section(".code%(number)d.entry"), used))
uintptr_t entry%(number)d(const uintptr_t *function, size_t count, size_t named, const uintptr_t *objects) {
    const uintptr_t *context = (const uintptr_t *)function[CONTEXT];
    const uintptr_t *table = (const uintptr_t *)((const uintptr_t *)context[OBJECTS])[%(table)d];
    uintptr_t given[%(count)d];
    for (int i = 0; i < %(count)d; i++)
        given[i] = ((convert_t)table[FROM_OBJECT])(objects[i], %(pointers)d >> i & 1 ? POINTER : INT);
    (void)count, (void)named;
    %(call)s
}
#undef IN
"""


class Untranslatable(ValueError):
    """A function is not in the kernels' language."""


def kernels(text: str) -> list[ast.FunctionDef]:
    """The viper functions of a module, first to last. Untranslatable when others are among them."""
    found = [node for node in ast.parse(text).body if isinstance(node, (ast.FunctionDef, ast.ClassDef))]
    functions = [node for node in found if isinstance(node, ast.FunctionDef)]
    if len(functions) < len(found) or any(
        [ast.unparse(d) for d in f.decorator_list] != ["micropython.viper"] for f in functions
    ):
        raise Untranslatable("not all of the module's functions are viper functions")
    return functions


def translate(function: ast.FunctionDef, table: int, number: int) -> str:
    """C text, to follow PRELUDE, with the code of a function in the sections ".code<number>.entry" and
    ".code<number>.rest"; `table`: which of its module's objects is the interpreter's table."""
    return _Translation(function, number).text(table)


def _declared(kind: str, name: str = "") -> str:
    """C's type of an argument or a variable, and its name."""
    if kind == "int":
        return "int32_t" + (" v_" + name if name else "")
    return _ITEMS[kind] + " *" + ("v_" + name if name else "")


class _Translation:
    def __init__(self, function: ast.FunctionDef, number: int) -> None:
        self.function = function
        self.number = number
        self.types: dict[str, str] = {}
        for argument in function.args.args:
            kind = ast.unparse(argument.annotation) if argument.annotation else ""
            if kind != "int" and kind not in _ITEMS:
                raise self._refusal(argument)
            self.types[argument.arg] = kind
        if len(self.types) > 32 or ast.unparse(function.args).count("=") or function.args.vararg:
            raise self._refusal(function)
        self.arguments = list(self.types)
        self.types.update((name, "int") for name in self._stored() if name not in self.types)
        for node in ast.walk(function):  # a name for another pointer
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name):
                kind = self.types.get(node.value.id, "")
                if kind in _ITEMS and isinstance(node.targets[0], ast.Name):
                    self.types[node.targets[0].id] = kind

    def _stored(self) -> list[str]:
        names = [node for node in ast.walk(self.function) if isinstance(node, ast.Name)]
        return sorted({node.id for node in names if isinstance(node.ctx, ast.Store)})

    def text(self, table: int) -> str:
        returns = self.function.returns is not None
        kind_of_result = "int32_t" if returns else "void"
        given, pointers = [], 0
        for index, name in enumerate(self.arguments):
            kind = self.types[name]
            pointers |= (kind != "int") << index
            given.append("%s = (%s)given[%d];" % (_declared(kind, name), _declared(kind), index))
        lines = ["IN static inline %s body%d(const uintptr_t *given) {" % (kind_of_result, self.number)]
        lines += given
        lines += [_declared(kind, n) + ";" for n, kind in self.types.items() if n not in self.arguments]
        lines += self._block(self.function.body[bool(ast.get_docstring(self.function)) :])
        lines.append("return 0;" * returns + "}")
        call = "body%d(given);\n    return table[NONE];" % self.number
        if returns:
            call = "return ((convert_t)table[TO_OBJECT])((uintptr_t)(intptr_t)body%d(given), INT);"
            call %= self.number
        told = {"table": table, "count": len(self.arguments), "pointers": pointers, "call": call}
        told["number"] = self.number
        return "\n".join([_HELPERS % told, *lines, _ENTRY % told])

    def _block(self, statements: list[ast.stmt]) -> list[str]:
        return [line for statement in statements for line in self._statement(statement)]

    def _statement(self, node: ast.stmt) -> list[str]:
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = node.targets[0], node.value
            if isinstance(target, ast.Name) and self.types[target.id] in _ITEMS:
                if isinstance(value, ast.Name) and self.types.get(value.id) == self.types[target.id]:
                    return ["v_%s = v_%s;" % (target.id, value.id)]
                raise self._refusal(node)
            return ["%s = %s;" % (self._place(target), self._number(value))]
        if isinstance(node, ast.AugAssign):
            right = self._operation(node.op, self._place(node.target), self._number(node.value), node)
            return ["%s = %s;" % (self._place(node.target), right)]
        if isinstance(node, (ast.While, ast.If)):
            word = "while" if isinstance(node, ast.While) else "if"
            lines = ["%s (%s) {" % (word, self._test(node.test)), *self._block(node.body), "}"]
            if node.orelse:
                if word == "while":
                    raise self._refusal(node)
                lines += ["else {", *self._block(node.orelse), "}"]
            return lines
        if isinstance(node, ast.Return):
            number = "" if node.value is None else " " + self._number(node.value)
            if bool(number) != (self.function.returns is not None):
                raise self._refusal(node)
            return ["return%s;" % number]
        if isinstance(node, (ast.Continue, ast.Break)):
            return ["continue;" if isinstance(node, ast.Continue) else "break;"]
        if isinstance(node, ast.Pass):
            return []
        raise self._refusal(node)

    def _place(self, node: ast.expr) -> str:
        """What a value is written to."""
        if isinstance(node, ast.Subscript):
            return self._item(node)
        if isinstance(node, ast.Name) and self.types.get(node.id, "int") == "int":
            return "v_" + node.id
        raise self._refusal(node)

    def _item(self, node: ast.Subscript) -> str:
        if not isinstance(node.value, ast.Name) or self.types.get(node.value.id) not in _ITEMS:
            raise self._refusal(node)
        return "v_%s[%s]" % (node.value.id, self._number(node.slice))

    def _test(self, node: ast.expr) -> str:
        """A condition, of which only counts whether it holds."""
        if isinstance(node, ast.BoolOp):
            both = " && " if isinstance(node.op, ast.And) else " || "
            return "(%s)" % both.join(self._test(value) for value in node.values)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return "!" + self._test(node.operand)
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            sign = _COMPARISONS.get(type(node.ops[0]))
            if sign is None:
                raise self._refusal(node)
            return "(%s %s %s)" % (self._number(node.left), sign, self._number(node.comparators[0]))
        return self._number(node)

    def _number(self, node: ast.expr) -> str:
        if isinstance(node, ast.Constant) and type(node.value) is int and node.value <= _INT_MOST:
            return str(node.value)
        if isinstance(node, ast.Name) and self.types.get(node.id) == "int":
            return "v_" + node.id
        if isinstance(node, ast.Subscript):
            return self._item(node)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "int" and len(node.args) == 1:
            return self._number(node.args[0])
        if isinstance(node, ast.BinOp):
            return self._operation(node.op, self._number(node.left), self._number(node.right), node)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return "(-%s)" % self._number(node.operand)
        if isinstance(node, ast.IfExp):
            parts = self._test(node.test), self._number(node.body), self._number(node.orelse)
            return "(%s ? %s : %s)" % parts
        raise self._refusal(node)

    def _operation(self, operator: ast.operator, left: str, right: str, node: ast.AST) -> str:
        if type(operator) in _OPERATORS:
            return "(%s %s %s)" % (left, _OPERATORS[type(operator)], right)
        if type(operator) in _CALLED:
            return "%s%d(%s, %s)" % (_CALLED[type(operator)], self.number, left, right)
        raise self._refusal(node)

    def _refusal(self, node: ast.AST) -> Untranslatable:
        return Untranslatable(
            "line %d of %s: %s" % (getattr(node, "lineno", 0), self.function.name, ast.unparse(node))
        )
