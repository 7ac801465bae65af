"""Builds C programs with the vehicle library, and streams for them: for tests and for tools/fuzz_wire.py."""

import pathlib
import random
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "shared"))

from larics.wire import codec as protocol  # noqa: E402

LIBRARY = ROOT / "firmware" / "vehicle" / "src"
SOURCES = sorted(LIBRARY.glob("*.c"))
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wsign-conversion"]
# of the library alone
SIGNED = [*STRICT, "-Wshadow", "-Wstrict-prototypes", "-Wmissing-prototypes", "-Wold-style-definition"]
SIGNED += ["-Wcast-qual", "-Wpointer-arith", "-Wundef", "-Wvla", "-Wredundant-decls"]
SANITIZE = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def build(sources, program, *flags, compiler="gcc"):
    """Compiles sources and the library to `program`; subprocess.CalledProcessError when that fails."""
    files = [str(source) for source in (*sources, *SOURCES)]
    subprocess.run([compiler, *STRICT, *flags, "-I", str(LIBRARY), *files, "-o", str(program)], check=True)
    return program


def objects(folder, compiler, *flags):
    """Compiles each file of the library to an object in the folder; returns their paths."""
    made = []
    for source in SOURCES:
        made.append(pathlib.Path(folder) / (source.stem + ".o"))
        subprocess.run([compiler, *SIGNED, *flags, "-c", str(source), "-o", str(made[-1])], check=True)
    return made


def random_values(generator, number):
    """Field values of a message, often at the limits."""
    values = []
    for _, code, _, low, high, _ in protocol.fields(number):
        if code[-1] == "s":
            values.append(generator.randbytes(int(code[:-1])))
        else:
            values.append(generator.choice((low, high, generator.randint(low, high))))
    return values


def corpus(count, seed=1):
    """(bytes, [(type, sequence, values)]) of so many random messages of every type."""
    generator = random.Random(seed)
    encoder = protocol.Encoder()
    types = [message[1] for message in protocol.MESSAGES]
    data = bytearray()
    sent = []
    for _ in range(count):
        number = generator.choice(types)
        values = random_values(generator, number)
        if number in (protocol.INFO, protocol.STATUS):
            values[[field[0] for field in protocol.fields(number)].index("boot")] = 7
        sent.append((number, encoder.sequence, values))
        size = encoder.encode(number, values)
        data += encoder.buffer[:size]
    return bytes(data), sent


def drive_corpus(count, seed=1):
    """Bytes of so many messages of a camera at work; the frame number of each is its sequence number."""
    generator = random.Random(seed)
    encoder = protocol.Encoder()
    data = bytearray()
    for number in range(count):
        kind = generator.choices(
            (protocol.MARKER, protocol.POSE, protocol.STATUS, protocol.INFO, protocol.ACK), (60, 30, 6, 1, 3)
        )[0]
        values = {"boot": 7, "unique_id": b"camera-one--", "token": generator.randrange(65536)}
        values |= {"frame": number, "age_us": generator.randrange(30000), "uptime_s": number // 100}
        values |= {"x_mm10": generator.randint(-9000, 9000), "y_mm10": generator.randint(-9000, 9000)}
        values |= {
            "id": generator.choice((3, 4, 5)),
            "count": 1,
            "state": generator.choice((0, 1, 2, 2, 2, 3)),
        }
        values |= {
            "marker_age_ms": generator.choice((0, 20, 900, 65535)),
            "way_mm": generator.randrange(3000),
        }
        values |= {"sigma_x_mm10": generator.choice((20, 900, 65535)), "sigma_cdeg": generator.randrange(400)}
        values |= {"margin": generator.randrange(256), "command": protocol.PING}
        values["flags"] = generator.choice((0, 0, 0, protocol.MARKER_TRACKED, protocol.MARKER_UNCONFIRMED))
        row = []
        for name, code, _, low, high, _ in protocol.fields(kind):
            unknown = bytes(int(code[:-1])) if code[-1] == "s" else min(max(0, low), high)
            row.append(values.get(name, unknown))
        data += encoder.buffer[: encoder.encode(kind, row)]
    return bytes(data)


C_TYPES = {"B": "uint8_t", "H": "uint16_t", "h": "int16_t", "I": "uint32_t", "i": "int32_t"}


def exchange_source():
    """A C program that prints what it decodes from stdin (`decode`), field by field and by name, and
    encodes what such lines say (`encode`): "type sequence field field ...", bytes as hexadecimal."""
    show, read = [], []
    for name, _, _, fields in protocol.MESSAGES:
        place = "m->as.%s." % name.lower()
        show.append("    case LARICS_%s:" % name)
        read.append("    case LARICS_%s:" % name)
        for field, code, _, _, _, _ in fields:
            member = place + re.sub(r"^value(\d)$", r"value[\1]", field)
            if code[-1] == "s":
                show.append("        show_bytes(%s, sizeof %s);" % (member, member))
                read.append("        read_bytes(%s, sizeof %s);" % (member, member))
            else:
                kind = C_TYPES[code]
                show.append('        printf(" %%lld", (long long)%s);' % member)
                read.append("        %s = (%s)read_number();" % (member, kind))
        show.append("        break;")
        read.append("        break;")
    return EXCHANGE % ("\n".join(show), "\n".join(read))


EXCHANGE = r"""
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "larics.h"

static void show_bytes(const uint8_t *data, size_t count)
{
    printf(" ");
    while (count--) printf("%%02x", *data++);
}

static long long read_number(void)
{
    long long value = 0;
    if (scanf("%%lld", &value) != 1) exit(3);
    return value;
}

static void read_bytes(uint8_t *data, size_t count)
{
    unsigned value;
    while (count--) {
        if (scanf("%%2x", &value) != 1) exit(3);
        *data++ = (uint8_t)value;
    }
}

static void show(const larics_message *m)
{
    printf("%%d %%d", m->type, m->sequence);
    switch (m->type) {
%s
    }
    printf("\n");
}

static void read(larics_message *m)
{
    switch (m->type) {
%s
    }
}

int main(int argc, char **argv)
{
    static larics_decoder d;
    larics_message m;
    int byte, type;
    if (argc > 1 && !strcmp(argv[1], "decode")) {
        larics_decoder_init(&d);
        while ((byte = getchar()) != EOF)
            if (larics_decode(&d, (uint8_t)byte)) show(&d.message);
        fprintf(stderr, "messages=%%lu crc=%%lu cobs=%%lu length=%%lu version=%%lu unknown=%%lu "
                "over_long=%%lu empty=%%lu out_of_range=%%lu gaps=%%lu repeats=%%lu restarts=%%lu\n",
                (unsigned long)d.counters.messages, (unsigned long)d.counters.crc,
                (unsigned long)d.counters.cobs, (unsigned long)d.counters.length,
                (unsigned long)d.counters.version, (unsigned long)d.counters.unknown,
                (unsigned long)d.counters.over_long, (unsigned long)d.counters.empty,
                (unsigned long)d.counters.out_of_range, (unsigned long)d.counters.gaps,
                (unsigned long)d.counters.repeats, (unsigned long)d.counters.restarts);
        return 0;
    }
    while (scanf("%%d", &type) == 1) {
        uint8_t frame[LARICS_MAX_FRAME];
        size_t size;
        memset(&m, 0, sizeof m);
        m.type = (uint8_t)type;
        m.sequence = (uint16_t)read_number();
        read(&m);
        size = larics_encode(&m, m.sequence, frame);
        if (!size) fprintf(stderr, "refused %%d\n", m.sequence);
        fwrite(frame, 1, size, stdout);
    }
    return 0;
}
"""
