"""The vehicle's C library: strict compilation, vectors exchanged with Python both ways, damage, staleness."""

import random
import shutil
import subprocess

import pytest

import larics
from frozen_frames import FRAMES
from larics.wire import framing
from larics.wire import messages as m
from larics.wire.codec import Counters, Decoder, Encoder, fields
from larics.wire.messages import COUNT_MAX, INFO, ODOMETRY, PING, STATUS
from recorded import Stream, message
from tools import vehicle_build
from tools.vehicle_build import LIBRARY, ROOT, SANITIZE, build, corpus

HERE = ROOT / "tests" / "vehicle"


@pytest.fixture(scope="session")
def programs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("vehicle")
    source = folder / "exchange.c"
    source.write_text(vehicle_build.exchange_source())
    return {
        "exchange": build([source], folder / "exchange", *SANITIZE),
        "mutate": build([HERE / "mutate.c"], folder / "mutate", "-O1", *SANITIZE),
    }


def run(program, *arguments, data=b""):
    return subprocess.run([str(program), *arguments], input=data, capture_output=True, check=True)


def counts(text):
    return {name: int(count) for name, count in (pair.split("=") for pair in text.split())}


def in_c(program, data):
    """([(type, sequence, values)], counters) as C decodes it."""
    result = run(program, "decode", data=data)
    messages = []
    for line in result.stdout.decode().splitlines():
        number, sequence, *items = line.split(" ")
        codes = [field[1] for field in fields(int(number))]
        values = [
            bytes.fromhex(item) if code[-1] == "s" else int(item)
            for item, code in zip(items, codes, strict=True)
        ]
        messages.append((int(number), int(sequence), values))
    return messages, counts(result.stderr.decode())


def in_python(data):
    messages = []

    def keep(number, sequence, values):
        values = [bytes(value) if isinstance(value, bytearray) else value for value in values]
        messages.append((number, sequence, values))

    decoder = Decoder(keep)
    decoder.feed(data, len(data))
    return messages, decoder.counters.as_dict()


def test_python_to_c(programs):
    data, sent = corpus(3000, seed=11)
    messages, found = in_c(programs["exchange"], data)
    assert messages == sent
    assert found == dict.fromkeys(Counters.NAMES, 0) | {"messages": 3000}


def test_frozen_bytes_in_c(programs):
    data = b"".join(bytes.fromhex(text) for _, _, _, text in FRAMES)
    expected = [(number, sequence, list(values)) for number, sequence, values, _ in FRAMES]
    assert in_c(programs["exchange"], data)[0] == expected


def test_c_to_python(programs):
    data, sent = corpus(3000, seed=12)
    lines = []
    for number, sequence, values in sent:
        items = [value.hex() if isinstance(value, bytes) else str(value) for value in values]
        lines.append(" ".join([str(number), str(sequence), *items]))
    result = run(programs["exchange"], "encode", data="\n".join(lines).encode())
    assert result.stderr == b""
    assert result.stdout == data
    assert in_python(result.stdout)[0] == sent


def test_c_refuses_to_encode_what_python_refuses(programs):
    lines, refused = [], []
    limits = {
        "B": (0, 255),
        "H": (0, 65535),
        "h": (-32768, 32767),
        "I": (0, 2**32 - 1),
        "i": (-(2**31), 2**31 - 1),
    }
    for _, number, _, message_fields in m.MESSAGES:
        for place, (_, code, _, low, high, _) in enumerate(message_fields):
            for value in (low - 1, high + 1):
                if code[-1] == "s" or not limits[code][0] <= value <= limits[code][1]:
                    continue  # no C variable of this type holds it
                values = ["00" * int(f[1][:-1]) if f[1][-1] == "s" else str(f[3]) for f in message_fields]
                values[place] = str(value)
                refused.append(len(lines))
                lines.append(" ".join([str(number), str(len(lines)), *values]))
    result = run(programs["exchange"], "encode", data="\n".join(lines).encode())
    assert result.stdout == b""
    assert result.stderr.decode().split() == [word for k in refused for word in ("refused", str(k))]
    assert len(refused) > 60


