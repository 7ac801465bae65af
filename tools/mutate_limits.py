"""Doubles and halves each limit, one at a time, and tells which changes no test notices.

    python tools/mutate_limits.py                  all of them (some minutes)
    python tools/mutate_limits.py rules localizer  those of modules whose path holds one of the words

A limit is a constant of one of the modules below, or a scale in a call of `_rule`. Each change is made on a
copy of the tree, and the tests named beside the module run on it, interpreted; before them the oracles of a
kernel. Exits with 1 when a change survives. What is no limit (sizes of buffers, names of states, items of
arrays) is left out by name. Not tried are numbers that are held against another program: those of MAVLink
against pymavlink, those of larics_vehicle against its C twin.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tools.check_rules import layouts_of  # noqa: E402

LOCATE = ("test_locate_limits", "test_motion_limits", "test_pose", "test_navigator", "test_route")
CARRIED = (
    "test_odometry_limits",
    "test_vehicle_clock_limits",
    "test_shares_limits",
    "test_wheel_noise_limits",
    "test_carried_limits",
    "test_odometry",
    "test_carried_pose",
    *LOCATE,
    "test_camera",
    "test_uncertainty",
)
WIRE = ("test_protocol", "test_golden_wire", "test_encodings", "test_outbox")
READ = ("test_direct_acceptance", "test_code_acceptance")
FIT = (
    "test_evidence",
    "test_ring_limits",
    "test_direct_passes",
    "test_direct_lines",
    "test_direct_turn",
    "test_sigma_limits",
    "test_detector",
)
SEARCH = ("test_search_limits", "test_blurred_search", "test_detector")
CELLS = ("test_cell_reader", "test_cell_strokes", "test_cell_weights", "test_cell_words", "test_cells")
BLURRED = (
    "test_blur_model_limits",
    "test_blurred_fits",
    "test_blurred_candidates",
    "test_blurred_sigma",
    "test_blurred_acceptance",
    "test_model",
)
TARGETS = {  # module -> tests of tests/dual, or a path
    "shared/larics/kernels/rules.py": READ,
    "shared/larics/kernels/code.py": ("test_direct_lines", *READ),
    "shared/larics/kernels/code_rules.py": ("test_code_acceptance",),
    "shared/larics/direct/acceptance.py": ("test_evidence", *READ),
    "shared/larics/direct/evidence.py": ("test_evidence",),
    "shared/larics/kernels/evidence.py": ("test_evidence",),
    "shared/larics/blurred/acceptance.py": ("test_blurred_acceptance",),
    "shared/larics/blurred/reader.py": ("test_blurred_acceptance", "test_blurred_fits"),
    "shared/larics/blurred/candidates.py": ("test_blurred_candidates", "test_model"),
    "shared/larics/blurred/places.py": ("test_blurred_candidates",),
    "shared/larics/detect/blurred_search.py": ("test_blurred_search",),
    "shared/larics/direct/reader.py": FIT,
    "shared/larics/direct/ring_fit.py": FIT,
    "shared/larics/direct/line_reader.py": FIT,
    "shared/larics/kernels/harmonics.py": FIT,
    "shared/larics/kernels/lines.py": FIT,
    "shared/larics/kernels/coarse.py": FIT,
    "shared/larics/locate/localizer.py": LOCATE,
    "shared/larics/locate/navigator.py": LOCATE,
    "shared/larics/locate/noise.py": LOCATE,
    "shared/larics/locate/motion.py": LOCATE,
    "shared/larics/locate/route.py": LOCATE,
    **dict.fromkeys(
        (
            "shared/larics/locate/%s.py" % name
            for name in (
                "camera_model",
                "carrier",
                "coasting",
                "matching",
                "odometry",
                "odometry_shares",
                "uncertainty",
                "vehicle_clock",
                "wheel_noise",
            )
        ),
        CARRIED,
    ),
    "shared/larics/kernels/odometry.py": CARRIED,
    "shared/larics/kernels/covariance.py": CARRIED,
    "shared/larics/kernels/shares.py": CARRIED,
    "shared/larics/kernels/stream.py": WIRE,
    "shared/larics/wire/codec.py": WIRE,
    "shared/larics/wire/framing.py": WIRE,
    "shared/larics/wire/nmea.py": ("test_encodings",),
    "shared/larics/coded/cell_reader.py": CELLS,
    "shared/larics/kernels/cells.py": CELLS,
    "shared/larics/kernels/cell_search.py": CELLS,
    "shared/larics/kernels/cell_strokes.py": CELLS,
    "shared/larics/kernels/cell_words.py": CELLS,
    "shared/larics/kernels/robust.py": FIT,
    "shared/larics/direct/robust_centre.py": ("test_ring_limits", "tests/host/test_robust_centre.py"),
    "shared/larics/direct/uncertainty.py": ("test_sigma_limits", "test_ring_limits"),
    "shared/larics/detect/edges.py": SEARCH,
    "shared/larics/detect/centre_votes.py": SEARCH,
    "shared/larics/detect/scales.py": SEARCH,
    "shared/larics/blurred/ring_fit.py": BLURRED,
    "shared/larics/blurred/line_fit.py": ("test_line_fit_limits", *BLURRED),
    "shared/larics/blurred/blur_model.py": BLURRED,
    "shared/larics/blurred/uncertainty.py": ("test_sigma_limits", "test_blurred_sigma"),
    "shared/larics/device/commands.py": ("test_commands", "test_firmware_link"),
    "shared/larics/device/frame_check.py": ("test_frame_check",),
    "shared/larics/device/outbox.py": ("test_outbox",),
    "shared/larics/device/raw_frame.py": ("test_commands", "test_outbox"),
    "shared/larics/device/tracking.py": ("test_outbox",),
    "shared/larics/settings/constraints.py": ("test_settings",),
    "shared/larics/detect/tracker.py": ("test_tracker",),
    "shared/larics/detect/confirmation.py": ("test_search_limits",),
}
# changes other than of a constant: (module, text, replacement, tests)
OTHERS = (
    (
        "shared/larics/wire/layouts.py",
        "254, 255, 35999, 36000",
        "254, 127, 35999, 36000",
        ("test_golden_wire",),
    ),
    (
        "shared/larics/locate/localizer.py",
        "if passed_us > self.coast_us:\n                self._lose()",
        "if False:\n                self._lose()",
        LOCATE,
    ),
)
NO_LIMITS = {
    # geometry
    "_INNER_SAMPLES", "_INNER_REACH", "_SAMPLES", "_CODE_OPENING", "_CODE_RADII", "_CELL_UNITS_Q8", "_BESIDE",
    "BIAS", "MAX_MARKERS", "SECTORS", "SKIP_OUTER", "SKIP_INNER", "POSITIONS", "_RULES", "_IN_DOUBT",
    "_DISTANCES", "_HYPOTHESES", "_ITEMS", "_CAPACITY", "X_Q8", "Y_Q8", "LEAST_Q8", "MOST_Q8", "LOOKED",
    "VERDICT", "SCORE", "X_Q10", "Y_Q10", "RADIUS_Q8", "E1", "E2", "SAME", "ON_ROUTE", "AMBIGUOUS", "MISSED",
    "UNEXPECTED", "MISREAD", "MOVED", "_NONE", "_MOST", "SCRATCH", "WEIGHTS", "GAPS", "MAX_FRAME",
    "_OTHER_VERSION", "_DIFFERS", "_TIME_US", "REJECTED", "LOST_IN_NOISE", "LOST_ON_THE_WAY", "_ALL_IN_DOUBT",
    "NO_BUDGET", "LEAST_WORDS",
}  # fmt: skip
NOT_TRIED = {
    ("blurred/places", "_FORGOTTEN"),
    ("kernels/cells", "_USUAL"),
}  # a mark; a short cut that costs less
ONLY_HALVED = {  # (module, name): what is larger takes memory alone, or is out of reach
    ("wire/nmea", "LONGEST"), ("locate/coasting", "_MOST_MM10_S2"), ("locate/odometry_shares", "_BELIEF"),
    ("locate/vehicle_clock", "_LEAP_US"),
}  # fmt: skip
CONSTANT = re.compile(r"^(_?[A-Z][A-Z0-9_]*) = const\((?:_?BIAS [+-] )?(-?\d+)\)", re.MULTILINE)
GENERATED = re.compile(r"# generated: begin.*?# generated: end", re.DOTALL)
SCALE = re.compile(r"_rule\(.*, (\d+)\)")
PARTS = ("shared", "firmware", "tests/dual", "tests/kernels")
HOST = ("host", "tests/host")
RUN = """
import copy, importlib, sys

