"""Learns shared/larics/direct/evidence_tables.py: what all measured quantities of a line say together.

    python -m tools.learn_evidence [--cache FOLDER] [--check]

Rendered frames of plain markers are read from their true centres, a pixel or two off, as a tracked marker is;
of each coding line's place, and of each dark direction around the rings, the items of `kernels.evidence` are
taken, and whether a line was printed there. Pairs of comparisons are then added one by one, each the one that
lessens the error of those before the most (gradient boosting with trees of two levels, both halves of the
second alike), so that a kernel needs neither products nor branches beyond the two comparisons.

--check learns from the first half of each set and prints how surely and rightly the other half is told.
Takes half an hour; seeds below 1000 tune.
"""

import argparse
import struct
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics.arith.fixed import cdeg_from_turn16  # noqa: E402  (needs the path set above)
from larics.detect.detector import Detector  # noqa: E402
from larics.direct.line_reader import DIRECTIONS  # noqa: E402
from larics.kernels.layouts import BIAS  # noqa: E402
from larics.marker import CODED, verdicts  # noqa: E402
from tools.benchmark import frames  # noqa: E402
from tools.make_tables import literal  # noqa: E402

TARGET = ROOT / "shared/larics/direct/evidence_tables.py"
SETS = (
    *(("worn", seed, count) for seed, count in ((605, 600), (606, 600), (607, 400), (611, 300), (644, 600))),
    *(("worn", seed, 2000) for seed in (621, 622)),
    *(("glossy", seed, 600) for seed in (605, 606, 607, 608, 644)),
    *(("glossy", seed, 2000) for seed in (621, 622, 623)),
    *(
        ("harsh", seed, count)
        for seed, count in ((605, 600), (606, 600), (611, 300), (640, 600), (641, 1000))
    ),
    ("harsh", 622, 1000),
    *((preset, 621, count) for preset, count in (("webcam", 500), ("dirty_lens", 500), ("cloudy", 300))),
)
RADIUS_PX = 30.0
BIT_ITEMS, LINE_ITEMS = 20, 15
BIT_PAIRS, LINE_PAIRS = 60, 30
REFUSED = 3  # how often directions count where the rules find no line
NEAR_CDEG = 600  # a direction this near to the truth is the line's
LEARNING_RATE = 0.25
PRIOR = 2.0  # weight of "neither" in each leaf
QUANTILES = 24  # limits that are tried of each item
ZERO, OFFSET = 1 << 15, 1 << 12  # as in kernels.evidence

HEADER = '''"""Tables for kernels.evidence.weigh, as bytes that stay in flash. By tools/learn_evidence.py.

Items are little-endian uint16.
"""

'''


class Bench:
    """Reads one marker at a time up to the items of the evidence."""

    def __init__(self, width=frames.WIDTH, height=frames.HEIGHT):
        self.detector = Detector(width, height, 25, 35, family=CODED)
        self.direct = self.detector.direct

    def _fitted(self, frame, truth, random):
        """Whether rings are fitted around a marker, through a heading near its true one."""
        direct = self.direct
        rings, lines = direct.rings, direct.lines
        off_px = random.uniform(-1.5, 1.5, 2)
        x_q8 = int((truth.x_px + off_px[0]) * 256)
        y_q8 = int((truth.y_px + off_px[1]) * 256)
        scale = self.detector._scales[0]
        direct.examine(frame, scale, 0, x_q8, y_q8, int(truth.radius_px * 256 * random.uniform(0.97, 1.03)))
        if not rings.area:
            return False
        lines.angle_turn16 = turn16(truth.heading_deg)
        lines.read_code(frame, rings)
        rings.skip_lines(lines)
        for limit_q8 in (48, 96):
            if not rings.refine(frame, 16, 4, limit_q8):
                return False
            if rings.moved_q10 <= 120:
                break
        else:
            return False
        if direct.acceptance.rings(rings, scale.radius_min_q8, scale.radius_max_q8) != verdicts.ACCEPTED:
            return False
        if direct.robust.fit(rings):
            rings.take_centre(direct.robust)
        return True

    def items(self, frame, truth, random):
        """(bits, directions): each [(items, whether a line is there)]; empty where no rings are fitted."""
        bits, directions = [], []
        if not self._fitted(frame, truth, random):
            return bits, directions
        evidence, rings, lines = self.direct.evidence, self.direct.rings, self.direct.lines
        true = turn16(truth.heading_deg)
        repeats = REFUSED if lines.find_orientation(frame, rings) != 1 else 1
        for index in range(lines.list_directions(frame, rings, DIRECTIONS)):
            lines.measure_direction(frame, rings, index)
            if lines.measure_around(frame, rings):
                evidence.weigh_line(lines, rings)
                answer = off_cdeg(lines.angle_turn16, true) < NEAR_CDEG
                directions += repeats * [(list(evidence.items[:LINE_ITEMS]), answer)]
        lines.angle_turn16 = true
        lines.refine(frame, rings, 2)
        if off_cdeg(lines.angle_turn16, true) > NEAR_CDEG // 2:
            lines.angle_turn16 = true
        lines.read_code(frame, rings)
        if lines.code_inside and evidence.look_around(frame, rings, lines):
            for bit in range(1, 4):
                evidence.weigh_bit(lines, rings, bit)
                bits.append((list(evidence.items[:BIT_ITEMS]), truth.marker_id >> (3 - bit) & 1))
        return bits, directions


def turn16(heading_deg):
    return round(-heading_deg / 360 * 65536) & 65535


def off_cdeg(a_turn16, b_turn16):
    off = cdeg_from_turn16(a_turn16 - b_turn16 & 65535)
    return min(off, 36000 - off)


