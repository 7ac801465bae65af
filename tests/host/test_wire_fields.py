"""Fields of messages go by their names: generated indices on the board, generated records on the host."""

import ast
import subprocess

import pytest

from larics.wire import codec
from larics.wire import messages as m
from larics_host.connection import records
from tests.host.test_dual import ROOT, unix_port
from tools import make_protocol
from tools.protocol import python_text
from wire_values import message_values


def test_generated_parts_are_up_to_date(capsys):
    assert make_protocol.main(["--check"]) == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    "target, right, wrong",
    [
        ("HEADER", "#define LARICS_MARKER 2", "#define LARICS_MARKER 3"),
        ("SOURCE", "{LARICS_MARKER, ", "{LARICS_POSE, "),
        ("DOCUMENT", "| age_us | u32 |", "| age_us | u16 |"),
        ("README", "| MARKER |", "| MARKERS |"),
        ("RECORDS", "    age_us: int", "    age_ms: int"),
    ],
)
def test_a_stale_part_is_noticed(target, right, wrong, monkeypatch, tmp_path, capsys):
    path = getattr(make_protocol, target)
    changed = tmp_path / path.name
    text = path.read_text()
    assert right in text
    changed.write_text(text.replace(right, wrong))
    monkeypatch.setattr(make_protocol, target, changed)
    monkeypatch.setattr(make_protocol, "ROOT", tmp_path)
    assert make_protocol.main(["--check"]) == 1
    assert "stale: " + path.name in capsys.readouterr().out


@pytest.mark.parametrize("index", ["7", None])
def test_a_stale_index_is_noticed_and_mended(index, monkeypatch, tmp_path, capsys):
    """A wrong index, and one that is used but not yet there."""
    (tmp_path / "shared").mkdir()
    module = tmp_path / "shared" / "module.py"
    right = "_MARKER_AGE_US = const(%d)\n" % codec.fields(m.MARKER).index(
        next(field for field in codec.fields(m.MARKER) if field[0] == "age_us")
    )
    begin, end = make_protocol.INDICES
    body = "def age(values):\n    return values[_MARKER_AGE_US]\n"
    wrong = "" if index is None else "_MARKER_AGE_US = const(%s)\n" % index
    module.write_text(begin + "\n" + wrong + end + "\n" + body)
    monkeypatch.setattr(make_protocol, "ROOT", tmp_path)
    assert make_protocol.main(["--check"]) == 1 and "module.py" in capsys.readouterr().out
    assert make_protocol.main([]) == 0
    assert module.read_text() == begin + "\n" + right + end + "\n" + body
    assert make_protocol.main(["--check"]) == 0


def _board_modules():
    for folder in ("shared", "firmware"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            text = path.read_text()
            if make_protocol.INDICES[0] in text:
                yield path, text


def test_indices_cost_a_board_nothing():
    """MicroPython keeps none of them as a global."""
    names = []
    for path, text in _board_modules():
        if path.is_relative_to(ROOT / "shared"):
            name = ".".join(path.relative_to(ROOT / "shared").with_suffix("").parts)
            names += [(name, line.split(" ")[0]) for line in python_text.indices_used(text).splitlines()]
    assert len(names) > 60
    script = "\n".join("import %s as x\nassert not hasattr(x, %r), %r" % (n, i, i) for n, i in names)
    environment = {"MICROPYPATH": "shared:.frozen"}
    result = subprocess.run([*unix_port(), "-c", script], cwd=ROOT, env=environment, capture_output=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_nobody_counts_fields():
    """No module that knows the messages picks a field by a number."""
    found = []
    for path, text in _board_modules():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
                target = ast.unparse(node.value)
                if target.split(".")[-1] in (
                    "values",
                    "_info",
                    "part",
                    "header",
                    "_chunk",
                    "_header",
                    "known",
                ):
                    found.append("%s:%d: %s" % (path.relative_to(ROOT), node.lineno, ast.unparse(node)))
    assert not found


def test_records_are_the_table():
    for name, number, _, fields in m.MESSAGES:
        kind = records.RECORDS[number]
        assert kind.__name__ == python_text.class_name(name)
        assert kind._fields == tuple(field[0] for field in fields)


def test_a_record_copies_and_reads():
    board = bytearray(b"desk".ljust(16, b"\0"))
    record = records.record_of(m.INFO, message_values(m.INFO, boot=7, board=board, unique_id=bytearray(12)))
    board[:4] = b"none"
    assert (record.boot, record.board, record.unique_id) == (7, "desk", bytes(12))
    assert records.as_json(record)["unique_id"] == "00" * 12
    setting = records.record_of(m.SETTING, message_values(m.SETTING, value0=3, value7=9))
    assert setting.values == (3, 0, 0, 0, 0, 0, 0, 9)
    unsure = records.record_of(m.MARKER, message_values(m.MARKER, id=m.ID_NONE))
    assert records.as_json(unsure)["id"] is None
    with pytest.raises(ValueError):
        records.record_of(m.PING, [1, 2])
