"""A marker in a frame without any disturbance, drawn from its measures alone."""

import math

import numpy as np

SAMPLES = 4  # a pixel is the mean of SAMPLES x SAMPLES points


def plain_frame(marker_id, x=60.0, y=55.0, heading_deg=30.0, radius_px=30.0, size=(128, 112), line=20):
    """A frame of `size` (width, height), uint8: a white plate on grey, its marker centred at (x, y) px."""
    width, height = size
    offsets = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    columns = (np.arange(width)[:, None] + offsets).ravel() - x
    rows = (np.arange(height)[:, None] + offsets).ravel() - y
    angle = math.radians(heading_deg)
    scale = 150 / radius_px
    # millimetres on the plate, u along the orientation line, v counterclockwise from it
    u = scale * (columns * math.cos(angle) - rows[:, None] * math.sin(angle))
    v = scale * (-columns * math.sin(angle) - rows[:, None] * math.cos(angle))
    radius = np.hypot(u, v)
    half = line / 2
    black = (abs(radius - 150) < half) | (abs(radius - 100) < half)
    black |= (u > 150) & (u < 230) & (abs(v) < half)
    for bit, along, across in ((4, v, u), (2, -u, v), (1, -v, u)):
        if marker_id & bit:
            black |= (along > 25) & (along < 80) & (abs(across) < half)
    shade = np.where(black, 30.0, np.where(radius < 250, 220.0, 120.0))
    shade = shade.reshape(height, SAMPLES, width, SAMPLES).mean(axis=(1, 3))
    return np.round(shade).astype(np.uint8)


def stained_frame():
    """A marker 6 of 148 x 132 px behind whose orientation line a stain lies: the rules alone refuse it."""
    frame = plain_frame(6, 70.0, 66.0, 0, size=(148, 132))
    frame[63:70, 118:126] = 30
    return frame
