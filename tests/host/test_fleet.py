"""`larics fleet`: what it finds in a fleet with known faults, in blocks, on cores and on a Dask cluster."""

import contextlib
import csv
import gzip
import json
import os
import shutil
import signal
import subprocess
import sys
import tracemalloc

import pytest

from larics.wire import messages as m
from larics.wire.codec import Encoder
from larics_host import cli
from larics_host.connection.receiver import Message, wire_bytes
from larics_host.connection.records import Ack, Marker, Status
from larics_host.errors import UserError
from larics_host.fleet import engine, sources
from larics_host.fleet.findings import examine
from larics_host.fleet.passes import Passes, Reading, judged
from larics_host.fleet.sources import Block, Source, blocks, lines, list_logs
from larics_host.fleet.tally import Work, read_block, vehicles
from larics_host.fleet.trends import trend
from larics_host.images.frame_folder import frame_name, write_frame
from larics_host.logs.log_writer import json_line
from larics_host.truth import by_frame, read_truth
from tests.host.fleet_logs import HALL, Vehicle, record, write_map
from tests.host.plain_marker import stained_frame
from tests.host.test_dual import ROOT
from tests.host.waiting import wait_until

DAYS = 5


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    """Folder with the logs of four vehicles, each with a fault of its own, under a hall with two."""
    folder = tmp_path_factory.mktemp("fleet")
    write_map(folder / "hall.json")
    hall = dict(HALL)
    hall[3] = (HALL[3][0] + 120, HALL[3][1] + 40, HALL[3][2] + 5)

    def misread(rng, marker):
        return 6 if marker == 5 and rng.random() < 0.1 else marker

    def margin(fall):
        return lambda day, marker: 160 - fall * day - (9 * day if marker == 2 else 0)

    parts = {
        "good": Vehicle(1, margin(0), hall=hall),
        "lens": Vehicle(2, margin(10), hall=hall),
        "scale": Vehicle(3, margin(0), hall=hall, scale=1.03),
        "misreads": Vehicle(4, margin(0), misread, hall, faults=1 << m.FAULT_CAMERA_DARK),
    }
    for name, vehicle in parts.items():
        for day in range(DAYS):
            vehicle.write(folder / "logs" / name / ("%d.jsonl" % day), day)
    return folder


def command(*words):
    return cli.main(["fleet", *map(str, words)])


def found(rows):
    return {(row["kind"], row["vehicle"], row["marker"]) for row in rows}


def read_table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_every_fault_is_found_and_nothing_else(fleet, tmp_path, capsys):
    words = fleet / "logs", "--map", fleet / "hall.json", "-o", tmp_path, "--report", tmp_path / "f.html"
    assert command(*words, "--jobs", 1) == 0
    rows = read_table(tmp_path / "findings.csv")
    assert found(rows) == {
        ("wrong ID", "misreads", "5"),
        ("moved marker", "", "3"),
        ("worn or dirty marker", "", "2"),
        ("dirty lens", "lens", ""),
        ("calibration", "scale", ""),
        ("fault", "misreads", ""),
    }
    by_id = {row["marker"]: row for row in read_table(tmp_path / "markers.csv")}
    assert float(by_id["3"]["off_mm"]) == pytest.approx(126.5, abs=15)
    assert float(by_id["3"]["off_deg"]) == pytest.approx(5, abs=0.5)
    assert float(by_id["2"]["margin_change"]) == pytest.approx(-9 * (DAYS - 1), abs=6)
    by_name = {row["vehicle"]: row for row in read_table(tmp_path / "vehicles.csv")}
    assert float(by_name["scale"]["distance_error_pct"]) == pytest.approx(3, abs=0.3)
    assert float(by_name["lens"]["margin_change"]) == pytest.approx(-10 * (DAYS - 1), abs=6)
    good = by_name["good"]
    assert int(good["logs"]) == DAYS and good["cameras"] == "openmv 01010101"
    assert float(good["rate_hz"]) == pytest.approx(20, abs=0.1) and int(good["lost_messages"]) == 0
    page = (tmp_path / "f.html").read_text()
    for text in ("worn or dirty marker", "CAMERA_DARK for ", "misreads"):
        assert text in page
    assert "src=" not in page and "moved marker: marker 3" in capsys.readouterr().out


