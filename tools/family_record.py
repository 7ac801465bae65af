"""The measurement of record of both families of markers: wrong IDs, one family taken for the other, and
IDs read where no marker hangs, on frames that nothing was tuned on.

    python tools/family_record.py --seed 9200 --output build/record
    python tools/family_record.py --share 0.05                     # a twentieth of every condition
    python tools/family_record.py --cache /tmp/frames              # render once, read again later

With all frames that is 20,000 coded markers, 5,000 of them in harsh scenes, 5,000 plain ones, and 50,000
cluttered or photographed frames without a marker: an hour on one core, nearly all of it for rendering. It
takes a tenth of every condition at a time, so that what is there when it is ended early is as representative;
after each tenth it prints the table and writes record.json with the keys of the frames that went wrong.
Detectors read both families, as without a setting.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import NamedTuple

if __package__:
    from .benchmark import evaluate, methods, report
else:
    from benchmark import evaluate, methods, report

from larics.marker import PLAIN_ID_MOST
from larics_host.validation.scoring import Tally

FRESH_SEED = 9200
ROUNDS = 10
CODED, PLAIN, NONE = "coded", "plain", "no marker"


class Condition(NamedTuple):
    """Frames of one kind; their seed is the run's plus the condition's place in the list."""

    markers: str
    preset: str
    frames: int
    radius_px: float = 30.0
    overrides: tuple = ()  # of (name, value)

    @property
    def name(self):
        parts = [self.markers, self.preset]
        parts += ["R %g" % self.radius_px] if self.radius_px != 30.0 else []
        return " ".join(parts + ["%s %g" % pair for pair in self.overrides])


CONDITIONS = (
    Condition(CODED, "harsh", 5000),
    Condition(CODED, "sunny", 1500),
    Condition(CODED, "cloudy", 1500),
    Condition(CODED, "double", 1000),
    Condition(CODED, "fast", 1500),
    Condition(CODED, "sunny", 1500, 10.0),
    Condition(CODED, "sunny", 1500, 12.0),
    Condition(CODED, "sunny", 600, overrides=(("occlusion", 0.05),)),
    Condition(CODED, "sunny", 600, overrides=(("occlusion", 0.1),)),
    Condition(CODED, "sunny", 600, overrides=(("occlusion", 0.2),)),
    Condition(CODED, "cloudy", 300, 10.0),
    Condition(CODED, "cloudy", 300, 12.0),
    Condition(CODED, "sunny", 400, 20.0, (("defocus_px", 2.5),)),
    Condition(CODED, "sunny", 300, overrides=(("blur_px", 8.0),)),
    Condition(CODED, "glossy", 500),
    Condition(CODED, "webcam", 500),
    Condition(CODED, "dirty_lens", 500),
    Condition(CODED, "worn", 500),
    Condition(CODED, "multi", 500),  # of about three markers each
    Condition(CODED, "border", 500),
    Condition(PLAIN, "harsh", 1500),
    Condition(PLAIN, "sunny", 600),
    Condition(PLAIN, "cloudy", 600),
    Condition(PLAIN, "fast", 400),
    Condition(PLAIN, "sunny", 400, 10.0),
    Condition(PLAIN, "sunny", 200, 20.0, (("defocus_px", 2.5),)),
    Condition(PLAIN, "glossy", 150),
    Condition(PLAIN, "webcam", 150),
    Condition(PLAIN, "dirty_lens", 150),
    Condition(PLAIN, "worn", 150),
    Condition(PLAIN, "multi", 250),
    Condition(NONE, "negative", 5000),
    Condition(NONE, evaluate.PHOTOGRAPHS, 45000),
)


class Record:
    """What is counted of one condition beside its Tally: every ID that was told and is not the truth's."""

    def __init__(self):
        self.tally = Tally()
        self.crossed = []  # (key, true ID, ID told): a plain marker read as a coded one, or the other way
        self.told = []  # (key, ID told) of what belongs to no marker

    def add(self, job, detect):
        for index, (frame, truths) in enumerate(evaluate.block(job, methods.target(job.names[0]))):
            founds = detect(frame)
            key = (job.preset, job.seed, job.start + index)
            self.tally.add(truths, founds, key)
            known = {truth.marker_id for truth in truths}
            for found in founds:
                marker_id = found.marker_id
                if marker_id is None or marker_id in known:
                    continue
                if not truths:
                    self.told.append((key, marker_id))
                elif (marker_id > PLAIN_ID_MOST) != (min(known) > PLAIN_ID_MOST):
                    self.crossed.append((key, sorted(known), marker_id))


