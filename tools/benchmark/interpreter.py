"""Cost of a frame on a MicroPython interpreter: time, or executed instructions on a counting emulator.

Contract of a counting emulator: it takes a script and its arguments like MicroPython's unix binary, reads
the host's files, honours MICROPYPATH, and its time.ticks_us counts thousands of executed instructions.
MicroPython's QEMU port under `-icount shift=0` does (an instruction is a virtual nanosecond). It is
recognised by its platform name and by a loop of known length.
"""

import os
import shlex
import subprocess
from pathlib import Path

import numpy as np

from . import frames, tracking

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = Path(__file__).with_name("on_interpreter.py")
_TURNS = 10000
_LOOP_INSTRUCTIONS = (9, 13)  # a turn of viper's `while i < n: i += 1` on Thumb takes 11


def write_frames(folder, scene, seed, count):
    """Draws `count` frames of a plan.Scene as raw files; returns their paths and truths."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths, truths = [], []
    overrides = "".join("-%s-%g" % override for override in scene.overrides)
    for index in range(count):
        preset = scene.presets[index % len(scene.presets)]
        frame, seen = frames.render(preset, seed, index, "larics", scene.radius_px, dict(scene.overrides))
        paths.append(folder / ("%s-r%g%s-%03d.raw" % (preset, scene.radius_px, overrides, index)))
        paths[-1].write_bytes(frame.tobytes())
        truths.append(seen)
    return paths, truths


def with_predictions(paths, truths, seed):
    """Arguments that let on_interpreter.py track the first marker of each frame that has one."""
    random = np.random.default_rng(seed)
    return [
        "%s@%d,%d,%d" % (path, *tracking.prediction(seen[0], random))
        for path, seen in zip(paths, truths, strict=True)
        if seen
    ]


def parse(text):
    """What on_interpreter.py printed, as a dictionary.

    platform, loop and memory as printed, frames [(ticks, found, ID, blur-model reader asked)],
    kernels {name: (ticks, calls)}."""
    result = {"frames": [], "kernels": {}}
    for line in text.splitlines():
        key, *words = line.split()
        if key == "frame":
            number = None if words[2] == "-" else int(words[2])
            result["frames"].append((int(words[0]), int(words[1]), number, words[3] == "1"))
        elif key == "kernel":
            result["kernels"][words[2]] = (int(words[0]), int(words[1]))
        elif key == "loop":
            result["loop"] = [int(word) for word in words]
        elif key == "memory":
            result["memory"] = int(words[0])
        elif key == "platform":
            result["platform"] = words[0]
    return result


def counts_instructions(result):
    """Whether ticks were thousands of instructions and not microseconds."""
    return result["platform"] == "qemu" and all(
        _LOOP_INSTRUCTIONS[0] <= ticks * 1000 / _TURNS <= _LOOP_INSTRUCTIONS[1] for ticks in result["loop"]
    )


def command(text):
    """$MICROPYTHON as a command line: a path, from the repository's root when relative, and arguments."""
    words = shlex.split(text)
    if words and (ROOT / words[0]).is_file():
        words[0] = str(ROOT / words[0])
    return words


class InterpreterError(Exception):
    """The interpreter cannot be run, or failed: one line that says why."""


def _run(interpreter, *words):
    """Standard output of on_interpreter.py."""
    try:
        done = subprocess.run(
            [*interpreter, str(SCRIPT), *[str(word) for word in words]],
            cwd=ROOT,
            env=dict(os.environ, MICROPYPATH="shared:.frozen"),
            capture_output=True,
            text=True,
            timeout=1800,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InterpreterError("cannot run MICROPYTHON: %s" % error) from None
    if done.returncode:
        lines = (done.stdout + done.stderr).strip().splitlines() or ["no output"]
        raise InterpreterError("%s failed: %s" % (" ".join(interpreter), lines[-1]))
    return done.stdout


def measure(interpreter, words, method, radius_range, max_tilt_deg=0):
    """Runs a method over raw frames (`words`: paths, or with_predictions()); returns a summary.

    mean, median, max and each frame's are milliseconds, or million instructions when `unit` says so; kernels
    holds for each viper function the same unit and the number of calls, both a frame. Raises
    InterpreterError."""
    size = frames.WIDTH, frames.HEIGHT
    result = parse(_run(interpreter, method, *radius_range, max_tilt_deg, *size, *words))
    cost = np.array([ticks for ticks, *_ in result["frames"]]) / 1000.0
    return {
        "unit": "Minsn" if counts_instructions(result) else "ms",
        "frames": len(cost),
        "mean": float(cost.mean()),
        "median": float(np.median(cost)),
        "max": float(cost.max()),
        "memory": result.get("memory"),
        "found": sum(found > 0 for _, found, *_ in result["frames"]),
        "kernels": {
            name: (ticks / 1000 / len(cost), calls / len(cost))
            for name, (ticks, calls) in sorted(result["kernels"].items(), key=lambda item: -item[1][0])
        },
        "each": cost.tolist(),
        "ids": [number for _, _, number, _ in result["frames"]],
        "asked": [asked for *_, asked in result["frames"]],
    }
