"""The published method, integer-only: the baseline that the product's own detector is compared with.

Sobel gradients (equations 4 to 6), Hough voting along the gradient for the common centre of both rings
(1 to 3), the global maximum of the accumulator, a local window with an adaptive threshold, radial sums
H(alpha) over 360 whole degrees (7) up to N (8), the orientation line at the maximum of H, and the three bits
at 90, 180 and 270 degrees counterclockwise from it, each by comparing H with Z (9).

What the paper leaves open or contradicts, and what was assumed here:

- Its outer ring has a radius of 15 cm in section 2 and 8 cm in the example of section 4 (N = 32 =
  2 * (8 + 8)). Assumed: the family's geometry, so N = scale * (outer radius + length of the orientation
  line), which for 15 cm and 8 cm at 2 px/cm is 46.
- "45 degrees between coding lines" means the sampling positions alpha0 + 45 n, n = 1..7, of equation 9; the
  lines stand at 90, 180 and 270 degrees (n = 2, 4, 6).
- Z is one sixth of the sum of H over these seven positions, a threshold a sixth above their mean: with no
  coding line at all, seven equal sums stay below it. A bit is 1 where H > Z.
- The scale is that of a known height of the ceiling. Assumed: a range of radii; within it, the scale comes
  from the distances of the edges that point to the centre found.
- Votes go in both directions along the gradient, since a line has edges of both polarities, and at the radii
  that an edge of either ring may have in that range.
- The edge threshold is a number, as in the paper, or adapted to the frame: the strongest tenth of the
  pixels, but no gradient below 24.
- The adaptive threshold in the window is the mean of a square half as wide as the outer ring's radius, less
  a seventh of it; the paper names the principle only.
- Where neighbouring angles share the maximum of H, the middle one is taken. H of a coding line comes close
  to that of the orientation line (55 and 70 mm, and the gap to the inner ring blurs), so that now and then
  the maximum is a coding line, more often with small rings: the method's own wrong IDs.
- A maximum with fewer votes than three per pixel of radius is no marker; the paper has no such test. Apart
  from that the method always answers: clutter is read as a marker, and only one marker in a frame is found.
- An ID that the family does not use (000, unless allowed) is reported as uncertain.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import frame_view, sin_q14, turn16_from_cdeg
from larics.kernels import paper as kernels
from larics.marker import CODE_ANGLES_CDEG, LARICS3
from larics.marker.detection import FLAG_BORDER, FLAG_ID_UNCERTAIN, NO_ID, Detection

_BAND_ROWS = const(16)  # gradients are held for that many rows at a time
_LARGEST_PX = const(1024)
_LARGEST_MAGNITUDE = const(1442)  # isqrt(2 * 1020**2)
_FAR_PX = const(100)  # votes farther away could overflow 16 bits
_FLOOR = const(24)
_STRONGEST = const(10)  # one pixel in ten
_DARKER_Q8 = const(36)
_VOTES_PER_RADIUS = const(3)


def _ceil_div(value, divisor):
    return -(-value // divisor)


class PaperDetector:
    """Finds at most one marker in each frame, by the published method.

    width, height: 16..1024 px; radius_min_px, radius_max_px: whole pixels, the outer ring's radius lies
    between them, 5 px to about 93; edge_threshold: Sobel magnitude (1..1442) of an edge, or None to adapt it
    to each frame; family: the marker's geometry. Raises ValueError for anything else.

    The intermediate results of the last frame stay readable for figures and diagnosis:
    accumulator (array of width * height votes), radial_sums (H of 360 degrees), window (0 and 1, rows of
    window_side pixels), z6 (six times Z), threshold (edge threshold used), votes (at the maximum).
    """

    def __init__(self, width, height, radius_min_px, radius_max_px, edge_threshold=None, family=LARICS3):
        if not (16 <= width <= _LARGEST_PX and 16 <= height <= _LARGEST_PX):
            raise ValueError("a frame of %dx%d is not within 16x16 and 1024x1024" % (width, height))
        if not 5 <= radius_min_px <= radius_max_px:
            raise ValueError("%s to %s px is no range of radii from 5 px on" % (radius_min_px, radius_max_px))
        if 2 * radius_min_px >= min(width, height):
            raise ValueError(
                "a frame of %dx%d is smaller than a ring of radius %d" % (width, height, radius_min_px)
            )
        if edge_threshold is not None and not 1 <= edge_threshold <= _LARGEST_MAGNITUDE:
            raise ValueError("an edge threshold of %s is not within 1 and 1442" % edge_threshold)
        outer, inner = family.outer_mm10, family.inner_mm10
        half_line = (family.line_mm10 + 1) // 2
        self._inner_nearest = max(1, (inner - half_line) * radius_min_px // outer)
        self._inner_farthest = _ceil_div((inner + half_line) * radius_max_px, outer)
        self._outer_nearest = (outer - half_line) * radius_min_px // outer
        self._outer_farthest = _ceil_div((outer + half_line) * radius_max_px, outer)
        if self._outer_farthest > _FAR_PX:
            raise ValueError("a radius of %d px is too large" % radius_max_px)
        if self._inner_farthest + 1 >= self._outer_nearest:  # one range of distances
            self._outer_nearest = self._inner_nearest
            self._inner_farthest = 0
        self.width = width
        self.height = height
        self.family = family
        self._radius_min_px = radius_min_px
        self._radius_max_px = radius_max_px
        self._fixed_threshold = edge_threshold
        self._reach = self._outer_farthest + 1

        largest_half = self._half_window(radius_max_px << 8)
        band = bytes(2 * _BAND_ROWS * width)
        self._gx = array("H", band)
        self._gy = array("H", band)
        self._magnitude = array("H", band)
        self._magnitudes = array("i", bytes(4 * (_LARGEST_MAGNITUDE + 1)))
        self._radii = array("H", bytes(8 * self._reach))
        self._columns = array("i", bytes(4 * width))
        self._sines = array("H", [32768 + sin_q14(turn16_from_cdeg(100 * a)) for a in range(450)])
        self.accumulator = array("H", bytes(2 * width * height))
        self.window = bytearray((2 * largest_half + 1) * (2 * largest_half + 1))
        self.radial_sums = array("H", bytes(720))
        self.window_side = 0
        self.z6 = 0
        self.threshold = 0
        self.votes = 0
        self._detection = Detection()
        self._nothing = []
        self._one = [self._detection]

    def memory(self):
        """Bytes of working memory by name; the accumulator of the whole frame dominates."""
        return {
            "accumulator": 2 * len(self.accumulator),
            "gradient band": 6 * len(self._gx),
            "window": len(self.window),
            "column sums": 4 * len(self._columns),
            "histograms": 4 * len(self._magnitudes) + 2 * len(self._radii),
            "radial sums and sines": 2 * (len(self.radial_sums) + len(self._sines)),
        }

    def detect(self, frame):
        """The marker in a frame of width * height bytes, row by row, as a list of no or one Detection.

        The list and the detection belong to the detector and are reused; nothing is allocated.
        Raises ValueError when the frame has another size.
        """
        gray = frame_view(frame)
        if len(gray) != self.width * self.height:
            raise ValueError("a frame of %d bytes is not %dx%d" % (len(gray), self.width, self.height))
        self.threshold = self._fixed_threshold
        if self.threshold is None:
            self.threshold = self._adapted_threshold(gray)
        index = self._vote(gray)
        self.votes = self.accumulator[index]
        x0, y0 = index % self.width, index // self.width
        radius_q8 = self._measure_radius(gray, x0, y0)
        if self.votes << 8 < _VOTES_PER_RADIUS * radius_q8:
            return self._nothing
        self._decode(gray, x0, y0, radius_q8)
        return self._one

    def _half_window(self, radius_q8):
        """N of equation 8: pixels from the centre to the end of the orientation line, rounded."""
        outer = self.family.outer_mm10
        return (radius_q8 * self.family.orientation_end_mm10 + 128 * outer) // (256 * outer)

    def _sobel(self, gray, first_row, rows, floor):
        kernels.sobel(gray, self._gx, self._gy, self._magnitude, self.width, first_row, rows, floor * floor)

    def _adapted_threshold(self, gray):
        kernels.clear32(self._magnitudes, _LARGEST_MAGNITUDE + 1)
        row = 1
        while row < self.height - 1:
            rows = min(_BAND_ROWS, self.height - 1 - row)
            self._sobel(gray, row, rows, _FLOOR)
            kernels.count_magnitudes(self._magnitude, self._magnitudes, rows * self.width)
            row += rows
        keep = self.width * self.height // _STRONGEST
        strongest = kernels.threshold_of_strongest(self._magnitudes, _LARGEST_MAGNITUDE + 1, keep)
        return max(_FLOOR, strongest)

    def _vote(self, gray):
        """Fills the accumulator; the index of its maximum."""
        kernels.clear16(self.accumulator, self.width * self.height)
        row = 1
        while row < self.height - 1:
            rows = min(_BAND_ROWS, self.height - 1 - row)
            self._sobel(gray, row, rows, self.threshold)
            self._vote_band(row, rows, self._outer_nearest, self._outer_farthest)
            if self._inner_farthest:
                self._vote_band(row, rows, self._inner_nearest, self._inner_farthest)
            row += rows
        return kernels.argmax16(self.accumulator, self.width * self.height)

    def _vote_band(self, row, rows, nearest, farthest):
        kernels.vote(
            self.accumulator,
            self._gx,
            self._gy,
            self._magnitude,
            self.width,
            self.height,
            row,
            rows,
            self.threshold << 4,
            nearest,
            farthest,
        )

    def _measure_radius(self, gray, x0, y0):
        """Radius of the outer ring in 1/256 px: the one for which both rings are best covered by edges that
        point to the centre, then the mean of their distances."""
        radii, reach = self._radii, self._reach
        kernels.clear16(radii, 4 * reach)
        row = max(1, y0 - reach)
        end = min(self.height - 1, y0 + reach + 1)
        while row < end:
            rows = min(_BAND_ROWS, end - row)
            self._sobel(gray, row, rows, self.threshold)
            kernels.count_radii(
                radii,
                self._gx,
                self._gy,
                self._magnitude,
                self.width,
                row,
                rows,
                self.threshold << 4,
                x0,
                y0,
                reach,
            )
            row += rows
        outer, inner = self.family.outer_mm10, self.family.inner_mm10
        best, best_q2 = 0, 2 * (self._radius_min_px + self._radius_max_px)
        for radius_q2 in range(4 * self._radius_min_px, 4 * self._radius_max_px + 1):
            inner_q2 = radius_q2 * inner // outer
            margin_q2 = self._margin_q2(radius_q2)
            covered = min(
                (self._count(radius_q2, margin_q2) << 8) // radius_q2,
                (self._count(inner_q2, margin_q2) << 8) // inner_q2,
            )
            if covered > best:
                best, best_q2 = covered, radius_q2
        radius_q8 = best_q2 << 6
        if best:
            for _ in range(2):
                radius_q2 = (radius_q8 + 32) >> 6
                radius_q8 = self._mean_q8(radius_q2, self._margin_q2(radius_q2), radius_q8)
        return min(max(radius_q8, self._radius_min_px << 8), self._radius_max_px << 8)

    def _margin_q2(self, radius_q2):
        """How far a ring's edges lie from its radius, in quarters of a pixel: half a line and one pixel."""
        return radius_q2 * self.family.line_mm10 // (2 * self.family.outer_mm10) + 4

    def _count(self, radius_q2, margin_q2):
        """Number of edges counted within the margin of a radius."""
        total = 0
        for quarter in range(max(0, radius_q2 - margin_q2), min(len(self._radii), radius_q2 + margin_q2 + 1)):
            total += self._radii[quarter]
        return total

    def _mean_q8(self, radius_q2, margin_q2, default):
        """Mean distance of the edges around the outer ring, 1/256 px."""
        total = weighted = 0
        for quarter in range(max(0, radius_q2 - margin_q2), min(len(self._radii), radius_q2 + margin_q2 + 1)):
            total += self._radii[quarter]
            weighted += self._radii[quarter] * quarter
        return (weighted << 6) // total if total else default

    def _decode(self, gray, x0, y0, radius_q8):
        """Window, H(alpha), orientation and bits, written to the detection."""
        half = self._half_window(radius_q8)
        self.window_side = 2 * half + 1
        kernels.binarise(
            gray,
            self.window,
            self._columns,
            self.width,
            self.height,
            x0,
            y0,
            half,
            (radius_q8 + 512) >> 10,
            _DARKER_Q8,
        )
        sums = self.radial_sums
        kernels.radial_sums(self.window, self._sines, sums, half)
        alpha0 = self._orientation()
        z6 = 0
        for n in range(1, 8):
            z6 += sums[(alpha0 + 45 * n) % 360]
        self.z6 = z6
        marker_id = 0
        nearest_decision = 6 * half
        for angle_cdeg in CODE_ANGLES_CDEG:
            above = 6 * sums[(alpha0 + angle_cdeg // 100) % 360] - z6
            marker_id = marker_id << 1 | (1 if above > 0 else 0)
            nearest_decision = min(nearest_decision, abs(above))
        self._report(marker_id, x0, y0, radius_q8, alpha0, half, nearest_decision)

    def _orientation(self):
        """The angle in degrees at which H is largest, the middle one of a run of equal angles."""
        sums = self.radial_sums
        first = kernels.argmax16(sums, 360)
        largest = sums[first]
        before = after = 0
        while before < 180 and sums[(first - before - 1) % 360] == largest:
            before += 1
        while after < 180 and sums[(first + after + 1) % 360] == largest:
            after += 1
        return (first + (after - before) // 2) % 360

    def _report(self, marker_id, x0, y0, radius_q8, alpha0, half, nearest_decision):
        """nearest_decision: six times the smallest distance of a bit's H from Z."""
        family = self.family
        line_mm10 = family.code_end_mm10 - family.code_start_mm10
        line_px6 = 6 * radius_q8 * line_mm10 // (256 * family.outer_mm10)
        found = self._detection
        found.marker_id = marker_id
        found.x_q8 = x0 << 8
        found.y_q8 = y0 << 8
        found.heading_cdeg = 100 * alpha0
        found.radius_q8 = radius_q8
        found.margin = min(255, 510 * nearest_decision // max(1, line_px6))  # 255: half a line away
        found.flags = 0
        if marker_id == 0 and not family.allow_id0:
            found.marker_id = NO_ID
            found.flags = FLAG_ID_UNCERTAIN
        if x0 < half or y0 < half or x0 + half >= self.width or y0 + half >= self.height:
            found.flags |= FLAG_BORDER
