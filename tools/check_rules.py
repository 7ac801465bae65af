"""The rules of the house, checked over the syntax tree: `python tools/check_rules.py`.

- shared/larics uses integers only and imports nothing but itself and what every board has
- the packages of shared/larics import only those that `ARROWS` gives them, so that there is no circle
- firmware and host never import each other
- a module of kernels holds viper functions and nothing else, in the style all executors agree on
- public functions of host are annotated, so that `mypy` has something to check
- the items of the arrays that kernels share are where kernels/layouts.py says
"""

import ast
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SHARED_IMPORTS = {"larics", "larics_vehicle", "array", "struct", "binascii", "micropython", "ulab"}
# package of shared/larics -> the packages it may import beside itself and the ground floor `_cpython`
ARROWS = {
    "_cpython": (),
    "boards": (),
    "arith": (),
    "kernels": (),
    "marker": ("arith",),
    "coded": ("marker", "kernels", "arith"),
    "direct": ("coded", "marker", "kernels", "arith"),
    "blurred": ("direct", "coded", "marker", "kernels", "arith"),
    "detect": ("blurred", "direct", "coded", "marker", "kernels", "arith"),
    "wire": ("arith", "kernels"),
    "locate": ("wire", "marker", "kernels", "arith"),
    "settings": ("locate", "marker", "wire"),
    "device": ("settings", "locate", "wire", "detect", "blurred", "direct", "marker", "kernels", "arith"),
    "larics_vehicle": ("wire", "arith"),
}
HOST_ONLY = "shared/larics/_cpython.py"  # stands in for MicroPython's compiler, never on a board
LAYOUTS = "shared/larics/kernels/layouts.py"
# whose constants are items of kernels' arrays
ARRAY_PACKAGES = ("kernels", "direct", "blurred", "coded", "detect", "device", "locate")
ARGUMENTS_MOST = 12  # of a kernel; what belongs together goes into an array
KERNEL_CALLS = {"int", "ptr8", "ptr16", "ptr32"}


def imported_names(tree):
    """(line, module) of every import, also of import_module("...") and __import__("...")."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            if node.level == 0:
                yield node.lineno, node.module
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in ("import_module", "__import__") and isinstance(node.args[0].value, str):
                yield node.lineno, node.args[0].value


def import_violations(tree, allowed=None, forbidden=()):
    """Imports whose first name is not in `allowed` (None: any) or is in `forbidden`."""
    for line, name in imported_names(tree):
        top = name.split(".")[0]
        if top in forbidden or (allowed is not None and top not in allowed):
            yield line, "must not import %s" % name


def _package(dotted):
    """The package of shared/ that a dotted name lies in: "larics.wire.codec" -> "wire", "larics" -> None."""
    parts = dotted.split(".")
    if parts[0] == "larics_vehicle":
        return parts[0]
    inside = parts[0] == "larics" and len(parts) > 1 and not parts[1].startswith("__")
    return parts[1] if inside else None


def arrow_violations(name, tree):
    """Imports from one package of shared/ into another that the table does not allow."""
    own = _package(name[len("shared/") : -len(".py")].replace("/", "."))
    if own is None:  # larics/__init__.py
        allowed = ()
    elif own not in ARROWS:
        yield 1, "the package %s is not in the table of allowed arrows" % own
        return
    else:
        allowed = (own, "_cpython", *ARROWS[own])
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module == "larics":
            targets = ["larics." + alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            targets = [node.module]
        else:
            continue
        for target in targets:
            package = _package(target)
            if package is not None and package not in allowed:
                yield node.lineno, "%s must not import %s" % (own, target)


def float_violations(tree):
    """Whatever makes a float: literals, true division, float(), math."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, (float, complex)):
            yield node.lineno, "float literal %r" % node.value
        elif isinstance(node, (ast.BinOp, ast.AugAssign)) and isinstance(node.op, ast.Div):
            yield node.lineno, "true division"
        elif isinstance(node, ast.Name) and node.id in ("float", "complex", "math"):
            yield node.lineno, "use of %s" % node.id


def _is_viper(function):
    return [ast.unparse(decorator) for decorator in function.decorator_list] == ["micropython.viper"]


def _is_constant(node):
    """NAME = const(...): folded by the compiler."""
    return (
        isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Call)
        and getattr(node.value.func, "id", "") == "const"
    )


def _kernel_function_violations(function):
    if function.args.defaults or function.args.kwonlyargs or function.args.vararg or function.args.kwarg:
        yield function.lineno, "%s: viper has no defaults, keywords or *args" % function.name
    if len(function.args.args) > ARGUMENTS_MOST:
        count = len(function.args.args)
        yield function.lineno, "%s: %d arguments, at most %d" % (function.name, count, ARGUMENTS_MOST)
    inside_int = set()
    for node in ast.walk(function):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", ast.unparse(node.func))
            if name == "int":
                inside_int.update(id(argument) for argument in node.args)
            elif name not in KERNEL_CALLS and node not in function.decorator_list:
                yield node.lineno, "%s: call of %s" % (function.name, name)
        elif isinstance(node, (ast.For, ast.Try, ast.With, ast.Raise, ast.Slice, ast.FunctionDef)):
            if node is not function:
                yield node.lineno, "%s: %s in a kernel" % (function.name, type(node).__name__)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            yield node.lineno, "%s: unary minus" % function.name
        elif isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Subscript):
            yield node.lineno, "%s: p[i] += is slow and untyped, write p[i] = int(p[i]) +" % function.name
    for node in ast.walk(function):
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load) and id(node) not in inside_int:
            yield node.lineno, "%s: load %s outside int()" % (function.name, ast.unparse(node))


