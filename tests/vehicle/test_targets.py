"""The library on the computers that it is made for: the same results, within their flash and RAM."""

import pytest

from tools import vehicle_targets as targets

MOST_FLASH = {"avr": 26_500, "cortex": 13_000}


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """What a PC makes of the stream."""
    target = targets.TARGETS[0]
    return targets.run(target, targets.build(target, tmp_path_factory.mktemp("pc")))


@pytest.mark.parametrize("target", targets.TARGETS[1:], ids=lambda target: target.name)
def test_the_same_on_every_target(target, expected, tmp_path):
    reason = targets.missing(target)
    if reason:
        pytest.skip(reason)
    found = targets.run(target, targets.build(target, tmp_path))
    assert (found["crc"], found["messages"]) == (expected["crc"], 90)
    if target.platform in MOST_FLASH:
        assert sum(targets.flash(target, tmp_path).values()) < MOST_FLASH[target.platform]
        assert 200 < found["stack"] < 700
        assert found["ram_decoder"] + found["ram_supervisor"] + found["ram_drive"] < 900


@pytest.mark.parametrize("board", targets.BOARDS)
def test_the_sketches_fit(board, tmp_path):
    reason = targets.missing_arduino()
    if reason:
        pytest.skip(reason)
    sizes = targets.sketch_sizes(board, targets.all_sketches(), tmp_path)
    assert sizes
    for used, ram in sizes.values():
        assert used < 32256 and ram < targets.BOARDS[board][2] - 600  # what the stack takes, and room


def test_a_missing_tool_is_named_with_its_package(monkeypatch, capsys):
    there = {"gcc", "arm-none-eabi-gcc", "powerpc-linux-gnu-gcc"}
    monkeypatch.setattr(targets.shutil, "which", lambda tool: tool if tool in there else None)
    monkeypatch.setattr(targets, "TARGETS", targets.TARGETS[1:])
    assert targets.main(["uno", "cortex-m4", "big-endian"]) == 0
    out = capsys.readouterr().out
    assert "uno        left out, not installed: apt-get install gcc-avr avr-libc simavr" in out
    assert "qemu-system-arm" in out and "qemu-user" in out and "sketches   left out" in out