def test_both_decoders_judge_damaged_streams_alike(programs):
    data, sent = corpus(2000, seed=13)
    known = {(sequence, number): values for number, sequence, values in sent}
    generator = random.Random(5)
    for _ in range(10):
        damaged = bytearray(data)
        for _ in range(500):
            place = generator.randrange(len(damaged))
            kind = generator.randrange(5)
            if kind == 0:
                damaged[place] ^= 1 << generator.randrange(8)
            elif kind == 1:
                del damaged[place : place + generator.randrange(1, 90)]
            elif kind == 2:
                damaged[place:place] = generator.randbytes(generator.randrange(1, 200))
            elif kind == 3:
                damaged[place:place] = damaged[place : place + generator.randrange(1, 200)]
            else:
                damaged[place] = 0
        c_messages, c_counts = in_c(programs["exchange"], damaged)
        python_messages, python_counts = in_python(damaged)
        assert c_counts == python_counts
        assert c_messages == python_messages
        assert all(known[(sequence, number)] == values for number, sequence, values in c_messages)
        assert c_counts["crc"] and c_counts["cobs"] and c_counts["length"] and c_counts["empty"]


def test_other_versions_types_and_ranges_alike(programs):
    encoder = Encoder()
    data = bytearray()
    generator = random.Random(6)
    for _ in range(4000):
        number, _, values = corpus(1, seed=generator.random())[1][0]
        size = encoder.encode(number, values)
        content = bytearray(framing.LIMIT + 8)
        content[1:5] = bytes([1, number, encoder.sequence & 255, encoder.sequence >> 8])
        payload = generator.randbytes(size - 10)
        content[5 : 5 + len(payload)] = payload
        if generator.random() < 0.1:
            content[1] = generator.randrange(256)
        if generator.random() < 0.1:
            content[2] = generator.randrange(256)
        end = 5 + len(payload) - (generator.random() < 0.1)
        data += content[: framing.seal(content, end)]
    c_messages, c_counts = in_c(programs["exchange"], data)
    assert (c_messages, c_counts) == in_python(data)
    for name in ("messages", "version", "unknown", "length", "out_of_range"):
        assert c_counts[name] > 100


def test_both_count_the_same_losses_and_restarts(programs):
    """Sequences that jump, go back, swap, and boot numbers that change or do not."""
    generator = random.Random(8)
    encoder = Encoder()
    for _ in range(60):
        data, boot = b"", generator.randrange(3)
        for _ in range(40):
            step = generator.choice((1, 1, 1, 0, 2, 7, -1, -7, -8, -9, 300, 30000, 33000, -300))
            encoder.sequence = (encoder.sequence + step - 1) & 0xFFFF
            if generator.random() < 0.1:
                encoder.sequence, boot = generator.randrange(4), generator.randrange(3)
            number = generator.choice((INFO, STATUS, PING))
            values = message(number, **({} if number == PING else {"boot": boot}))
            data += bytes(encoder.buffer[: encoder.encode(number, values)])
        assert in_c(programs["exchange"], data)[1] == in_python(data)[1]


def test_odometry_as_c_fills_it(tmp_path):
    """(sampled, now, x, y, heading) across the end of a 32-bit clock and with angles beyond a turn."""
    cases = [(1000, 1500, 10, -20, 9000), (2**32 - 100, 400, -5, 7, -1), (2**30 + 5, 2**30 + 9, 0, 0, 36000)]
    cases += [(7, 7, 1, 2, -72001), (0, 0, 2**29, 0, 0)]
    source = tmp_path / "odometry.c"
    calls = "\n".join("    send(%du, %du, %d, %d, %d);" % case for case in cases)
    source.write_text(ODOMETRY_PROGRAM % calls)
    data = run(build([source], tmp_path / "odometry", *SANITIZE)).stdout
    found = [
        dict(zip([field[0] for field in fields(ODOMETRY)], v, strict=True)) for _, _, v in in_python(data)[0]
    ]
    expected = [
        {"time_us": sampled % 2**30, "age_us": (now - sampled) % 2**30, "x_mm10": x, "y_mm10": y,
         "heading_cdeg": heading % 36000, "epoch": 9, "flags": 0}
        for sampled, now, x, y, heading in cases[:-1]
    ]  # fmt: skip
    assert found == expected  # further than an odometry may be is not sent


ODOMETRY_PROGRAM = """
#include <stdio.h>
#include "larics.h"

static void send(uint32_t sampled, uint32_t now, int32_t x, int32_t y, int32_t heading)
{
    static larics_message message;
    static uint16_t sequence;
    uint8_t frame[LARICS_MAX_FRAME];
    larics_set_odometry(&message, sampled, now, x, y, heading, 9);
    fwrite(frame, 1, larics_encode(&message, sequence++, frame), stdout);
}

int main(void)
{
%s
    return 0;
}
"""