def kernel_violations(tree):
    """What does not belong in a kernels module."""
    for node in tree.body:
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if docstring or isinstance(node, (ast.Import, ast.ImportFrom)) or _is_constant(node):
            continue
        if isinstance(node, ast.Try) and all(isinstance(x, (ast.Import, ast.ImportFrom)) for x in node.body):
            continue
        if isinstance(node, ast.FunctionDef) and _is_viper(node):
            yield from _kernel_function_violations(node)
        else:
            yield node.lineno, "a kernels module holds viper functions and nothing else"


def _lacks_annotations(function):
    """Whether a parameter (the first of a method's apart) or the result has no type."""
    given = function.args.posonlyargs + function.args.args + function.args.kwonlyargs
    given += [extra for extra in (function.args.vararg, function.args.kwarg) if extra]
    untyped = [argument.arg for argument in given if argument.annotation is None]
    return function.returns is None or any(name not in ("self", "cls") for name in untyped)


def annotation_violations(node, inside=""):
    """Public functions and methods of public classes without types; what is inside a function is private."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef) and not child.name.startswith("_"):
            yield from annotation_violations(child, inside + child.name + ".")
        elif isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
            public = child.name == "__init__" or not child.name.startswith("_")
            if public and _lacks_annotations(child):
                yield child.lineno, "%s lacks type annotations" % (inside + child.name)
        elif isinstance(child, (ast.If, ast.Try)):
            yield from annotation_violations(child, inside)


def constants(tree):
    """{name: (line, number)} of a module's NAME = const(expression of numbers)."""
    found = {}
    for node in tree.body:
        if _is_constant(node) and isinstance(node.targets[0], ast.Name):
            try:
                number = eval(compile(ast.Expression(node.value.args[0]), "const", "eval"), {})
            except NameError:
                continue
            found[node.targets[0].id] = node.lineno, number
    return found


def layout_violations(tree, layouts):
    """Copies of the items of shared arrays that differ from their definition; `layouts`: {name: number}."""
    arrays = {name.split("_")[0] for name in layouts if "_" in name}
    for name, (line, number) in constants(tree).items():
        item = name.lstrip("_")
        if item in layouts:
            if number != layouts[item]:
                yield line, "%s is %d, but %d in layouts.py" % (name, number, layouts[item])
        elif "_" in item and item.split("_")[0] in arrays:
            yield line, "%s is no item in layouts.py" % name


def layouts_of(root=ROOT):
    """{name: number} of the items of all arrays that kernels share."""
    path = root / LAYOUTS
    if not path.is_file():
        return {}
    return {name: number for name, (_, number) in constants(ast.parse(path.read_text())).items()}


def check(name, source, firmware_modules=(), layouts=None):
    """The violations of one file as (line, text); `name` is its path from the root, with slashes."""
    tree = ast.parse(source, name)
    if name.startswith("shared/") and name != HOST_ONLY:
        yield from import_violations(tree, allowed=SHARED_IMPORTS)
        yield from arrow_violations(name, tree)
        yield from float_violations(tree)
        if name.split("/")[2] in ARRAY_PACKAGES:
            yield from layout_violations(tree, layouts or {})
        if name.startswith("shared/larics/kernels/") and not name.endswith("__init__.py"):
            yield from kernel_violations(tree)
    elif name.startswith("firmware/"):
        yield from import_violations(tree, forbidden={"larics_host"})
    elif name.startswith("host/"):
        yield from import_violations(tree, forbidden={"firmware", *firmware_modules})
        yield from annotation_violations(tree)


def check_tree(root=ROOT):
    """All violations below `root`, as "path:line: text", and the number of files read."""
    firmware_modules = {path.stem for path in (root / "firmware").glob("*.py")}
    firmware_modules |= {path.parent.name for path in (root / "firmware").glob("*/__init__.py")}
    layouts = layouts_of(root)
    found, count = [], 0
    for folder in ("shared", "firmware", "host"):
        for path in sorted((root / folder).rglob("*.py")):
            name = path.relative_to(root).as_posix()
            count += 1
            for line, text in check(name, path.read_text(), firmware_modules, layouts):
                found.append("%s:%d: %s" % (name, line, text))
    return found, count


if __name__ == "__main__":
    violations, files = check_tree()
    print("\n".join(violations) if violations else "%d files keep the rules" % files)
    sys.exit(1 if violations else 0)
