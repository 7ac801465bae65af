"""Long damage runs on both decoders of the wire; the tests hold shorter ones.

    python tools/fuzz_wire.py --python 10000000 --c 1000000000 --guided-s 600

--python  mutated bytes through the Python decoder
--c       mutated bytes through the C decoder at -O2, and a tenth as many with sanitizers
--supervised  mutated bytes through the C supervisor with sanitizers
--guided-s  seconds of coverage-guided fuzzing (needs clang with libFuzzer)

Prints figures; the exit code is 1 when a message was accepted that was never sent, or a sanitizer or the
fuzzer found something.
"""

import argparse
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "shared")]

from larics.wire.codec import Decoder  # noqa: E402
from tools.vehicle_build import LIBRARY, SANITIZE, SOURCES, STRICT, build, corpus, drive_corpus  # noqa: E402

HERE = ROOT / "tests" / "vehicle"


def damaged(generator, data, starts):
    """A run of frames, cut, spliced, repeated, and hit by flips, losses, insertions and noise."""
    first = generator.randrange(len(starts) - 1)
    last = min(len(starts) - 1, first + generator.randrange(1, 400))
    piece = bytearray(data[starts[first] : starts[last]])
    for _ in range(generator.randrange(0, 120)):
        if len(piece) < 2:
            break
        place = generator.randrange(len(piece))
        length = generator.randrange(1, 25)
        kind = generator.randrange(7)
        if kind == 0:
            piece[place] ^= 1 << generator.randrange(8)
        elif kind == 1:
            piece[place : place + length] = generator.randbytes(length)
        elif kind == 2:
            del piece[place : place + length]
        elif kind == 3:
            piece[place:place] = generator.randbytes(length)
        elif kind == 4:
            piece[place:place] = piece[place : place + length]
        elif kind == 5 and not generator.randrange(40):
            del piece[place:]
        else:
            piece[place] = 0
    return piece


def python_run(wanted, seed=1):
    """Figures of so many mutated bytes through the Python decoder, as a dict."""
    data, sent = corpus(5000, seed)
    starts = [0] + [k + 1 for k, byte in enumerate(data) if byte == 0]
    generator = random.Random(seed)
    figures = {"bytes": 0, "accepted": 0, "forged": 0, "seconds": 0.0}

    def judge(number, sequence, values):
        figures["accepted"] += 1
        expected = sent[sequence] if sequence < len(sent) else None
        if expected is None or expected[0] != number or expected[2] != list(values):
            figures["forged"] += 1

    decoder = Decoder(judge)
    while figures["bytes"] < wanted:
        piece = damaged(generator, data, starts)
        start = time.perf_counter()
        decoder.feed(piece, len(piece))
        figures["seconds"] += time.perf_counter() - start
        figures["bytes"] += len(piece)
    figures["mb_per_s"] = figures["bytes"] / figures["seconds"] / 1e6
    return figures | decoder.counters.as_dict()


def python_throughput():
    """MB/s of the Python decoder on an undamaged stream of random messages."""
    data, _ = corpus(30000)
    decoder = Decoder(lambda number, sequence, values: None)
    start = time.perf_counter()
    decoder.feed(data, len(data))
    return len(data) / (time.perf_counter() - start) / 1e6


def c_run(folder, wanted, *flags):
    """Figures of so many mutated bytes through the C decoder, as a dict."""
    data, _ = corpus(60000)
    path = pathlib.Path(folder) / "corpus"
    path.write_bytes(data)
    program = build([HERE / "mutate.c"], pathlib.Path(folder) / "mutate", *flags)
    output = subprocess.run(
        [str(program), str(path), str(wanted), "7"], check=True, capture_output=True, text=True
    ).stdout
    figures = {name: float(value) for name, value in (pair.split("=") for pair in output.split())}
    figures["mb_per_s"] = figures["bytes"] / figures["seconds"] / 1e6
    return figures


def supervised_run(folder, wanted, *flags):
    """Figures of so many mutated bytes through decoder and supervisor, as a dict."""
    path = pathlib.Path(folder) / "drive"
    path.write_bytes(drive_corpus(60000))
    program = build([HERE / "mutate.c"], pathlib.Path(folder) / "mutate", *flags)
    command = [str(program), str(path), str(wanted), "7", "supervise"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return {name: float(value) for name, value in (pair.split("=") for pair in output.split())}


def guided_run(folder, seconds):
    """libFuzzer on the C decoder; its last lines. CalledProcessError when it found something."""
    folder = pathlib.Path(folder)
    seeds = folder / "seeds"
    seeds.mkdir()
    data, _ = corpus(200)
    for k, frame in enumerate(data.split(b"\0")[:-1]):
        (seeds / str(k)).write_bytes(b"\1" + frame + b"\0")
    program = folder / "fuzz"
    command = ["clang", *STRICT, "-O1", "-g", "-fsanitize=fuzzer,address,undefined", "-I", str(LIBRARY)]
    command += [str(HERE / "fuzz_decoder.c"), *map(str, SOURCES), "-o", str(program)]
    subprocess.run(command, check=True)
    options = ["-max_total_time=%d" % seconds, "-max_len=1024", "-print_final_stats=1"]
    result = subprocess.run(
        [str(program), str(seeds), *options], check=True, capture_output=True, text=True, cwd=folder
    )
    return [line for line in result.stderr.splitlines() if "DONE" in line or "stat::" in line]


def show(title, figures):
    print(title)
    print("  " + " ".join("%s=%g" % item for item in figures.items()), flush=True)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "--python", type=int, default=10_000_000, metavar="BYTES", help="for the Python decoder (10 million)"
    )
    parser.add_argument(
        "--c", type=int, default=1_000_000_000, metavar="BYTES", help="for the C decoder (1000 million)"
    )
    parser.add_argument(
        "--supervised",
        type=int,
        default=1_000_000_000,
        metavar="BYTES",
        help="through the supervisor (1000 million)",
    )
    parser.add_argument(
        "--guided-s", type=int, default=600, metavar="SECONDS", help="of coverage-guided fuzzing (600)"
    )
    options = parser.parse_args(arguments)
    forged = 0
    with tempfile.TemporaryDirectory() as folder:
        if options.python:
            print("Python decoder, undamaged stream: %.1f MB/s" % python_throughput())
            figures = python_run(options.python)
            forged += figures["forged"]
            show("Python decoder, mutated", figures)
        if options.c:
            figures = c_run(folder, options.c // 10, "-O1", *SANITIZE)
            forged += figures["forged"]
            show("C decoder, mutated, address and undefined-behaviour sanitizers", figures)
            figures = c_run(folder, options.c, "-O2")
            forged += figures["forged"]
            show("C decoder, mutated, -O2 (the rate includes the check of each message)", figures)
        if options.supervised:
            figures = supervised_run(folder, options.supervised, "-O1", *SANITIZE)
            forged += figures["forged"] + figures["stale"] + figures["unfit"]
            show("C supervisor, mutated, address and undefined-behaviour sanitizers", figures)
        if options.guided_s and not shutil.which("clang"):
            print("clang is not installed: no coverage-guided fuzzing")
        elif options.guided_s:
            print("C decoder, coverage-guided, %d s" % options.guided_s, flush=True)
            print("\n".join("  " + line for line in guided_run(folder, options.guided_s)))
    return 1 if forged else 0


if __name__ == "__main__":
    sys.exit(main())