def test_counters_wrap_where_those_of_python_do(tmp_path):
    source = tmp_path / "wrap.c"
    source.write_text(WRAP)
    program = build([source], tmp_path / "wrap", *SANITIZE)
    encoder = Encoder()
    data = bytes(encoder.buffer[: encoder.encode(PING, [1])])
    encoder.sequence = 10
    data += bytes(encoder.buffer[: encoder.encode(PING, [1])]) + b"\0"
    decoder = Decoder(lambda *_: None)
    for name in Counters.NAMES:
        setattr(decoder.counters, name, COUNT_MAX)
    decoder.feed(data, len(data))
    found = [int(word) for word in run(program, data=data).stdout.split()]
    assert found == list(decoder.counters.as_dict().values())
    assert decoder.counters.messages == 1 and decoder.counters.gaps == 8 and decoder.counters.empty == 0


WRAP = """
#include <stdio.h>
#include "larics.h"

int main(void)
{
    static larics_decoder d;
    uint32_t *counters = (uint32_t *)&d.counters;
    size_t count = sizeof d.counters / sizeof *counters;
    int byte;
    larics_decoder_init(&d);
    for (size_t k = 0; k < count; k++) counters[k] = LARICS_COUNT_MAX;
    while ((byte = getchar()) != EOF) larics_decode(&d, (uint8_t)byte);
    for (size_t k = 0; k < count; k++) printf("%lu ", (unsigned long)counters[k]);
    return 0;
}
"""


def test_mutated_streams_in_c(programs, tmp_path):
    data, _ = corpus(5000, seed=14)
    (tmp_path / "corpus").write_bytes(data)
    found = run(programs["mutate"], str(tmp_path / "corpus"), "20000000", "1").stdout.decode().split("\n")
    figures = {name: float(value) for name, value in (pair.split("=") for pair in found[0].split())}
    assert figures["bytes"] >= 20_000_000 and figures["forged"] == 0
    assert figures["accepted"] > 100_000
    assert min(counts(found[1])[name] for name in ("crc", "cobs", "over_long", "empty", "length")) > 100


def test_nothing_stale_is_fresh_in_mutated_streams(programs, tmp_path):
    (tmp_path / "corpus").write_bytes(vehicle_build.drive_corpus(20000))
    output = run(programs["mutate"], str(tmp_path / "corpus"), "10000000", "3", "supervise").stdout.decode()
    figures = {name: float(value) for name, value in (pair.split("=") for pair in output.split())}
    assert figures["forged"] == figures["stale"] == figures["unfit"] == 0
    assert figures["fresh"] > 5_000 and figures["challenges"] > 1000


def test_the_library_needs_nothing_but_string_and_stdint(tmp_path):
    text = "".join(path.read_text() for path in sorted(LIBRARY.iterdir()))
    includes = {line.split()[1] for line in text.splitlines() if line.startswith("#include")}
    own = {'"%s"' % path.name for path in LIBRARY.glob("*.h")}
    # stddef: macros only; pgmspace: on AVR
    assert includes - own == {"<string.h>", "<stdint.h>", "<stddef.h>", "<avr/pgmspace.h>"}
    objects = vehicle_build.objects(tmp_path, "gcc", "-O2")
    if shutil.which("nm"):
        defined, needed = set(), set()
        for path in objects:
            table = subprocess.run(["nm", str(path)], capture_output=True, text=True).stdout
            for line in table.splitlines():
                *_, kind, name = line.split()
                if kind.isupper():
                    (needed if kind == "U" else defined).add(name)
        allowed = {"memcpy", "memset", "memcmp", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}
        assert needed - defined <= allowed
        assert all(name.startswith("larics_") for name in defined)


def test_it_is_also_cplusplus(tmp_path):
    if not shutil.which("g++"):
        pytest.skip("no g++")
    source = tmp_path / "main.cpp"
    headers = "".join('#include "%s"\n' % path.name for path in sorted(LIBRARY.glob("larics*.h")))
    source.write_text(headers + "int main() { larics_decoder d; larics_decoder_init(&d); return 0; }\n")
    objects = map(str, vehicle_build.objects(tmp_path, "gcc"))
    command = ["g++", "-Wall", "-Wextra", "-Werror", "-I", str(LIBRARY), str(source), *objects]
    subprocess.run([*command, "-o", str(tmp_path / "main")], check=True)
    run(tmp_path / "main")


