"""The committed frames: complete, and what tools/make_frames.py makes."""

import sys
from pathlib import Path

import numpy as np

from larics_host.images.frame_sources import open_frames
from larics_host.truth import by_frame, read_truth

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "tests" / "frames"
sys.path.insert(0, str(ROOT / "tools"))


def test_every_frame_has_truth_and_the_other_way_round():
    truths = by_frame(read_truth(FOLDER))
    files = {path.name: path for path in FOLDER.glob("*.pgm")}
    assert set(truths) == set(files)
    assert sum(path.stat().st_size for path in files.values()) < 4e6
    markers = [truth for found in truths.values() for truth in found]
    assert {truth.id for truth in markers} == set(range(8))
    assert {name.split("_")[0] for name in files} == {
        *("sunny", "cloudy", "double", "fast", "harsh", "multi", "border", "negative")
    }
    assert all(not found for name, found in truths.items() if name.startswith("negative"))
    assert {1000 <= int(name.split("_")[2]) < 2000 for name in files} == {True}


def test_the_tool_makes_the_committed_frames():
    import make_frames

    committed = by_frame(read_truth(FOLDER))
    # the small ones are quick; every fourth of them is enough to notice a change of the renderer
    small = [batch for batch in make_frames.BATCHES if batch.width <= 160][::4]
    for name, frame, truths in make_frames.frames(small):
        ((_, stored),) = open_frames([FOLDER / name])
        # another processor's mathematics may turn a rounding here and there
        assert np.abs(stored.astype(int) - frame).max() <= 4
        assert np.mean(stored != frame) < 0.01
        for truth, other in zip([t for t in truths if t.id is not None], committed[name], strict=True):
            assert (truth.id, truth.time_us) == (other.id, other.time_us)
            assert np.hypot(truth.x_px - other.x_px, truth.y_px - other.y_px) < 1e-4
            assert abs(truth.heading_deg - other.heading_deg) < 1e-4
