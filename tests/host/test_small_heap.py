"""The program for boards with little memory: on a real interpreter it does what the usual one does."""

import ast
import re
import subprocess

import pytest

from larics.settings.fields import FIELDS
from larics_host import cli
from larics_host.flash import (
    build,
    flat_modules,
    joined_modules,
    machine_code,
    mpy_file,
    short_names,
    silent,
    small_heap,
    tracebacks,
    viper_to_c,
)
from tests.host.firmware_process import environment
from tests.host.test_dual import ROOT, unix_port
from tests.host.test_linker import frames, own_architecture, reported  # noqa: F401  (frames: a fixture)

CALLED = ("replay_main", "pc", "main")  # from outside the program
HEAP = "440k"  # of the tests' interpreter, whose objects are twice as large as a board's

FAULTY = {
    "shared/larics/__init__.py": "",
    "shared/larics/wheel.py": """
class Wheel:
    def __init__(self, radius):
        self.diameter = 2 * radius

    def turn(self, parts):
        return self.diameter // parts
""",
    "shared/larics/part.py": """
from larics.wheel import Wheel


class Axle(Wheel):
    def carry(self):
        return self.turn(0)


def missing(axle):
    return axle.colour
""",
    "firmware/start.py": """
import sys

from larics.part import Axle, missing


def main():
    axle = Axle(3)
    for call in (axle.carry, lambda: missing(axle)):
        try:
            call()
        except Exception as error:
            sys.print_exception(error)
""",
}

KERNEL = """
import micropython


@micropython.viper
def divided(out: ptr32, bytes_in: ptr8, words_in: ptr16, a: int, b: int) -> int:
    i = 0
    other = out
    other[0] = a // b
    other[1] = a % b
    while i < 3:
        if i == 1 or (a < 0 and b > 0 and not i):
            out[2 + i] = int(words_in[i]) << 3
            i += 1
            continue
        out[2 + i] = (int(bytes_in[i]) ^ 0x155) | (a >> 2)
        i += 1
    words_in[0] = a
    return a // b - (1 if a > b else 0 - 1)


@micropython.viper
def nothing(out: ptr32):
    out[0] = 7
"""
CALLS = """
from array import array
import larics.kernels.sample as sample
for a, b in ((7, 2), (-7, 2), (7, -2), (-7, -2), (-6, 3), (0, 5), (-1, 1000), (1 << 29, 3), (-(1 << 29), 7)):
    out, data, words = array("i", [0] * 8), bytearray((3, 200, 255)), array("H", (1, 65535, 9))
    print(sample.divided(out, data, words, a, b), list(out), list(words))
print(sample.nothing(out), out[0])
"""


IMPORTS = {
    "start": """
import sys, shop
import shop.tools as t
from shop import shelf, size
from shop.tools import cut as saw, KEPT


def main():
    import shop.late

    print(shop.size, t.cut(2), shelf.top(), size, saw(3), KEPT, "shop.late" in sys.modules)
""",
    "shop": "size = 7\n",
    "shop.tools": "KEPT = 'a.b'\ndef cut(n):\n    return n * 2\n",
    "shop.shelf": """
from shop.deep.kernel import twice


def top():
    from shop.other import thrice

    return twice(4) + thrice(1)
""",
    "shop.deep": "'''nothing but this'''\n",
    "shop.deep.kernel": "def twice(n):\n    return 2 * n\n",
    "shop.deep.more": "def four_times(n):\n    return 4 * n\n",
    "shop.other": "from shop.deep import more\ndef thrice(n):\n    return more.four_times(n) - n\n",
    "shop.late": "from shop.deep.more import four_times\nfrom shop.deep.kernel import twice\n",
}


# of which only tools, shelf and counter can be one module
TOGETHER = {
    "start": """
import shop
from shop.tools import cut
from shop.shelf import Shelf, listed
from shop import counter, till


def main():
    from shop.late import SIZE, paid

    print(shop.size, cut(2), Shelf(3).top(2), listed(3), counter.cut(5), counter.total([1, 2]), till.opened())
    print(paid(till), SIZE)
""",
    "shop": "size = 7\n",
    "shop.acting": """
from shop.tools import cut
from shop.shelf import size

seen = [cut(size)]
seen.append(1)
""",
    "shop.tools": "from array import array\nsize = 2\ndef cut(n):\n    return n * size + len(array('b'))\n",
    "shop.shelf": """
from array import array as row
from shop import tools
from shop.tools import cut as saw

size = 9


class Shelf:
    size = 4
    twice = size * 2

    def __init__(self, cut, size=size):
        self.cut = cut
        self.size = size + len(row("b"))

    def top(self, saw):
        return self.cut, saw, self.size, Shelf.twice, tools.cut(saw), tools.size


def listed(size):
    tools = [saw(size) for size in range(size)]
    return tools, sorted(tools, key=lambda cut: -cut), {cut: size for cut in tools}
""",
    "shop.counter": """
from shop.tools import cut as saw


def cut(tools):
    return saw(tools) + 1


def total(cut):
    def size():
        return sum(cut)

    return size(), sum([saw(n) for n in cut])
""",
    "shop.till": """
from shop import acting
from shop.counter import cut

kept = 0


def opened():
    global kept
    kept += cut(1)
    return kept, acting.seen
""",
    "shop.late": "from shop import size as SIZE\ndef paid(till):\n    return till.opened()\n",
}


