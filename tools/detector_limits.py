"""The limits that docs/detector.md explains: their values, and what frames show of the direct reader's rules.

    python -m tools.detector_limits                 writes the values into the page's tables
    python -m tools.detector_limits --measure 500   prints how the rules part markers from what is none

A table below a heading with a module's path has a row for each of its limits; a test compares the names and
values with the module.
"""

import argparse
import re
import sys
from pathlib import Path

import numpy as np

from larics.detect.detector import Detector
from larics.kernels import layouts
from larics_host.render import render_frame
from tools.detector_figures import RULES

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "detector.md"
CONSTANT = re.compile(r"^(_?[A-Z][A-Z0-9_]*) = (?:const\()?(-?\d+)\)?", re.M)
ROW = re.compile(r"^\| `(\w+)` \| *([^|]*?) *\|", re.M)
SECTION = re.compile(r"^#+ .*`(shared/larics/[\w/]+\.py)`.*$", re.M)
# constants that are no limits: names of items, sizes of buffers, numbers that stand for words
NO_LIMITS = {
    "shared/larics/detect/edges.py": {"DIRECTIONS"},
    "shared/larics/detect/centre_votes.py": {"LEAST_WORDS", "_CHUNK", "_MASK_BITS"},
    "shared/larics/direct/ring_fit.py": {"SECTORS", "SKIP_OUTER", "SKIP_INNER"},
    "shared/larics/direct/line_reader.py": {"POSITIONS"},
    "shared/larics/direct/robust_centre.py": {"_ROBUST_PARAMETERS", "_ROBUST_SCALE", "_ROBUST_SQUARE"},
    "shared/larics/direct/evidence.py": {"_ITEMS", "_ITEM_SHALLOWER", "_LEAST"},
    "shared/larics/kernels/evidence.py": {"_OFFSET", "_ZERO", "_DEPTH_MOST", "_PAIR_ITEMS"},
    "shared/larics/direct/acceptance.py": {"_RULES", "_IN_DOUBT", "_ALL_IN_DOUBT"},
    "shared/larics/coded/cell_reader.py": {"PLAIN", "UNKNOWN", "_NEVER"},
    "shared/larics/detect/detector.py": {"_FAMILY_MM10"},
    "shared/larics/blurred/candidates.py": {
        *("_ITEMS", "_KIND", "X_Q8", "Y_Q8", "LEAST_Q8", "MOST_Q8", "VERDICT", "LOOKED", "SCORE", "X_Q10"),
        *("Y_Q10", "RADIUS_Q8", "E1", "E2"),
    },
    "shared/larics/blurred/places.py": {
        *("UNKNOWN", "READ", "REJECTED", "_ITEMS", "_X_Q8", "_Y_Q8", "_RADIUS_Q8", "_AGE", "_KIND"),
        "_FORGOTTEN",
    },
}
PRESETS = ("sunny", "cloudy", "harsh")
SEED = 5400


def limits(path):
    """{name: value} of the limits of a module."""
    shared = {name for name in vars(layouts) if name.isupper()}
    found = {}
    for name, value in CONSTANT.findall((ROOT / path).read_text()):
        if name.lstrip("_") not in shared and name not in NO_LIMITS.get(path, ()):
            found[name] = int(value)
    return found


def sections(text):
    """(path, text of the section) of each part of the page that explains a module's limits."""
    parts = SECTION.split(text)
    for path, body in zip(parts[1::2], parts[2::2], strict=True):
        yield path, re.split(r"^#", body, maxsplit=1, flags=re.M)[0]


def with_values(text):
    """The page with the values that the modules have now."""
    for path, body in sections(text):
        values = limits(path)
        fresh = ROW.sub(lambda row, known=values: "| `%s` | %s |" % (row[1], known.get(row[1], row[2])), body)
        text = text.replace(body, fresh)
    return text


class Recorder:
    """In place of Acceptance._hold: notes each rule's distance, and where the candidate is."""

    def __init__(self, direct):
        self._acceptance = direct.acceptance
        self._hold = direct.acceptance._hold
        self._direct = direct
        self.notes = []

    def __call__(self, count):
        rules = self._acceptance._rules
        shares = [(rules[2 * k] - layouts.BIAS) * 255 // rules[2 * k + 1] for k in range(count)]
        rings = self._direct.rings
        self.notes.append((count, rings.true_x_q10 / 1024, rings.true_y_q10 / 1024, shares))
        return self._hold(count)


def measure(frames):
    """{rule: ([margins of markers], [margins of what is none])} over rendered frames."""
    found = {name: ([], []) for names in RULES for name in names}
    names_of = {len(names): names for names in RULES}
    for preset in (*PRESETS, "negative"):
        detector = Detector(360, 296, 25, 36, second_opinion=False)
        recorder = detector.direct.acceptance._hold = Recorder(detector.direct)
        for index in range(frames):
            family = {} if preset == "negative" else {"family": "mixed"}
            frame, truths = render_frame(preset, SEED, index, **family)
            recorder.notes.clear()
            detector.detect(frame)
            there = [(t.x_px, t.y_px) for t in truths if t.id is not None]
            for count, x, y, shares in recorder.notes:
                is_marker = any(np.hypot(x - mx, y - my) < 2 for mx, my in there)
                for name, share in zip(names_of[count], shares, strict=True):
                    found[name][0 if is_marker else 1].append(share)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--measure", type=int, metavar="N", help="frames of each preset to measure on")
    args = parser.parse_args()
    if args.measure:
        print("| Rule | markers | weakest 1 % | median | refused | others | refused |")
        print("|---|---|---|---|---|---|---|")
        for name, (markers, others) in measure(args.measure).items():
            refused = ["%.1f %%" % (100 * np.mean(np.array(v) < 0)) if v else "-" for v in (markers, others)]
            low, middle = np.percentile(np.clip(markers, -1, 255), (1, 50))
            print(
                "| %s | %d | %d | %d | %s | %d | %s |"
                % (name, len(markers), low, middle, refused[0], len(others), refused[1])
            )
        return 0
    PAGE.write_text(with_values(PAGE.read_text()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
