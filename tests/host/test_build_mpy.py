"""Everything that goes to a board compiles for it, and what does not compile fails the build."""

import pytest

from tools import build_mpy


def test_all_sources_compile_for_every_architecture(tmp_path, capsys):
    assert build_mpy.build(output=tmp_path) == 0
    printed = capsys.readouterr().out
    compiled = [name for _, name in build_mpy.sources()]
    assert "larics/arith/fixed.py" in {name.as_posix() for name in compiled}
    assert "larics/_cpython.py" not in printed
    for architecture in ("armv7emsp", "xtensawin"):
        assert architecture in printed
        for name in compiled:
            data = (tmp_path / architecture / name.with_suffix(".mpy")).read_bytes()
            assert data[:2] == b"M\x06", name  # the format that MicroPython 1.23 and later loads
    assert printed.splitlines()[-1].startswith("total")


@pytest.fixture
def tree(tmp_path):
    (tmp_path / "shared/larics").mkdir(parents=True)
    (tmp_path / "firmware").mkdir()
    (tmp_path / "shared/larics/good.py").write_text("x = 1\n")
    return tmp_path


def test_a_syntax_error_fails(tree, capsys):
    (tree / "firmware/bad.py").write_text("def f(:\n")
    assert build_mpy.build(tree, tree / "out") == 2
    said = capsys.readouterr().err
    assert "firmware/bad.py, armv7emsp" in said and "SyntaxError" in said


def test_what_only_a_32_bit_board_refuses_fails(tree, capsys):
    (tree / "shared/larics/kernel.py").write_text(
        "import micropython\n@micropython.viper\ndef f(a: int) -> int:\n    return a & 0xFFFFFFFE\n"
    )
    assert build_mpy.build(tree, tree / "out") >= 1
    assert "kernel.py, armv7emsp" in capsys.readouterr().err


def test_an_empty_tree_fails(tmp_path):
    assert build_mpy.build(tmp_path, tmp_path / "out") == 1