def put(files, folder):
    for name, data in files:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())


def run(search, code):
    program = [*unix_port(), "-c", code]
    result = subprocess.run(program, cwd=ROOT, env=environment(search), capture_output=True, text=True)
    return result.stdout + result.stderr


@pytest.fixture(scope="module")
def small():
    """The whole program, for the tests' interpreter."""
    return small_heap.compile_small(ROOT, own_architecture(), False, build.PC_ONLY, CALLED)


@pytest.fixture(scope="module")
def usual():
    return build.compile_program(ROOT, own_architecture(), build.PC_ONLY)


@pytest.fixture
def faulty(tmp_path):
    root = tmp_path / "faulty"
    put(FAULTY.items(), root)
    return root


def test_it_does_in_less_memory_what_the_sources_do(small, usual, frames, tmp_path):  # noqa: F811
    assert small.lacks == ""
    put(small.files, tmp_path / "small")
    put(usual, tmp_path / "usual")
    script = tmp_path / "start_here.py"
    script.write_text("import sys\nfrom pc import replay_main\nreplay_main.main(sys.argv[1:])\n")
    expected = reported("shared:firmware:.frozen", "firmware/pc/replay_main.py", frames)
    assert len({marker["frame"] for marker in expected}) == 2 and any(m["id"] < 5000 for m in expected)
    assert reported("%s:.frozen" % (tmp_path / "small"), str(script), frames, HEAP) == expected
    with pytest.raises(AssertionError, match="MemoryError"):
        reported("%s:.frozen" % (tmp_path / "usual"), str(script), frames, HEAP)