def test_without_a_map_what_needs_none_is_found(fleet, tmp_path):
    assert command(fleet / "logs", "-o", tmp_path, "--jobs", 1) == 0
    kinds = {kind for kind, _, _ in found(read_table(tmp_path / "findings.csv"))}
    assert kinds == {"wrong ID", "worn or dirty marker", "dirty lens", "calibration", "fault"}


def test_a_fleet_without_faults_has_no_finding(tmp_path, capsys):
    for number in range(3):
        for day in range(DAYS):
            Vehicle(10 + 7 * number + day).write(tmp_path / "logs" / str(number) / ("%d.jsonl" % day), day)
    write_map(tmp_path / "hall.json")
    assert command(tmp_path / "logs", "--map", tmp_path / "hall.json", "--jobs", 1) == 0
    assert "no finding" in capsys.readouterr().out


def tallied(paths, block_bytes, **options):
    work = [Work(block, (), 10) for block in blocks(list_logs(paths), block_bytes)]
    answers = engine.run(read_block, work, **options)
    return vehicles((one.block, answer) for one, answer in zip(work, answers, strict=True))[0]


def test_blocks_add_up_whatever_their_size(fleet):
    path = str(fleet / "logs" / "good" / "0.jsonl")
    whole = tallied([path], 1 << 30)["0"]
    for size in (500, 4096, 100_000):
        parts = tallied([path], size)["0"]
        for name in (
            "bytes",
            "lines",
            "damaged",
            "lost",
            "frames_seen",
            "statuses",
            "states",
            "sums",
            "readings",
            "told_s",
            "fault_seconds",
        ):
            if name != "frames_seen":
                assert getattr(parts, name) == getattr(whole, name), (size, name)
        assert parts.seconds == pytest.approx(whole.seconds)
    assert whole.lines == path_lines(path) and whole.damaged == 0 and whole.sums["missed"] > 0


def test_a_status_stands_for_the_time_since_the_one_before(tmp_path):
    """A program that is held up sends no STATUS meanwhile; one that nobody recorded tells nothing."""
    path, faulty = tmp_path / "held.jsonl", 1 << m.FAULT_CAMERA_DARK
    told = [(0, 1, 0), (1, 2, 0), (3, 8, faulty), (4, 9, faulty), (5, 10, 0), (900, 70, faulty), (901, 71, 0)]
    with open(path, "wb") as file:
        for sequence, uptime_s, faults in told:
            status = record(Status, uptime_s=uptime_s, active_faults=faults, state=m.LOST, boot=7)
            file.write(json_line(Message("STATUS", sequence, status, float(uptime_s)), 0))
            if sequence == 1:  # one more message, so that a block may have no STATUS
                file.write(json_line(Message("ACK", 2, record(Ack), 2.0), 0))
    for size in (1, 200, 100_000):
        tally = tallied([str(path)], size)["held"]
        assert tally.told_s == tally.states[m.LOST] == 1 + 1 + 6 + 1 + 1 + 1 + 1
        assert dict(tally.fault_seconds) == {m.FAULT_CAMERA_DARK: 6 + 1 + 1}


def test_recorded_frames_are_read_again(tmp_path, capsys):
    """Two folders as of larics record: one camera told what its frames show, the other had a bad memory."""
    names = ["sunny_r30_1000_%d.pgm" % k for k in range(3)]
    truths = by_frame(read_truth(ROOT / "tests/frames"))
    for vehicle, error in (("right", 0), ("wrong", 1)):
        folder = tmp_path / "seen" / vehicle
        folder.mkdir(parents=True)
        (folder / "settings.json").write_text("{}")
        with open(folder / "messages.jsonl", "wb") as file:
            for number, name in enumerate(names):
                shutil.copyfile(ROOT / "tests/frames" / name, folder / frame_name(number))
                told = (truths[name][0].id + error * (number == 1)) & 7 or 7
                marker = record(Marker, frame=number, id=told, count=1, flags=m.MARKER_NO_OFFSET)
                file.write(json_line(Message("MARKER", number, marker, number / 10), 0))
            # what was fetched meanwhile is not in the log
            none = record(Marker, frame=90, id=m.ID_NONE, flags=m.MARKER_NONE)  # of no recorded frame
            file.write(json_line(Message("MARKER", 1000, none, 9.0), 0))
    assert command(tmp_path / "seen", "-o", tmp_path / "t", "--jobs", 1) == 0
    capsys.readouterr()
    rows = {row["vehicle"]: row for row in read_table(tmp_path / "t" / "vehicles.csv")}
    assert rows["right"]["recorded_frames"] == rows["wrong"]["recorded_frames"] == str(len(names))
    assert float(rows["right"]["recorded_alike_pct"]) == 100 > float(rows["wrong"]["recorded_alike_pct"])
    (finding,) = read_table(tmp_path / "t" / "findings.csv")
    assert finding["kind"] == "not as its frames" and rows["right"]["lost_messages"] == "0"
    assert finding["vehicle"] == "wrong" and "frame_000001.pgm: told " in finding["text"]
    (tmp_path / "seen" / "wrong" / "settings.json").write_text('{"radius_min_px": 900}')
    assert command(tmp_path / "seen", "--jobs", "1") == 1
    assert "the frames beside %s" % (tmp_path / "seen" / "wrong") in capsys.readouterr().err


