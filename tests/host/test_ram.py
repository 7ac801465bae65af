"""Code and buffers of a board's program stay within the memory they may take."""

from tools import ram


def test_code_and_buffers_keep_their_limits(capsys):
    assert ram.main() == 0, capsys.readouterr().out
    said = capsys.readouterr().out
    assert "larics/kernels/robust" in said and "cells of votes" in said


def test_what_grows_past_a_limit_is_noticed(monkeypatch):
    _, total = ram.buffers()
    monkeypatch.setattr(ram, "BUFFERS_MOST", total - 1)
    monkeypatch.setattr(ram, "code", lambda: ([], 0))
    assert ram.main() == 1
    monkeypatch.setattr(ram, "BUFFERS_MOST", total)
    assert ram.main() == 0
    monkeypatch.setattr(ram, "code", lambda: ([("start.mpy", ram.CODE_MOST + 1, None, True)], 0))
    assert ram.main() == 1
    monkeypatch.setattr(ram, "code", lambda: ([("start.mpy", 1, ram.SMALL_MOST + 1, True)], 0))
    assert ram.main() == 1
    monkeypatch.setattr(ram, "code", lambda: ([], ram.NAMES_MOST + 1))
    assert ram.main() == 1