def jobs(condition, number, seed, share, cache):
    """The jobs of one condition, `share` of its frames."""
    names = ["larics_coded" if condition.markers == CODED else "larics"]
    count = max(1, round(condition.frames * share))
    return evaluate.jobs(
        condition.name, condition.preset, seed + number, count, condition.radius_px,
        dict(condition.overrides), names, cache,
    )  # fmt: skip


def table(records):
    """What has been counted so far, as text, and as an object for JSON."""
    lines = [report.heading("markers and preset")]
    rows = {}
    totals = {kind: {"markers": 0, "wrong": 0, "crossed": 0} for kind in (CODED, PLAIN)}
    frames = told = 0
    for condition, record in records:
        row = record.tally.row()
        lines.append(report.line(condition.name, row))
        rows[condition.name] = {
            **row, "wrong_frames": record.tally.wrongs, "false_frames": record.told, "crossed": record.crossed
        }  # fmt: skip
        if condition.markers == NONE:
            frames += row["frames"]
            told += len(record.told)
        else:
            total = totals[condition.markers]
            total["markers"] += record.tally.markers + record.tally.cut
            total["wrong"] += row["wrong"] + len(record.told)
            total["crossed"] += len(record.crossed)
    for kind, total in totals.items():
        lines.append(
            "%s: %d markers, %d wrong IDs, %d read as the other family"
            % (kind, total["markers"], total["wrong"], total["crossed"])
        )
    lines.append("without a marker: %d frames, %d IDs told" % (frames, told))
    return "\n".join(lines), {"conditions": rows, "totals": totals, "empty": {"frames": frames, "told": told}}


def arguments(words=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=FRESH_SEED, help="of the first condition")
    parser.add_argument("--share", type=float, default=1.0, help="of the frames of each condition")
    parser.add_argument("--only", default="", help="only conditions whose name has this in it")
    parser.add_argument("--cache", help="folder that keeps rendered frames between runs")
    parser.add_argument("--output", type=Path, default=Path("build/record"))
    options = parser.parse_args(words)
    if not 0 < options.share <= 1:
        parser.error("--share is above 0 and at most 1, not %g" % options.share)
    if not any(options.only in condition.name for condition in CONDITIONS):
        parser.error("no condition has %r in its name" % options.only)
    return options


def measure(options):
    """Runs the conditions chosen by rounds; returns what record.json has at the end."""
    chosen = [(i, c) for i, c in enumerate(CONDITIONS) if options.only in c.name]
    records = [(condition, Record()) for _, condition in chosen]
    todo = [jobs(condition, i, options.seed, options.share, options.cache) for i, condition in chosen]
    frames = sum(job.count for of_one in todo for job in of_one)
    done, shown, started = 0, 0, time.monotonic()
    options.output.mkdir(parents=True, exist_ok=True)
    for turn in range(ROUNDS):
        for (condition, record), of_one in zip(records, todo, strict=True):
            for job in of_one[len(of_one) * turn // ROUNDS : len(of_one) * (turn + 1) // ROUNDS]:
                record.add(job, evaluate.detector(job.names[0], job.radius_px, job.max_tilt_deg))
                done += job.count
                if sys.stderr.isatty():
                    print(
                        "\r%d of %d frames  %-40s" % (done, frames, condition.name), end="", file=sys.stderr
                    )
        if done == shown:
            continue
        shown = done
        text, found = table(records)
        found = {"seed": options.seed, "frames": done, **found}
        (options.output / "record.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        print("\n%d of %d frames, %.0f s\n%s" % (done, frames, time.monotonic() - started, text), flush=True)
    return found


if __name__ == "__main__":
    measure(arguments())
