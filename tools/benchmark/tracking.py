"""Tracking against searching: the same frame, once searched, once tracked from a wrong prediction."""

import numpy as np

from larics.marker import detection
from larics_host.detection.options import DetectionOptions
from larics_host.validation.scoring import heading_error

from . import frames, methods

PREDICTION_ERROR_PX = 6.0  # what a vehicle that brakes or turns may add to constant motion in one frame


def prediction(truth, random):
    """(x_q8, y_q8, radius_q8) of a marker, wrong by up to PREDICTION_ERROR_PX and 5 % of the radius."""
    angle = random.uniform(0, 2 * np.pi)
    error = random.uniform(0, PREDICTION_ERROR_PX)
    x, y = truth.x_px + error * np.cos(angle), truth.y_px + error * np.sin(angle)
    return round(256 * x), round(256 * y), round(256 * truth.radius_px * random.uniform(0.95, 1.05))


def compare(preset, seed, count, radius_px, on_done=lambda count: None):
    """Over frames whose marker a search finds: how many are tracked, and how far results differ.

    Returns frames, tracked_pct, other_id (different ID, or only one of the two is certain), and the median
    and the largest difference of centre (px) and heading (deg) among those tracked."""
    options = DetectionOptions(radius_px=methods.radius_range(radius_px))
    detector = options.make(frames.WIDTH, frames.HEIGHT)
    random = np.random.default_rng(seed)
    found = tracked = other_id = 0
    centre, heading = [], []
    for index in range(count):
        frame, truths = frames.render(preset, seed, index, "larics", radius_px, {})
        on_done(1)
        searched = detector.detect(frame)
        if not searched or not truths:
            continue
        searched = searched[0]
        before = (searched.marker_id, searched.x_q8, searched.y_q8, searched.heading_cdeg)
        found += 1
        guess = prediction(truths[0], random)
        after = detector.track(frame, *guess)
        if not after or not after[0].flags & detection.FLAG_TRACKED:
            continue
        tracked += 1
        other_id += after[0].marker_id != before[0]
        centre.append(np.hypot(after[0].x_q8 - before[1], after[0].y_q8 - before[2]) / 256)
        heading.append(heading_error(after[0].heading_cdeg / 100, before[3] / 100))
    return {
        "frames": found,
        "tracked_pct": 100.0 * tracked / found if found else None,
        "other_id": other_id,
        "centre_median_px": float(np.median(centre)) if centre else None,
        "centre_max_px": float(np.max(centre)) if centre else None,
        "heading_median_deg": float(np.median(heading)) if heading else None,
        "heading_max_deg": float(np.max(heading)) if heading else None,
    }