def collect(cache, preset, seed, count):
    """Items (n, k) and answers (n,) of bits, then of directions, of one set of frames."""
    bench = Bench()
    random = np.random.default_rng(seed)
    bits, directions = [], []
    for start in range(0, count, 25):
        for frame, truths in cache.block(preset, seed, start, 25, "larics", RADIUS_PX, {}):
            for truth in truths:
                if truth.visible >= 0.999:
                    of_bits, of_directions = bench.items(
                        np.ascontiguousarray(frame).reshape(-1), truth, random
                    )
                    bits += of_bits
                    directions += of_directions
    return [
        (np.array([row for row, _ in rows]) - BIAS, np.array([answer for _, answer in rows], float))
        for rows in (bits, directions)
    ]


def boost(items, answers, pairs):
    """[(item, limit, item, limit, four numbers)]; 256 = a factor of e."""
    limits = [
        (item, int(limit))
        for item in range(items.shape[1])
        for limit in np.unique(
            np.quantile(items[:, item], np.linspace(0, 1, QUANTILES + 2)[1:-1]).astype(int)
        )
    ]
    above = np.array([items[:, item] > limit for item, limit in limits], np.float32)
    total = np.zeros(len(answers))
    model = []
    for _ in range(pairs):
        chance = 1 / (1 + np.exp(-total))
        slope = (answers - chance).astype(np.float32)
        bend = (chance * (1 - chance)).astype(np.float32) + 1e-6

        def worth(slopes, bends):
            return slopes**2 / (bends + PRIOR)

        slopes, bends = above @ slope, above @ bend
        alone = worth(slopes, bends) + worth(slope.sum() - slopes, bend.sum() - bends)
        best = None
        for first in np.argsort(-alone)[:6]:
            within = above[first]
            slopes_1, bends_1 = above @ (slope * within), above @ (bend * within)
            slope_1, bend_1 = slopes[first], bends[first]
            gain = worth(slopes_1, bends_1) + worth(slope_1 - slopes_1, bend_1 - bends_1)
            slopes_0, bends_0 = slopes - slopes_1, bends - bends_1
            gain += worth(slopes_0, bends_0)
            gain += worth(slope.sum() - slope_1 - slopes_0, bend.sum() - bend_1 - bends_0)
            second = int(np.argmax(gain))
            if best is None or gain[second] > best[0]:
                best = gain[second], first, second
        _, first, second = best
        leaf_of = (above[first] * 2 + above[second]).astype(int)
        leaves = [
            round(
                256
                * LEARNING_RATE
                * float(slope[leaf_of == leaf].sum() / (bend[leaf_of == leaf].sum() + PRIOR))
            )
            for leaf in range(4)
        ]
        total += np.array(leaves)[leaf_of] / 256
        model.append((*limits[first], *limits[second], leaves))
    return model


def weigh(model, items):
    """The sums that `kernels.evidence.weigh` gives."""
    total = np.zeros(len(items), int)
    for first, first_limit, second, second_limit, leaves in model:
        total += np.array(leaves)[(items[:, first] > first_limit) * 2 + (items[:, second] > second_limit)]
    return total


def pack(model):
    numbers = []
    for first, first_limit, second, second_limit, leaves in model:
        numbers += [first | second << 8, first_limit + OFFSET, second_limit + OFFSET]
        numbers += [ZERO + leaf for leaf in leaves]
    return struct.pack("<%dH" % len(numbers), *numbers)


def write(bit_model, line_model):
    TARGET.write_text(
        HEADER
        + literal("BIT", "whether a coding line lies at a position", pack(bit_model))
        + "BIT_PAIRS = %d\n\n" % len(bit_model)
        + literal("LINE", "whether a direction is that of the orientation line", pack(line_model))
        + "LINE_PAIRS = %d\n" % len(line_model)
    )


def check(rows):
    """Prints, for limits of the surer kind, how many bits and directions are told, and how many wrongly."""
    for name, index, pairs in (("bits", 0, BIT_PAIRS), ("directions", 1, LINE_PAIRS)):
        halves = [[], []]
        for row in rows:
            items, answers = row[index]
            middle = len(items) // 2 // 3 * 3
            halves[0].append((items[:middle], answers[:middle]))
            halves[1].append((items[middle:], answers[middle:]))
        learnt, other = [[np.concatenate(part) for part in zip(*half, strict=True)] for half in halves]
        sums = weigh(boost(*learnt, pairs), other[0])
        for limit in (0, 256, 512, 768, 1024, 1280):
            told = np.abs(sums) >= limit
            wrong = told & ((sums > 0) != (other[1] > 0))
            print(
                "%s surer than %4d: %5.1f %% of %d, %d wrong"
                % (name, limit, 100 * told.mean(), len(told), wrong.sum())
            )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--cache", default=Path(tempfile.gettempdir()) / "larics-evidence", help="folder of rendered frames"
    )
    parser.add_argument("--check", action="store_true", help="judge by frames that were not learnt from")
    options = parser.parse_args(arguments)
    cache = frames.Cache(options.cache)
    rows = []
    for preset, seed, count in SETS:
        rows.append(collect(cache, preset, seed, count))
        print(preset, seed, count, len(rows[-1][0][0]) // 3, "markers", flush=True)
    if options.check:
        check(rows)
        return
    bits, directions = [
        [np.concatenate(part) for part in zip(*kind, strict=True)] for kind in zip(*rows, strict=True)
    ]
    write(boost(*bits, BIT_PAIRS), boost(*directions, LINE_PAIRS))


if __name__ == "__main__":
    main()