def test_recorded_frames_of_a_small_heap_are_read_as_there(tmp_path, capsys):
    """A stained marker that such a board refuses is no sign of a bad memory."""
    folder = tmp_path / "seen" / "small"
    folder.mkdir(parents=True)
    (folder / "settings.json").write_text('{"radius_min_px": 24, "radius_max_px": 34}')
    write_frame(folder / frame_name(0), stained_frame())
    none = record(Marker, frame=0, id=m.ID_NONE, flags=m.MARKER_NONE)
    (folder / "messages.jsonl").write_bytes(json_line(Message("MARKER", 0, none, 0.1), 0))
    assert command(tmp_path / "seen", "-o", tmp_path / "t", "--jobs", 1) == 0
    capsys.readouterr()
    (row,) = read_table(tmp_path / "t" / "vehicles.csv")
    assert (row["recorded_frames"], float(row["recorded_alike_pct"])) == ("1", 100.0)


def path_lines(path):
    with open(path) as file:
        return sum(1 for _ in file)


def test_lost_messages_and_damage_are_counted(tmp_path, fleet, capsys):
    data = (fleet / "logs" / "good" / "0.jsonl").read_bytes().splitlines(keepends=True)
    odd = [b"\0" * 50 + b"\n", b'{"message": "MARKER"}\n']
    odd.append(b'{"message": "MARKER", "sequence": 1, "time_s": NaN}\n')
    damaged = [*data[:100], *odd, *data[107:-1], data[-1][:-30]]
    path = tmp_path / "damaged.jsonl"
    path.write_bytes(b"".join(damaged))
    tally = tallied([str(path)], 3000)["damaged"]
    assert tally.lost == 7 and tally.damaged == 4
    (tmp_path / "empty.jsonl").write_bytes(b"")
    assert command(path, tmp_path / "empty.jsonl", "--by", "file") == 1
    text = capsys.readouterr()
    assert text.err == "larics: %s is empty\nlarics: damaged: 4 lines damaged; the rest is read\n" % (
        tmp_path / "empty.jsonl"
    )
    assert "empty " not in text.out


def test_a_log_without_a_good_line_is_none(tmp_path, fleet, capsys):
    (tmp_path / "bad.jsonl").write_text('abc\n{"x": 1}\n{"time_s": 1, "mess')
    assert cli.main(["fleet", str(tmp_path / "bad.jsonl")]) == 2
    err = capsys.readouterr().err
    assert "bad.jsonl: none of its 3 lines is a message of larics log\n" in err and "could be read" in err
    good = str(fleet / "logs" / "good" / "0.jsonl")
    assert cli.main(["fleet", good, str(tmp_path / "bad.jsonl"), "--by", "file"]) == 1
    text = capsys.readouterr()
    assert "2 logs of 1 vehicle" in text.out and "bad.jsonl: none of its" in text.err
    (tmp_path / "blank.jsonl").write_text("\n\n")
    assert cli.main(["fleet", str(tmp_path / "blank.jsonl")]) == 2
    assert "blank.jsonl holds no message\n" in capsys.readouterr().err
    # in blocks of which one has a good line, it is a log
    lines_of_good = (fleet / "logs" / "good" / "0.jsonl").read_text().splitlines()
    with open(tmp_path / "bad.jsonl", "a") as file:
        file.write("\n%s\n" % lines_of_good[0])
    work = [Work(block, (), 10) for block in blocks(list_logs([str(tmp_path / "bad.jsonl")]), 20)]
    tallies, counts, errors = vehicles((one.block, read_block(one)) for one in work)
    assert len(work) > 2 and list(tallies) == list(counts) and len(tallies) == 1 and not errors