def test_what_must_differ_in_a_module_or_a_class_still_does():
    texts = {build.module_of(name): path.read_text() for path, name in build.program(ROOT)}
    renamed = short_names.chosen(texts, re.findall(r"\w+", " ".join(texts.values())))
    assert len(renamed) > 1000 and len(set(renamed.values())) < 90
    checked = 0
    for text in texts.values():
        tree = ast.parse(text)
        for top in [tree, *[node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]]:
            own = {node.name for node in top.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
            if isinstance(top, ast.ClassDef):
                stored = [n for n in ast.walk(top) if isinstance(n, ast.Attribute)]
                own |= {n.attr for n in stored if isinstance(n.ctx, ast.Store)}
            after = [renamed.get(name, name) for name in own]
            assert len(set(after)) == len(own)
            checked += len(own)
    assert checked > 1000
    for name in ("radius_min_px", "threshold", "mem_free", "ticks_us", "main", "exposure", "detect"):
        assert name not in renamed, "a setting, MicroPython, a camera or a module knows it"
    texts = {
        "larics.wire.messages": 'MESSAGES = (("POSE", "turn_cdeg"),)\n',
        "other": 'class A:\n    turn_cdeg = lean_cdeg = 1\n\nLOOKED_FOR = "lean_cdeg"\n',
    }
    renamed = short_names.chosen(texts, ("turn_cdeg", "lean_cdeg"))
    assert "turn_cdeg" in renamed and "lean_cdeg" not in renamed, "people are told what is on the wire"


def test_modules_with_short_names_are_found_however_they_are_imported(tmp_path):
    kernels = ["shop.deep.kernel", "shop.deep.more"]
    flat = flat_modules.flattened(IMPORTS, kernels, ())
    assert "start" in flat.texts and not [name for name in flat.texts if "." in name or "shop" in name]
    assert sorted(sum(flat.origins.values(), [])) == sorted(set(IMPORTS) - {"shop.deep"})
    put([(name + ".py", text) for name, text in flat.texts.items()], tmp_path)
    assert run("%s:.frozen" % tmp_path, "import start\nstart.main()") == "7 4 11 7 6 a.b True\n"
    # one of them is loaded at the start, the other one only when it is needed
    assert [kernels[0]] in flat.origins.values() and [kernels[1]] in flat.origins.values()
    sources = dict(IMPORTS, start=IMPORTS["start"] + "from shop import other\n")
    together = flat_modules.flattened(sources, kernels, ["late"])
    assert kernels in together.origins.values()
    assert {"shop", "shop.late"} <= set(together.texts), "what is loaded from outside, in its package"


def test_joined_modules_do_what_they_did_apart(tmp_path):
    def told_by(texts, folder, of_module="%s/__init__.py"):
        put([(of_module % name.replace(".", "/"), text) for name, text in texts.items()], tmp_path / folder)
        return run("%s:.frozen" % (tmp_path / folder), "import start\nstart.main()")

    expected = told_by(TOGETHER, "apart")
    assert expected.startswith("7 4 (3, 2, 4, 8, 4, 2) ([0, 2, 4], [4, 2, 0], ")
    assert expected.endswith(" 11 (3, 6) (3, [18, 1])\n(6, [18, 1]) 7\n")
    made = joined_modules.joined(TOGETHER, flat_modules.loaded_together(TOGETHER, (), ()), ())
    alone = {"start", "shop", "shop.acting", "shop.till", "shop.late"}
    assert {name for name, parts in made.parts.items() if len(parts) == 1} == alone
    assert ["shop.counter", "shop.shelf", "shop.tools"] in [sorted(parts) for parts in made.parts.values()]
    assert told_by(made.texts, "joined") == expected
    assert told_by(flat_modules.flattened(made.texts, (), ()).texts, "flat", "%s.py") == expected


def test_a_joined_module_has_no_more_names_than_cost_nothing(monkeypatch):
    groups = flat_modules.loaded_together(TOGETHER, (), ())
    monkeypatch.setattr(joined_modules, "_MOST_NAMES", 8)
    held = {frozenset(parts) for parts in joined_modules.joined(TOGETHER, groups, ()).parts.values()}
    assert {frozenset(["shop.tools", "shop.shelf"]), frozenset(["shop.counter"])} < held


def test_modules_get_names_that_nothing_else_has():
    texts = {name: text + "def keys(self):\n    return self.format\n" for name, text in IMPORTS.items()}
    flat = flat_modules.flattened(texts, (), ())
    lower = [name.lower() for name in flat.texts]
    assert len(set(lower)) == len(lower) == len(texts)
    assert not {"keys", "format", "self", "copy", "micropython", "n", "main", "shop"} & set(flat.texts)


def test_the_program_is_in_few_modules_and_loads_no_more_than_it_needs(small, usual):
    assert len(small.files) < len(usual) - 20
    assert [name for name, _ in small.files if "larics" in name] == []
    kernels = [names for names in small.holds.values() if names[0].startswith("larics/kernels/")]
    direct = next(names for names in kernels if "larics/kernels/votes.mpy" in names)
    second = next(names for names in kernels if "larics/kernels/blur.mpy" in names)
    assert len(direct) > 8 and len(second) > 4
    assert ["larics/kernels/raw.mpy"] in kernels and ["larics/kernels/paper.mpy"] in kernels


def test_what_people_read_is_left_out_and_is_refused_as_before():
    text = (
        'def line_reason(a):\n    if a > 1:\n        return "%d is more" % a + "than 1"\n    return None\n'
        'def told(a):\n    if a:\n        raise ValueError("no %s" % a)\n    raise KeyError(a)\n'
        'def kind():\n    return "more"\n'
    )
    there = {}
    exec(silent.silent(text), there)
    assert (there["line_reason"](2), there["line_reason"](0), there["kind"]()) == ("no", None, "more")
    with pytest.raises(ValueError) as raised:
        there["told"](1)
    assert raised.value.args == ()
    with pytest.raises(KeyError) as raised:
        there["told"](0)
    assert raised.value.args == (0,)
    quiet = {}
    path = ROOT / "shared/larics/settings/fields.py"
    exec(silent.silent(path.read_text()), quiet)
    compared = 0
    for entry, other in zip(FIELDS, quiet["FIELDS"], strict=True):
        assert entry.reason(entry.full(entry.default)) is other.reason(entry.full(entry.default)) is None
        for value in (-(10**9), None, "none", [[1]], [10**9] * 100):
            reason = entry.reason(value)
            assert (reason is None) == (other.reason(value) is None)
            compared += reason is not None and other.reason(value) == "no"
    assert compared > 200


def test_a_traceback_is_translated_into_that_of_the_usual_program(faulty, tmp_path):
    march = own_architecture()
    made = small_heap.compile_small(faulty, march, True)
    put(made.files, tmp_path / "small")
    put(build.compile_program(faulty, march), tmp_path / "usual")
    code = "import start\nstart.main()"
    said = run("%s:.frozen" % (tmp_path / "small"), code)
    usual = run("%s:.frozen" % (tmp_path / "usual"), code)
    assert "part.py" in usual and "part.py" not in said and "wheel.py" in usual and "Wheel" not in said
    expected = usual.replace("in turn", "in Wheel.turn").replace("in carry", "in Axle.carry")
    assert tracebacks.translate(said, made.names) == expected
    assert "'Axle' object has no attribute 'colour'" in expected


def test_without_lines_it_tells_the_functions(faulty, tmp_path, monkeypatch, capsys):
    made = small_heap.compile_small(faulty, own_architecture(), False)
    put(made.files, tmp_path / "small")
    said = run("%s:.frozen" % (tmp_path / "small"), "import start\nstart.main()")
    (tmp_path / "said.txt").write_text(said)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert cli.main(["traceback", str(tmp_path / "said.txt")]) == 2
    assert "no small-heap build was made here" in capsys.readouterr().err
    assert cli.main(["traceback", str(tmp_path / "none")]) == 2  # what was named is missing, too: that first
    assert "cannot read %s" % (tmp_path / "none") in capsys.readouterr().err
    kept = tracebacks.save("0123", made.names)
    assert cli.main(["traceback", str(tmp_path / "said.txt")]) == 0
    told = capsys.readouterr().out
    (tmp_path / "said.txt").write_bytes(said.replace("\n", "\r\n").encode())
    assert 'File "larics/part.py", in Axle.carry\n' in told and "in Wheel.turn|missing\n" in told
    assert 'File "larics/wheel.py|larics/part.py", in Wheel.turn|missing\n' in told
    assert cli.main(["traceback", str(tmp_path / "said.txt"), "--names", str(kept)]) == 0
    assert capsys.readouterr().out == told
    for names, part in (("{}", "does not hold the names"), ("{", "does not hold the names")):
        kept.write_text(names)
        assert cli.main(["traceback", str(tmp_path / "said.txt")]) == 2
        assert part in capsys.readouterr().err
    assert cli.main(["traceback", str(tmp_path / "none"), "--names", str(tmp_path / "no")]) == 2


def test_machine_code_from_c_counts_as_viper_does(tmp_path):
    root = tmp_path / "root"
    put([("shared/larics/kernels/sample.py", KERNEL), ("shared/larics/kernels/__init__.py", "")], root)
    put([("shared/larics/__init__.py", ""), ("firmware/start.py", "CALLED = 'divided', 'nothing'\n")], root)
    made = small_heap.compile_small(root, own_architecture(), True, keep=("sample",))
    usual = build.compile_program(root, own_architecture())
    put(made.files, tmp_path / "small")
    put(usual, tmp_path / "usual")
    code = "import start\n" + CALLS
    said = run("%s:.frozen" % (tmp_path / "small"), code)
    assert said == run("%s:.frozen" % (tmp_path / "usual"), code) and said.endswith("None 7\n")
    sizes = [
        len(mpy_file.MpyFile(dict(files)["larics/kernels/sample.mpy"]).code.children[0].data)
        for files in (made.files, usual)
    ]
    assert sizes[0] < sizes[1] // 2


@pytest.mark.parametrize(
    "line",
    [
        "a = [1]",
        "a = b.c",
        "for i in a:\n        pass",
        "a = f(b)",
        "a = 1099511627776",
        "return p",
        "a = p",
        "a = b @ b",
    ],
)
def test_what_is_no_kernel_is_refused(line):
    text = "@micropython.viper\ndef f(b: int, p: ptr8) -> int:\n    a = 1\n    %s\n    return a\n" % line
    (function,) = viper_to_c.kernels(text)
    with pytest.raises(viper_to_c.Untranslatable):
        viper_to_c.translate(function, 0, 0)


def test_a_module_with_other_functions_is_refused():
    with pytest.raises(viper_to_c.Untranslatable):
        viper_to_c.kernels("def f():\n    pass\n")


def test_without_a_compiler_the_kernels_stay_as_they_are(faulty, monkeypatch):
    with pytest.raises(machine_code.NoCompiler, match="xtensawin"):
        machine_code.compiler("xtensawin")
    monkeypatch.setenv("PATH", "")
    assert small_heap.compile_small(faulty, "armv7emsp", True).lacks == "arm-none-eabi-gcc is not installed"
    broken = faulty / "arm-none-eabi-gcc"
    broken.write_text("#!/bin/sh\necho cannot find crt0.o; exit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", str(faulty))
    lacks = small_heap.compile_small(faulty, "armv7emsp", True).lacks
    assert lacks == "arm-none-eabi-gcc fails: cannot find crt0.o"


def test_compiled_files_are_written_as_they_were_read(usual):
    for name, data in usual:
        assert mpy_file.MpyFile(data).result() == data, name
    with pytest.raises(ValueError):
        mpy_file.MpyFile(data + b"\0")
