"""`python -m tools.demo`: the whole way once; see the package."""

import argparse
import json
import os
import shlex
import subprocess
import sys
import time
from pathlib import Path

from larics_host.connection.pty_pair import PtyPair
from tools.demo import compare, drive

ROOT = Path(__file__).resolve().parents[2]
ROWS = 24


def say(text):
    print(text, flush=True)


def render(folder):
    start_s = time.monotonic()

    def progress(done, total):
        if done % 60 == 0 or done == total:
            say("  %d of %d frames" % (done, total))

    say("1. A drive under %d markers: %d frames" % (len(drive.MARKERS), drive.frame_count()))
    truths, fresh = drive.prepare(folder, progress)
    if fresh:
        say("  rendered in %.0f s" % (time.monotonic() - start_s))
    else:
        say("  already in %s, used again" % (folder / "frames").relative_to(ROOT))
    return truths


def run_camera(folder, method):
    """The firmware and `larics log` on both ends of a serial cable; returns the log's JSON lines file."""
    micropython = shlex.split(os.environ.get("MICROPYTHON", "")) or [str(ROOT / ".venv/bin/micropython")]
    settings = folder / "settings.json"
    settings.write_text(json.dumps(dict(drive.settings(), method=method), indent=1))
    options = ["--frames", folder / "frames", "--fps", str(drive.FPS), "--settings", settings]
    run = folder / "run"
    with PtyPair() as cable:
        ends = cable.device_a, cable.device_b
        say("2. Firmware on MicroPython -> %s -> cable -> %s -> larics log" % ends)
        log = subprocess.Popen(
            [sys.executable, "-m", "larics_host", "log", "--port", cable.device_b, "-o", run, "--force"],
            env=dict(os.environ, PYTHONPATH="shared:host"),
            cwd=ROOT,
        )
        run.with_suffix(".csv").unlink(missing_ok=True)
        wait_until(lambda: run.with_suffix(".csv").exists(), log)
        firmware = subprocess.run(
            [*micropython, "firmware/pc/replay_main.py", *options, "--port", cable.device_a],
            env=dict(os.environ, MICROPYPATH="shared:firmware:.frozen"),
            cwd=ROOT,
            timeout=600,
        )
        wait_until(lambda: firmware.returncode or has_all(run.with_suffix(".jsonl")), log)
        log.terminate()
        log.wait(timeout=60)
    if firmware.returncode or log.returncode:
        codes = firmware.returncode, log.returncode
        raise SystemExit("demo: the firmware ended with %d, the log with %d" % codes)
    return run.with_suffix(".jsonl")


def wait_until(condition, process, limit_s=60):
    end_s = time.monotonic() + limit_s
    while not condition():
        if process.poll() is not None or time.monotonic() > end_s:
            raise SystemExit("demo: larics log ended or does not go on")
        time.sleep(0.02)


def has_all(path):
    """Whether the log has come to the firmware's last message, a STATUS."""
    whole = path.read_text().rpartition("\n")[0].splitlines()
    last = json.loads(whole[-1]) if whole else {}
    return last.get("frames", 0) + last.get("missed", 0) == drive.frame_count()


