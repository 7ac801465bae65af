"""Two cameras on one line are told as that in log, monitor and fleet, and their numbers as no loss."""

import pytest

from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder
from larics_host import cli
from larics_host.connection.receiver import Receiver
from larics_host.connection.source_watch import SourceWatch
from larics_host.monitor.state import MonitorState
from wire_values import message_values


def frames_of(number, values, sequences):
    encoder = Encoder()
    for sequence in sequences:
        encoder.sequence = sequence
        yield bytes(encoder.buffer[: encoder.encode(number, message_values(number, **values))])


def two_cameras():
    """STATUS of two cameras by turns, whose numbers lie far apart."""
    for second in range(6):
        for boot, begin in ((100, 0), (200, 30000)):
            values = {"boot": boot, "uptime_s": second, "state": m.LOST}
            yield from frames_of(m.STATUS, values, [begin + second])


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "two.bin"
    path.write_bytes(b"".join(two_cameras()))
    return path


def test_a_boot_number_that_returns_is_another_camera_and_a_restart_is_none():
    watch = SourceWatch()
    assert not any(map(watch.status, (1, 1, 2, 2, 3, 4))) and not watch.is_mixed
    assert watch.status(2) is None  # drawn again by chance
    watch = SourceWatch()
    told = [watch.status(boot) for boot in (200, 100) * 4]
    assert watch.is_mixed and [one for one in told if one] == [told[3]] and "boots 100 and 200" in told[3]
    assert watch.info("aa") is None and watch.info("bb") is None  # that is known by now


def test_the_log_tells_two_cameras(log, tmp_path, capsys):
    assert cli.main(["log", "--input", str(log), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    assert capsys.readouterr().err.count("two cameras speak by turns (boots 100 and 200)") == 1


def test_the_monitor_tells_two_cameras(log):
    state, receiver = MonitorState("test"), Receiver()
    for message in receiver.feed(log.read_bytes(), 1.0):
        state.add(message, receiver.counters)
    assert sum("two cameras speak by turns" in text for _, text in state.snapshot()["events"]) == 1


def test_the_fleet_tells_two_cameras_and_no_loss(log, capsys):
    assert cli.main(["fleet", str(log), "--jobs", "1"]) == 0
    told = capsys.readouterr().out
    assert "line: two: two cameras speak by turns" in told and "were lost" not in told
    assert told.splitlines()[2].split()[-1] == "-"


def test_the_fleet_counts_an_overtaken_message_as_the_decoder_does(tmp_path, capsys):
    order = [0, 1, 3, 2, 4, 7, 6, 5, 8, 10, 11]  # 9 is lost
    data = b"".join(frames_of(m.STATUS, {"boot": 1, "state": m.LOST}, order))
    decoder = Decoder(lambda *_: None)
    decoder.feed(data, len(data))
    (tmp_path / "late.bin").write_bytes(data)
    assert cli.main(["fleet", str(tmp_path / "late.bin"), "--jobs", "1"]) == 0
    lost = int(capsys.readouterr().out.splitlines()[2].split()[-1])
    assert lost == decoder.counters.gaps == 1


def told(steps):
    """STATUS of one boot by (sequence, uptime)."""
    for sequence, uptime_s in steps:
        yield from frames_of(m.STATUS, {"boot": 1, "uptime_s": uptime_s, "state": m.LOST}, [sequence])


@pytest.mark.parametrize("first", [100, 40000])
@pytest.mark.parametrize("length", [20, 500, 31000, 50000])
def test_recordings_that_are_joined_lost_nothing(first, length):
    part = [(first + 1, 4), (first + 3, 5), ((first + length) % 65536, 6)]
    receiver, once = Receiver(), Receiver()
    once.feed(b"".join(told(part)), 0.0)
    receiver.feed(b"".join(told(part * 3)), 0.0)
    assert receiver.counters.gaps == 3 * once.counters.gaps > 0
    assert receiver.counters.restarts - 3 * once.counters.restarts == 2


def test_a_status_that_was_overtaken_is_no_recording():
    receiver = Receiver()
    receiver.feed(b"".join(told([(5, 1), (7, 3), (6, 2), (8, 4), (10, 5)])), 0.0)
    assert (receiver.counters.gaps, receiver.counters.restarts) == (1, 0)


def test_the_fleet_counts_joined_recordings_as_the_receiver_does(tmp_path, capsys):
    data = b"".join(told([(40000, 4), (60000, 5), (14000, 6)] * 2))
    receiver = Receiver()
    receiver.feed(data, 0.0)
    (tmp_path / "joined.bin").write_bytes(data)
    assert cli.main(["fleet", str(tmp_path / "joined.bin"), "--jobs", "1"]) == 0
    assert int(capsys.readouterr().out.splitlines()[2].split()[-1]) == receiver.counters.gaps
