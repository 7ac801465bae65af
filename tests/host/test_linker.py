"""What is taken out of a board's program: names of numbers, what nothing calls, imports of what is gone."""

import ast
import subprocess

import pytest

from larics_host.connection.byte_sources import SerialSource
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver
from larics_host.flash import build, linker
from larics_host.render import render_frame
from tests.host.firmware_process import environment, pieces
from tests.host.test_dual import ROOT, unix_port

PROGRAM = {
    "box": "",
    "box.limits": """
try:
    from micropython import const
except ImportError:
    from larics._cpython import const

    OURS = None

WIDE = const(300)
FAR = -WIDE * 2
NAME = "limits"
_OWN = const(7)
TWICE = 1
TWICE = 2


def least():
    return _OWN + WIDE


def never():
    return WIDE
""",
    "box.user": """
from box import limits as l
from box.limits import FAR, least


class Reader:
    def read(self):
        return (l.WIDE,
                FAR)

    def unread(self):
        return l.NAME

    def __len__(self):
        return l.TWICE


def main():
    reader = Reader()
    return reader.read(), least(), len(reader), getattr(reader, "asked", 0)


def asked():
    return l.NAME
""",
}


def test_numbers_are_written_where_they_are_used_and_unused_names_go():
    linked = linker.link(PROGRAM)
    limits, user = linked["box.limits"], linked["box.user"]
    assert "300" in limits and "WIDE" not in limits and "FAR" not in limits and "_OWN" not in limits
    assert "_cpython" not in limits and "OURS" not in limits
    assert "never" not in limits and "def least" in limits and "const(" not in limits
    assert "TWICE = 2" in limits, "set twice: no constant"
    assert "(300,\n                (-600))" in user
    assert "unread" not in user and "__len__" in user
    assert "def asked" in user, "its name stands in a text"
    assert "from box.limits import least" in user and "from box import limits as l" in user


def test_a_module_that_was_read_for_its_numbers_alone_is_not_imported():
    linked = linker.link({"a": "LIMIT = 3\n", "b": "from a import LIMIT\nimport a\nprint(LIMIT, a.LIMIT)\n"})
    assert linked["b"] == "pass\npass\nprint(3, 3)\n" and linked["a"] == "pass\n"


def test_a_module_that_is_imported_to_be_loaded_is_still_imported():
    linked = linker.link({"a": "", "a.b": "print(1)\n", "c": "def main():\n    import a.b\n"})
    assert linked["c"] == "def main():\n    import a.b\n"


def test_a_name_that_a_function_sets_itself_is_no_constant():
    linked = linker.link({"a": "N = 3\n\ndef main(N):\n    return N\n\nprint(N)\n"})
    assert linked["a"].startswith("N = 3") and "print(N)" in linked["a"]


def test_every_line_keeps_its_number():
    sources = {name: path.read_text() for path, name in build.program(ROOT)}
    texts = build.texts(ROOT)
    assert sources.keys() == texts.keys()
    for name, text in texts.items():
        lines = sources[name].splitlines()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                assert node.name in lines[node.lineno - 1], (name, node.name)


def test_the_whole_program_still_finds_all_that_it_imports():
    texts = {n[:-4].removesuffix("/__init__").replace("/", "."): t for n, t in build.texts(ROOT).items()}
    defined = {}
    for module, text in texts.items():
        names = set()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                names.add(node.id)
            elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                names.add(node.name)
            elif isinstance(node, (ast.Import, ast.ImportFrom)):
                names |= {(a.asname or a.name).split(".")[0] for a in node.names}
        defined[module] = names
    checked = 0
    for module, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.module in texts:
                for alias in node.names:
                    inside = "%s.%s" % (node.module, alias.name)
                    assert inside in texts or alias.name in defined[node.module], (module, inside)
                    checked += 1
    assert checked > 150


def own_architecture():
    """What mpy-cross compiles for when the tests' interpreter is to run it."""
    said = subprocess.run(
        [*unix_port(), "-c", "import sys; print(sys.implementation._mpy)"], capture_output=True, text=True
    )
    return build.ARCHITECTURES[int(said.stdout) >> 10 & 0xF]


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    for index, (preset, options) in enumerate((("sunny", {}), ("cloudy", {"family": "coded"}))):
        frame, _ = render_frame(preset, 1750, index, width=320, height=240, **options)
        (folder / ("%d.pgm" % index)).write_bytes(b"P5\n320 240\n255\n" + frame.tobytes())
    return folder


def reported(search, script, frames, heap=None):
    """The markers that the program reports of these frames, without their ages; heap: for -X heapsize."""
    with PtyPair() as cable:
        source, receiver, markers = SerialSource(cable.device_b), Receiver(), []
        options = ["-X", "heapsize=" + heap] if heap else []
        program = [*unix_port(), *options, script, "--frames", str(frames), "--port", cable.device_a]
        process = subprocess.Popen(
            program, cwd=ROOT, env=environment(search), stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        for data in pieces(process, cable, source):
            for message in receiver.feed(data, 0.0):
                if message.name == "MARKER":
                    markers.append({k: v for k, v in message.fields._asdict().items() if k != "age_us"})
        output = process.stdout.read().decode()
        source.close()
    assert process.returncode == 0, output
    return markers


def test_the_linked_program_reports_what_the_sources_do(frames, tmp_path):
    for name, data in build.compile_program(ROOT, own_architecture(), build.PC_ONLY):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    script = tmp_path / "start_here.py"
    script.write_text("import sys\nfrom pc import replay_main\nreplay_main.main(sys.argv[1:])\n")
    expected = reported("shared:firmware:.frozen", "firmware/pc/replay_main.py", frames)
    assert len({marker["frame"] for marker in expected}) == 2 and any(m["id"] < 5000 for m in expected)
    assert reported("%s:.frozen" % tmp_path, str(script), frames) == expected