def test_what_is_no_line_neither_fills_the_memory_nor_is_read_twice(tmp_path):
    path = tmp_path / "zeros.jsonl"
    path.write_bytes(bytes(6 << 20) + b"\n" + b'{"a": 1}\n')
    source = Source("zeros", None, str(path), path.stat().st_size, "v")
    tracemalloc.start()
    got = [line for block in blocks([source], 1 << 20) for line in lines(block)]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert got[-1] == b'{"a": 1}\n' and len(got) == 2 and len(got[0]) == sources._LINE_MOST
    assert peak < 1 << 20


def test_memory_is_bounded_by_the_block_and_not_by_the_log(fleet, tmp_path):
    text = (fleet / "logs" / "good" / "0.jsonl").read_bytes()
    path = tmp_path / "long.jsonl"
    peaks = []
    for copies in (5, 20):
        path.write_bytes(text * copies)
        tallied([str(path)], 1 << 16)  # what is kept of markers is kept from here on
        tracemalloc.start()
        tallied([str(path)], 1 << 16)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] + 300_000 and peaks[1] < path.stat().st_size / 2


def test_other_kinds_of_logs_tell_the_same(fleet, tmp_path):
    path = fleet / "logs" / "misreads" / "1.jsonl"
    want = tallied([str(path)], 1 << 30)["1"]
    packed = tmp_path / "packed.jsonl.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    table = tmp_path / "table.csv"
    records = [json.loads(line) for line in path.read_text().splitlines()]
    columns = [name for name in records[1] if name not in ("time", "message")]
    with open(table, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(record for record in records if record["message"] == "MARKER")
    odd = [tmp_path / "named.jsonl", tmp_path / "windows.jsonl", tmp_path / "windows_be.jsonl"]
    odd[0].write_bytes(packed.read_bytes())
    odd[1].write_text(path.read_text(), encoding="utf-16", newline="\r\n")
    odd[2].write_text("\ufeff" + path.read_text(), encoding="utf-16-be")
    for one in (packed, table, *odd):
        got = tallied([str(one)], 1 << 30)[one.name.split(".")[0]]
        assert (got.frames, got.wrong, got.visits) == (want.frames, want.wrong, want.visits)
        assert sum(sums[1] for sums in got.readings.values()) == sum(s[1] for s in want.readings.values())


def test_bytes_alone_are_timed_by_the_camera(fleet, tmp_path):
    path = fleet / "logs" / "misreads" / "1.jsonl"
    want = tallied([str(path)], 1 << 30)["1"]
    records, encoder = [json.loads(line) for line in path.read_text().splitlines()], Encoder()
    data = b"".join(wire_bytes(encoder, one["message"], one["sequence"], one) for one in records)
    (tmp_path / "1.bin").write_bytes(data)
    got = tallied([str(tmp_path / "1.bin")], 1 << 30)["1"]
    assert (got.frames, got.wrong, got.visits) == (want.frames, want.wrong, want.visits)
    assert got.seconds == pytest.approx(want.seconds, abs=1.5) and want.visits > 3
    # joined, and begun anew by another boot: it goes on
    (tmp_path / "1.bin").write_bytes(data * 2)
    twice = tallied([str(tmp_path / "1.bin")], 1 << 30)["1"]
    assert twice.wrong == want.wrong + want.wrong
    assert twice.seconds == pytest.approx(2 * want.seconds, abs=3)


def test_an_address_of_fsspec_is_read_as_a_path(fleet):
    local = list_logs([str(fleet / "logs")])
    remote = list_logs(["file://%s/logs/**/*.jsonl" % fleet])
    assert [one.vehicle for one in remote] == [one.vehicle for one in local]
    for here, there in zip(local, remote, strict=True):
        assert list(lines(Block(here, 0, 9999))) == list(lines(Block(there, 0, 9999)))


def test_of_a_log_in_several_forms_one_is_read(fleet, tmp_path):
    text = (fleet / "logs" / "good" / "0.jsonl").read_bytes()
    for name in ("run.jsonl", "run.bin", "run.csv", "other.jsonl", "notes.txt"):
        (tmp_path / name).write_bytes(text)
    assert [one.vehicle for one in list_logs([str(tmp_path)])] == ["other", "run"]
    assert [one.path for one in list_logs([str(tmp_path)])] == [
        str(tmp_path / "other.jsonl"),
        str(tmp_path / "run.jsonl"),
    ]


def test_a_visit_has_one_plate_and_its_rarer_ids_are_wrong():
    passes = Passes()
    told = []
    for k in range(20):
        wrong = k in (5, 6, 12)
        told += passes.add(0.05 * k, [Reading(3 if wrong else 4, 500 - 45 * k, 0, 90, 100)])
    told += passes.add(1.6, [Reading(3, 0, 0, 90, 100)])  # after a gap: another plate
    told += passes.end()
    assert [judged(ids) for ids in told] == [(4, {3: 3}), (3, {})]


def test_a_trend_needs_periods_and_must_be_sure():
    rising = [("2026-01-%02d" % (k + 1), 100.0 - 5 * k + (k % 2), 50) for k in range(6)]
    one = trend(rising)
    assert one.change == pytest.approx(-25, abs=2) and one.sure > 10
    assert trend(rising[:3]) is None and trend([("", 1.0, 99)] * 9) is None
    noise = [("2026-01-%02d" % (k + 1), 100.0 + 20 * (k % 2), 50) for k in range(6)]
    assert trend(noise).sure < 4


# a cluster of Dask, of real processes on loopback


def started(folder, name, *words, package=None):
    paths = [str(ROOT / "shared"), str(ROOT / "host"), str(ROOT)]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(([str(package)] if package else []) + paths))
    with open(folder / (name + ".log"), "wb") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *words], env=environment, stdout=log, stderr=log, cwd=folder
        )