def print_table(frames):
    say("3. What the vehicle got (%d of %d frames shown; x forward, y left)" % (ROWS, len(frames)))
    heads = ("frame", "time s", "ID", "x mm", "y mm", "heading", "margin", "true x", "true y", "true heading")
    say(("%6s %7s %4s %9s %9s %9s %7s  |%9s %9s %13s") % heads)
    for k in range(ROWS):
        frame = frames[k * (len(frames) - 1) // (ROWS - 1)]
        for record in frame.markers or [None]:
            say(_row(frame, record))


def _row(frame, record):
    text = "%6d %7.2f " % (frame.index, frame.time_s)
    truth = frame.truths[0] if frame.truths else None
    if record is None:
        text += "%4s %9s %9s %9s %7s  |" % ((_without_marker(frame),) * 5)
    else:
        name = "?" if record["id"] is None else str(record["id"])
        values = name, record["x_mm10"] / 10, record["y_mm10"] / 10, record["heading_cdeg"] / 100
        text += "%4s %9.1f %9.1f %9.2f %7d  |" % (*values, record["margin"])
        truth = compare.match(record, frame) or truth
    if truth is None:
        return text + "%9s %9s %13s" % ("-", "-", "-")
    heading = (truth.marker_heading_deg - frame.vehicle[2]) % 360
    return text + "%9.1f %9.1f %13.2f" % (truth.offset_x_mm, truth.offset_y_mm, heading)


def _without_marker(frame):
    if frame.reported:
        return "-"
    return "lost" if frame.lost else "late"


def print_summary(total, statuses, bytes_sent):
    say("4. Against the truth")
    say("  frames reported           %d of %d" % (total.reported, total.frames))
    if total.not_taken:
        text = "  late                      %d: this machine was too slow to take them at %d frames/s"
        say(text % (total.not_taken, drive.FPS))
    if total.frames > total.reported + total.not_taken:
        say("  lost on the line          %d" % (total.frames - total.reported - total.not_taken))
    rate = 100 * total.found / max(1, total.whole)
    say("  whole markers identified  %d of %d (%.1f %%)" % (total.found, total.whole, rate))
    say("  wrong IDs                 %d, reported where nothing is: %d" % (total.wrong, total.spurious))
    for name, values, unit in (
        ("offset error", total.offsets_mm, "mm"),
        ("heading error", total.headings_deg, "deg"),
        ("position error in the map", total.positions_mm, "mm"),
    ):
        say("  %-25s median %.2f %s, 95 %% below %.2f %s" % (name, *join(compare.spread(values), unit)))
    needed = ("rate_chz", "detect_us", "latency_us")
    busy = [status for status in statuses if all(status[name] for name in needed)][1:]
    if busy:
        middle = sorted(busy, key=lambda status: status["detect_us"])[len(busy) // 2]
        say(
            "  on this machine           %.1f frames/s, detection %.1f ms, latency %.1f ms, faults %d"
            % (
                middle["rate_chz"] / 100,
                middle["detect_us"] / 1000,
                max(status["latency_us"] for status in busy) / 1000,
                busy[-1]["faults"],
            )
        )
    share = 1000 * bytes_sent / (total.frames / drive.FPS) / 115200
    each = bytes_sent / total.frames
    say("  line                      %.0f bytes/frame, %.0f %% of 115200 baud" % (each, share))


def join(pair, unit):
    return pair[0], unit, pair[1], unit


def main():
    parser = argparse.ArgumentParser(prog="make demo", description=__doc__)
    parser.add_argument("--method", choices=("larics", "paper"), default="larics")
    parser.add_argument("--docs", action="store_true", help="also write docs/demo.png, the README's picture")
    args = parser.parse_args()
    from tools.demo import picture

    folder = ROOT / "build" / "demo"
    folder.mkdir(parents=True, exist_ok=True)
    start_s = time.monotonic()
    truths = render(folder)
    log = run_camera(folder, args.method)
    frames, statuses = compare.read_run(log, truths)
    total = compare.score(frames)
    print_table(frames)
    print_summary(total, statuses, compare.line_bytes(log))
    drawn = folder / "demo.png"
    picture.draw(frames, folder / "frames", total, drawn)
    say("5. Done in %.0f s. Files in %s:" % (time.monotonic() - start_s, folder.relative_to(ROOT)))
    for name, what in (
        ("demo.png", "the picture"),
        ("run.csv", "every reported marker"),
        ("run.jsonl", "every message"),
        ("frames/", "what the camera saw, with truth.csv"),
        ("settings.json", "what the firmware was told"),
    ):
        say("  %-14s %s" % (name, what))
    if args.docs:
        (ROOT / "docs").mkdir(exist_ok=True)
        picture.reduce(drawn, ROOT / "docs" / "demo.png")
        say("  docs/demo.png written")


if __name__ == "__main__":
    main()