def hold_against_oracles(module):
    from inputs import Random
    from oracles import ORACLES
    cases = importlib.import_module("cases_" + module).CASES
    for name in [name for name in cases if module + "." + name in ORACLES]:
        kernel = getattr(importlib.import_module("larics.kernels." + module), name)
        for arguments in cases[name](Random(777)):
            before = tuple(copy.copy(argument) for argument in arguments)
            ORACLES[module + "." + name](before, arguments, kernel(*arguments))

for name in sys.argv[1:]:
    if name.startswith("oracles of "):
        hold_against_oracles(name[11:])
        continue
    module = importlib.import_module(name)
    for test in dir(module):
        if test.startswith("test_"):
            getattr(module, test)()
"""


def changes_of(module, text, layouts):
    """(what, first character, last, replacement) of every limit in a module, doubled and halved."""
    only_halved = {name for path, name in ONLY_HALVED if module.endswith(path + ".py")}
    made = [match.span() for match in GENERATED.finditer(text)]  # indices that another tool writes and checks
    places = [
        (match[1], match.span(2))
        for match in CONSTANT.finditer(text)
        if not any(first < match.start() < last for first, last in made)
    ]
    left_out = NO_LIMITS | {name for path, name in NOT_TRIED if module.endswith(path + ".py")}
    places = [place for place in places if place[0] not in left_out and place[0].lstrip("_") not in layouts]
    for match in SCALE.finditer(text):
        places.append(("scale in line %d" % (text.count("\n", 0, match.start()) + 1), match.span(1)))
    for what, (first, last) in places:
        value = int(text[first:last])
        halved = value // 2 if value >= 0 else -(-value // 2)
        for other in sorted({halved if what in only_halved else value * 2 or 1, halved} - {value}):
            yield "%s: %d instead of %d" % (what, other, value), first, last, str(other)


def mutants(words):
    """(module, what, text, tests) of every change asked for."""
    layouts = layouts_of(ROOT)
    for module, tests in TARGETS.items():
        text = (ROOT / module).read_text()
        if "/kernels/" in module:
            tests = ("oracles of " + pathlib.Path(module).stem, *tests)
        for what, first, last, replacement in changes_of(module, text, layouts):
            yield module, what, text[:first] + replacement + text[last:], tests
    for module, part, replacement, tests in OTHERS:
        text = (ROOT / module).read_text()
        if text.count(part) != 1:
            sys.exit("mutate_limits: %s does not hold %r once: adapt OTHERS" % (module, part))
        yield module, "%r instead of %r" % (replacement, part), text.replace(part, replacement), tests


def passes(copy, tests):
    """Whether the tests pass on a copy of the tree: those of tests/dual by name, of tests/host by path."""
    found = [name for name in tests if "/" not in name]
    paths = [name for name in tests if "/" in name]
    environment = dict(
        os.environ,
        LARICS_KERNELS="plain",
        PYTHONDONTWRITEBYTECODE="1",
        PYTHONPATH=os.pathsep.join(str(copy / part) for part in (*PARTS, *HOST)),
    )
    commands = [[sys.executable, "-c", RUN, *found]] if found else []
    if paths:
        commands.append([sys.executable, "-m", "pytest", "-qx", "-p", "no:cacheprovider", *paths])
    for command in commands:
        try:
            done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, timeout=300)
        except subprocess.TimeoutExpired:
            return False
        if done.returncode:
            return False
    return True


def main(words):
    chosen = [one for one in mutants(words) if not words or any(word in one[0] for word in words)]
    if not chosen:
        print("mutate_limits: no module's path holds %s" % " or ".join(words), file=sys.stderr)
        return 2
    survivors = []
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder)
        for part in (*PARTS, *HOST):
            shutil.copytree(ROOT / part, copy / part, ignore=shutil.ignore_patterns("__pycache__"))
        for tests in sorted({one[3] for one in chosen}):
            if not passes(copy, tests):
                print("mutate_limits: %s fail on the tree as it is" % " ".join(tests), file=sys.stderr)
                return 2
        for number, (module, what, text, tests) in enumerate(chosen):
            before = (copy / module).read_text()
            (copy / module).write_text(text)
            if passes(copy, tests):
                survivors.append("%s %s" % (module, what))
                print("survives: %s" % survivors[-1], flush=True)
            (copy / module).write_text(before)
            if (number + 1) % 25 == 0:
                print("%d of %d, %d survive" % (number + 1, len(chosen), len(survivors)), flush=True)
    print("%d changes, %d survive" % (len(chosen), len(survivors)))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