class Cluster:
    """Scheduler and two workers; `kill` ends one by force."""

    def __init__(self, folder, workers=2, package=None):
        self.folder = folder
        file = folder / "scheduler.json"
        local = "--host", "127.0.0.1", "--no-dashboard"
        words = "scheduler", "--port", "0", "--scheduler-file", str(file), *local
        self.processes = [started(folder, "scheduler", *words)]
        wait_until(lambda: file.exists() and file.read_text().endswith("}"))
        self.address = json.loads(file.read_text())["address"]
        words = "worker", self.address, "--nthreads", "1", "--no-nanny", *local
        for k in range(workers):
            self.processes.append(started(folder, "worker%d" % k, *words, package=package))

    def kill(self, number):
        self.processes[number].send_signal(signal.SIGKILL)
        self.processes[number].wait()

    def close(self):
        for process in reversed(self.processes):
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            process.wait()


@pytest.fixture()
def cluster(tmp_path):
    made = []

    def make(**options):
        made.append(Cluster(tmp_path, **options))
        return made[-1]

    yield make
    for one in made:
        one.close()


def told(fleet, answers, work):
    return vehicles((one.block, answer) for one, answer in zip(work, answers, strict=True))


def figures(fleet_found):
    tallies, logs, _ = fleet_found
    return json.dumps([list(part) for part in examine(tallies, logs)], default=str)


def work_of(fleet, block_bytes=20_000):
    return [Work(block, (), 10) for block in blocks(list_logs([str(fleet / "logs")]), block_bytes)]


def test_a_cluster_gives_the_same_bits_and_a_dead_worker_costs_nothing_else(fleet, cluster):
    work = work_of(fleet)
    want = figures(told(fleet, engine.run(read_block, work), work))
    assert figures(told(fleet, engine.run(read_block, work, jobs=2), work)) == want
    dask = cluster()
    answers = engine.run(read_block, work, scheduler=dask.address)
    first = next(answers)
    dask.kill(1)
    rest = list(answers)
    assert figures(told(fleet, [first, *rest], work)) == want


@pytest.mark.long(20)
def test_a_scheduler_that_dies_is_one_line(fleet, cluster):
    dask = cluster()
    answers = engine.run(read_block, work_of(fleet), scheduler=dask.address)
    next(answers)
    dask.kill(0)
    with pytest.raises(UserError, match="the scheduler at .* is gone"):
        list(answers)


def test_workers_of_another_larics_are_refused(fleet, cluster, tmp_path):
    other = tmp_path / "other"
    for name in ("larics_host", "larics"):
        parent = "host" if name == "larics_host" else "shared"
        subprocess.run(["cp", "-r", str(ROOT / parent / name), "-t", str(tmp_path)], check=True)
        other.mkdir(exist_ok=True)
        (tmp_path / name).rename(other / name)
    (other / "larics_host" / "plots.py").write_text("# of another version\n")
    dask = cluster(workers=1, package=other)
    with pytest.raises(UserError, match="another version of larics"):
        list(engine.run(read_block, work_of(fleet), scheduler=dask.address))