def marker_frames(*places):
    """Bytes of MARKERs at these y, 0.1 mm; None stands for a frame without a marker."""
    camera = Stream()
    return b"".join(camera.nothing() if y is None else camera.marker(y=y) for y in places)


def test_the_linux_example(tmp_path):
    source = ROOT / "firmware" / "vehicle" / "examples" / "linux" / "read_stream.c"
    program = build([source], tmp_path / "read_stream", *SANITIZE)
    data = marker_frames(123, None)
    text = run(program, data=b"noise\0" + data[:-1] + b"\0").stdout.decode()
    assert "frame 1: marker 3 (1 of 1) x 10.0 y 12.3 mm heading 0.00 deg margin 0 age 15.0 ms" in text
    assert "frame 2: no marker" in text
    assert text.splitlines()[-1].startswith("2 messages, 0 missing; refused: crc 0 cobs 1 length 0")
    failed = subprocess.run([program, str(tmp_path / "none")], capture_output=True, text=True)
    assert failed.returncode == 2 and failed.stderr.count("\n") == 1


def test_the_arduino_library(tmp_path):
    folder = LIBRARY.parent
    properties = dict(line.split("=", 1) for line in (folder / "library.properties").read_text().splitlines())
    headers = {path.name for path in (folder / "src").glob("*.h")}
    assert properties["version"] == larics.__version__
    assert (
        properties["includes"].split(",")[0] == "larics.h"
        and set(properties["includes"].split(",")) <= headers
    )
    if not shutil.which("g++"):
        pytest.skip("no g++")
    build_sketch("FollowMarker", tmp_path)
    for y_mm10, turn in ((500, "1"), (-500, "-1"), (0, "0"), (None, None)):
        camera = Stream()
        request = run_sketch(tmp_path / "sketch", b"")[1]  # the same in each run: the clock and A0 are
        data = camera.answer(request[: request.index(0) + 1])
        data += camera.nothing() if y_mm10 is None else camera.marker(y=y_mm10)
        lines = run_sketch(tmp_path / "sketch", data)[0].splitlines()
        drives = [pair for pair in zip(lines, lines[1:], strict=False) if pair[0].startswith("turn")]
        if turn is None:
            assert set(drives) == {("turn 0", "speed 0")}
        else:
            assert ("turn %s" % turn, "speed 100") in drives
        assert drives[-1] == ("turn 0", "speed 0")  # nothing new came: it has stopped


def test_the_sketch_that_drives_a_route(tmp_path):
    """Markers of the route are driven to, others not; odometry goes to the camera all the time."""
    if not shutil.which("g++"):
        pytest.skip("no g++")
    build_sketch("DriveRoute", tmp_path)
    asked = run_sketch(tmp_path / "sketch", b"")[1]
    request = asked[: asked.index(0) + 1]
    kinds = [number for number, _, _ in in_python(asked)[0]]
    assert kinds[0] == m.GET_INFO and kinds.count(m.ODOMETRY) == 49  # of 20 ms
    for marker_id, is_straight in ((4, True), (9, False)):
        camera = Stream()
        data = camera.answer(request)
        data += b"".join(camera.marker(marker_id, x=4000, y=0) for _ in range(100))
        lines = run_sketch(tmp_path / "sketch", data)[0].splitlines()
        left, right = (int(line.split()[1]) for line in lines[-60:-58])
        assert left > 20 and (abs(left - right) <= 2) == is_straight  # else the spiral of a search


def build_sketch(name, folder):
    sketch = LIBRARY.parent / "examples" / name / (name + ".ino")
    objects = map(str, vehicle_build.objects(folder, "gcc"))
    command = ["g++", "-Wall", "-Wextra", "-Werror", "-I", str(LIBRARY), '-DSKETCH="%s"' % sketch]
    command += [str(HERE / "arduino" / "sketch.cpp"), *objects, "-o", str(folder / "sketch")]
    subprocess.run(command, check=True)


def run_sketch(program, data):
    """(what it prints, what it sends to the camera)"""
    result = subprocess.run([str(program)], input=data, capture_output=True, check=True)
    return result.stdout.decode(), result.stderr
