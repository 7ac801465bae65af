"""Logs packed by gzip are read as they are, whole or damaged, by every command that takes a log."""

import gzip
import os

import pytest

from larics_host import cli
from larics_host.connection.camera_settings import read_file
from larics_host.errors import UserError, begin_run
from larics_host.images.frame_sources import open_frames
from larics_host.logs.columns import read_columns
from larics_host.logs.log_reader import read_pieces
from larics_host.packed import opened
from tests.host.test_replay import messages


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """PREFIX of a log with all files."""
    folder = tmp_path_factory.mktemp("log")
    (folder / "came.bin").write_bytes(messages(200))
    words = ["log", "--input", str(folder / "came.bin"), "-o", str(folder / "run"), "--mcap", "--raw"]
    assert cli.main(words) == 0
    return folder / "run"


@pytest.mark.parametrize("suffix", [".bin", ".jsonl", ".csv", ".mcap"])
def test_a_packed_log_is_the_log(log, tmp_path, capsys, suffix):
    data = log.with_suffix(suffix).read_bytes()
    half = len(data) // 2
    whole = [piece.data for piece in read_pieces(log.with_suffix(suffix))]
    columns = read_columns(log.with_suffix(suffix), ["MARKER"])["MARKER"]
    capsys.readouterr()
    forms = {
        "a%s.gz": gzip.compress(data),
        "b%s.gz": gzip.compress(data[:half]) + gzip.compress(data[half:]) + bytes(512),
        "c%s": gzip.compress(data),  # under its own name
        "d.log": gzip.compress(data),
    }
    for name, packed in forms.items():
        path = tmp_path / (name % suffix if "%" in name else name)
        path.write_bytes(packed)
        assert [piece.data for piece in read_pieces(path)] == whole
        assert (read_columns(path, ["MARKER"])["MARKER"] == columns).all()
        if path.suffix == ".gz":
            assert cli.main(["fleet", str(path)]) == 0
        assert capsys.readouterr().err == ""


def test_times_of_packed_bytes_come_from_the_lines_beside(log, tmp_path):
    (tmp_path / "run.bin.gz").write_bytes(gzip.compress(log.with_suffix(".bin").read_bytes()))
    (tmp_path / "run.jsonl").write_bytes(log.with_suffix(".jsonl").read_bytes())
    assert list(read_pieces(tmp_path / "run.bin.gz")) == list(read_pieces(log.with_suffix(".bin")))


@pytest.mark.parametrize(
    "spoil, told",
    [
        (lambda packed: packed[: len(packed) * 2 // 3], "is cut off; what is whole of it is read"),
        (lambda packed: packed[:-3], "is cut off; what is whole of it is read"),
        (lambda packed: packed + b"junk" * 9, "something else follows the packed data"),
        (lambda packed: packed[:-8] + bytes(8), "is damaged; what is whole of it is read"),
    ],
)
def test_of_a_damaged_one_what_is_whole_is_read(log, tmp_path, capsys, spoil, told):
    noise = os.urandom(60000)  # which gzip cannot make shorter
    data = log.with_suffix(".bin").read_bytes()
    path = tmp_path / "run.bin.gz"
    path.write_bytes(spoil(gzip.compress(data + noise)))
    capsys.readouterr()
    assert cli.main(["log", "--input", str(path), "-o", str(tmp_path / "again")]) == 0
    text = capsys.readouterr()
    assert told in text.err and "run.bin.gz" in text.err
    assert (tmp_path / "again.jsonl").read_text().splitlines()[:50]
    assert len(list(read_pieces(path))) >= len(list(read_pieces(log.with_suffix(".bin"))))
    begin_run()
    assert cli.main(["fleet", str(path)]) == 0 and told in capsys.readouterr().err


def test_one_that_holds_nothing_or_is_none(tmp_path):
    for data in (gzip.compress(b""), b"\x1f", b"\x1f\x8b", b"\x1f\x8bnothing of the kind"):
        (tmp_path / "a.bin.gz").write_bytes(data)
        with pytest.raises(UserError, match="a.bin.gz"):
            list(read_pieces(tmp_path / "a.bin.gz"))


def test_other_ways_of_packing_that_end_early_are_read_by_fleet(log, tmp_path, capsys):
    import bz2
    import lzma

    data = log.with_suffix(".jsonl").read_bytes()
    for name, pack in (("a.jsonl.bz2", bz2.compress), ("a.jsonl.xz", lzma.compress)):
        (tmp_path / name).write_bytes(pack(data) + pack(os.urandom(400000))[:-9])
        assert cli.main(["fleet", str(tmp_path / name)]) == 0
        assert "%s is cut off or damaged; what is whole of it is read" % name in capsys.readouterr().err


def test_what_is_read_at_once_is_told_to_be_unpacked(tmp_path):
    (tmp_path / "a").write_bytes(gzip.compress(b"{}"))
    with pytest.raises(UserError, match="a: a compressed file: unpack it first"):
        next(open_frames([tmp_path / "a"]))
    with pytest.raises(UserError, match="a is a compressed file: unpack it first"):
        read_file(tmp_path / "a")


def test_the_bytes_come_out_whatever_pieces_are_asked_for(tmp_path):
    data = bytes(range(256)) * 1000
    (tmp_path / "a.gz").write_bytes(gzip.compress(data[:70000]) + gzip.compress(data[70000:]))
    for size in (1, 7, 4096, 1 << 20):
        with opened(tmp_path / "a.gz") as file:
            assert b"".join(iter(lambda: file.read(size), b"")) == data  # noqa: B023 (called at once)