def test_a_scheduler_of_another_version_is_refused(fleet, cluster, monkeypatch):
    import distributed

    dask = cluster(workers=0)
    monkeypatch.setattr(distributed, "__version__", "2020.1.0")
    with pytest.raises(UserError, match="this computer 2020.1.0: install the same on all"):
        list(engine.run(read_block, work_of(fleet), scheduler=dask.address))


@pytest.mark.parametrize(
    "words, said",
    [
        (["nothing"], "nothing: no log there"),
        (["{logs}", "--scheduler", "here"], "--scheduler here is no address"),
        (["{logs}", "--scheduler", "tcp://127.0.0.1:9"], "no Dask scheduler answers at tcp://127.0.0.1:9"),
        (["{logs}", "--jobs", "0"], "--jobs 0: give a number"),
        (["what://x/y.jsonl"], "Protocol not known"),
        (["{logs}", "--map", "nothing.json"], "cannot read nothing.json"),
    ],
)
def test_bad_input_is_one_line(fleet, words, said, capsys, monkeypatch):
    monkeypatch.setattr(engine, "_CONNECT_S", 1)
    assert command(*[word.format(logs=fleet / "logs") for word in words]) == 2
    err = capsys.readouterr().err
    assert said in err and len(err.strip().splitlines()) == 1, err


def test_missing_packages_are_asked_for_by_their_extra(fleet, capsys, monkeypatch, tmp_path):
    for name in ("distributed", "fsspec", "pyarrow"):
        monkeypatch.setitem(sys.modules, name, None)
    for words in (["--scheduler", "tcp://127.0.0.1:9"], ["-o", tmp_path, "--format", "parquet"]):
        assert command(fleet / "logs" / "good", "--jobs", 1, *words) == 2
        assert 'pip install "larics[fleet]"' in capsys.readouterr().err
    assert command("s3://x/y.jsonl") == 2 and 'pip install "larics[fleet]"' in capsys.readouterr().err


def test_a_log_that_cannot_be_read_leaves_the_others(fleet, tmp_path, capsys):
    (tmp_path / "good.jsonl").write_bytes((fleet / "logs" / "good" / "0.jsonl").read_bytes())
    (tmp_path / "bad.mcap").write_bytes(b"\x89MCAP nothing")
    assert command(tmp_path, "--jobs", 1) == 1
    captured = capsys.readouterr()
    assert "bad.mcap" in captured.err and "good" in captured.out


def test_tables_as_parquet(fleet, tmp_path):
    import pyarrow.parquet

    assert command(fleet / "logs", "-o", tmp_path, "--format", "parquet", "--jobs", 1) == 0
    table = pyarrow.parquet.read_table(tmp_path / "vehicles.parquet").to_pydict()
    assert table["vehicle"] == ["good", "lens", "misreads", "scale"] and all(table["frames"])


def test_validate_on_a_cluster_finds_what_it_finds_here(cluster, tmp_path):
    frames = tmp_path / "frames"
    assert cli.main(["simulate", "--frames", "12", "--seed", "5300", "-o", str(frames)]) == 0
    figures = []
    dask = cluster(workers=1)
    for words in (
        [str(frames), "--jobs", "1"],
        [str(frames), "--scheduler", dask.address],
        ["file://%s" % frames, "--scheduler", dask.address],
    ):
        path = tmp_path / "figures.json"
        assert cli.main(["validate", *words, "--radius-px", "25:36", "--force", "--json", str(path)]) == 0
        one = json.loads(path.read_text())["methods"][0]
        one.pop("median_ms")
        figures.append(one)
    assert figures[0]["frames"] == 12 and figures[0] == figures[1] == figures[2]


def test_frames_of_an_address_are_detected_as_those_of_a_path(tmp_path, capsys):
    frame = ROOT / "tests" / "frames" / "sunny_r30_1000_0.pgm"
    found = []
    for name in (str(frame), "file://%s" % frame):
        assert cli.main(["detect", name, "--json", "--radius-px", "25:35"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0]["detections"] == found[1]["detections"] and found[1]["frame"] == "file://%s" % frame
