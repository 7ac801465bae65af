"""Renders the committed frames with truth: tests/frames.

    python tools/make_frames.py            write them again
    python tools/make_frames.py DIR        write them elsewhere, to compare

Rendering is exact in (preset, seed, index) on one machine; on another processor a few pixels may differ by a
grey level, since its mathematical library and OpenCV's vector code round differently. So the frames are
committed, and nothing that tests compare byte for byte is rendered afresh.
"""

import argparse
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics_host.images.stills import encode_pgm  # noqa: E402
from larics_host.render import render_frame  # noqa: E402
from larics_host.truth import write_truth  # noqa: E402


@dataclass(frozen=True)
class Batch:
    """`count` frames of one preset, size and ring radius."""

    preset: str
    seed: int
    count: int
    width: int = 360
    height: int = 296
    radius_px: int = 30
    overrides: dict = field(default_factory=dict)


def _each_id():
    """One small frame for each ID, the unused 0 included."""
    return [Batch("sunny", 1100 + i, 1, 160, 120, 16, {"marker_ids": [i]}) for i in range(8)]


BATCHES = [
    Batch("sunny", 1000, 3),
    Batch("cloudy", 1001, 3),
    Batch("double", 1002, 1),
    Batch("fast", 1003, 2),
    Batch("harsh", 1004, 4),
    Batch("multi", 1005, 2),
    Batch("border", 1006, 2),
    Batch("negative", 1007, 3),
    Batch("sunny", 1010, 2, 160, 120, 10),
    Batch("cloudy", 1011, 1, 160, 120, 10),
    Batch("multi", 1012, 2, 160, 120, 12),
    Batch("cloudy", 1013, 3, 160, 120, 15),
    Batch("double", 1014, 1, 160, 120, 15),
    Batch("fast", 1015, 2, 160, 120, 15),
    Batch("harsh", 1016, 3, 160, 120, 15),
    Batch("border", 1017, 2, 160, 120, 15),
    Batch("negative", 1018, 4, 160, 120, 15),
    Batch("sunny", 1019, 2, 80, 60, 10),
    Batch("sunny", 1020, 1, 240, 180, 20),
    Batch("cloudy", 1021, 1, 240, 180, 20),
    Batch("negative", 1022, 1, 240, 180, 20),
    Batch("sunny", 1023, 1, 320, 240, 60),
    Batch("cloudy", 1024, 1, 320, 240, 45),
    *_each_id(),
]


def frames(batches):
    """Yields (name, frame, truths) of all of them, in order."""
    for batch in batches:
        for index in range(batch.count):
            frame, truths = render_frame(
                batch.preset,
                batch.seed,
                index,
                width=batch.width,
                height=batch.height,
                radius_px=batch.radius_px,
                **batch.overrides,
            )
            name = "%s_r%02d_%d_%d.pgm" % (batch.preset, batch.radius_px, batch.seed, index)
            for truth in truths:
                truth.frame = name
            yield name, frame, truths


def main():
    """Writes the frames and truth.csv; removes frames that are no longer made."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", metavar="FOLDER", type=Path, nargs="?", default=ROOT / "tests" / "frames")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.pgm"):
        old.unlink()
    records, size = [], 0
    for name, frame, truths in frames(BATCHES):
        size += (folder / name).write_bytes(encode_pgm(frame))
        records += truths
    write_truth(folder / "truth.csv", records)
    print("%d frames, %.1f MB in %s" % (len({truth.frame for truth in records}), size / 1e6, folder))


if __name__ == "__main__":
    main()
