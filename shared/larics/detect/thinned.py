"""Markers in frames, or with rings, larger than the detector takes: it gets every n-th pixel and row.

One slice of ulab on a board, of numpy on a PC, makes a new small frame: 8.0 instructions for each pixel of
the whole one on an emulated Cortex-M7. Without either a loop does the same, in 135. Nothing is averaged: what
is thinned is noisier, and its edges rougher, than what a smaller sensor mode would give, so prefer that where
the camera has one.
"""

try:
    import micropython  # noqa: F401  (its presence tells the interpreter)
    from micropython import const

    try:
        from ulab import numpy as np
    except ImportError:
        np = None
except ImportError:
    from larics._cpython import const, np

from larics.arith.fixed import frame_view
from larics.detect.detector import MARKERS, Detector
from larics.detect.scales import RADIUS_MOST_PX
from larics.marker.detection import Detection

_SIDE_MOST_PX = const(1024)


def _enough(length, most):
    return (length + most - 1) // most


class ThinnedDetector:
    """A `Detector` behind a sieve; frames, radii and detections are in pixels of the frame as it comes.

    width, height   px
    radius_min_px, radius_max_px   range of the outer ring's radius, 6 px x step to 72 px x step
    step            one pixel of so many is kept, along and across; None: as few as are left out at least
    options         those of `Detector`

    `detector` is the one behind. ValueError where it cannot be made."""

    def __init__(self, width, height, radius_min_px, radius_max_px, step=None, **options):
        if step is None:
            step = max(_enough(max(width, height), _SIDE_MOST_PX), _enough(radius_max_px, RADIUS_MOST_PX))
        self.width, self.height, self.step = width, height, step
        self._columns, self._rows = width // step, height // step
        self.detector = Detector(
            self._columns, self._rows, radius_min_px // step, _enough(radius_max_px, step), **options
        )
        self._kept = bytearray(self._columns * self._rows if np is None else 0)
        detections = [Detection() for _ in range(MARKERS)]
        self._found = [detections[:count] for count in range(MARKERS + 1)]

    def detect(self, frame):
        """The markers in a frame, as `Detector.detect` takes and returns them."""
        return self._enlarged(self.detector.detect(self._thin(frame)))

    def track(self, frame, x_q8=None, y_q8=None, radius_q8=None):
        """The marker near a predicted place, as `Detector.track`."""
        frame = self._thin(frame)
        if x_q8 is None:
            return self._enlarged(self.detector.track(frame))
        first_q8 = self._first() << 8
        x_q8, y_q8 = (x_q8 - first_q8) // self.step, (y_q8 - first_q8) // self.step
        return self._enlarged(self.detector.track(frame, x_q8, y_q8, radius_q8 // self.step))

    def _first(self):
        """The first row, and column, that is kept."""
        return (self.step - 1) // 2

    def _thin(self, frame):
        frame = frame_view(frame)
        width, step, first = self.width, self.step, self._first()
        if len(frame) != width * self.height:
            raise ValueError(
                "a frame of %dx%d px has %d bytes, not %d"
                % (width, self.height, width * self.height, len(frame))
            )
        if np is not None:
            whole = np.frombuffer(frame, dtype=np.uint8).reshape((self.height, width))
            right, below = first + self._columns * step, first + self._rows * step
            return whole[first:below:step, first:right:step].copy()
        kept, k = self._kept, 0
        for row in range(self._rows):
            place = (first + row * step) * width + first
            for column in range(0, self._columns * step, step):
                kept[k] = frame[place + column]
                k += 1
        return kept

    def _enlarged(self, found):
        """Copies of the detections in pixels of the whole frame."""
        step, first_q8 = self.step, self._first() << 8
        copies = self._found[len(found)]
        for one, copy in zip(found, copies):
            copy.take(one)
            copy.x_q8 = one.x_q8 * step + first_q8
            copy.y_q8 = one.y_q8 * step + first_q8
            copy.radius_q8 = one.radius_q8 * step
            if one.sigma_q12 > 0:
                copy.sigma_q12 = one.sigma_q12 * step
        return copies
