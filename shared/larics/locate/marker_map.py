"""The map: where the markers are, and what no map can be.

A row is (id, x_mm, y_mm, heading_cdeg, z_mm10, outer_mm10, sigma_mm10, sigma_cdeg): place of the centre and
direction of the orientation line in the map frame, height in the vehicle frame (0: the ceiling's), radius of
the outer ring (0: the usual one), standard deviations of place and direction (0: the usual ones). An ID may
repeat in a building: the places are then told apart by where the vehicle was and by its route, so they must
lie apart and look alike.
"""

from array import array

from larics.marker.id_set import within

REPEAT_APART_MM = 2000
_COLUMNS = 8


def _row(row):
    return tuple(row) + (0,) * (_COLUMNS - len(row))


def _apart(a, b, limit_mm):
    dx, dy = a[1] - b[1], a[2] - b[2]
    return dx * dx + dy * dy >= limit_mm * limit_mm


def map_reason(rows, known_ids=(), outer_mm10=1500, lens_mm10=0):
    """None when the rows can be a map, else one line that names the markers and the reason.

    Rows may leave out the last columns. known_ids: the IDs that can be read at all, or
    (first, last) of ranges; empty for any."""
    rows = [_row(row) for row in rows]
    for k in range(len(rows)):
        a = rows[k]
        if not within(known_ids, a[0]):
            return "map has marker %d, which is none of the allowed IDs" % a[0]
        if a[4] and a[4] <= lens_mm10:
            return "map has marker %d at the impossible height %d, the lens is at %d (0.1 mm)" % (
                a[0],
                a[4],
                lens_mm10,
            )
        for b in rows[:k]:
            if a[0] == b[0]:
                if not _apart(a, b, REPEAT_APART_MM):
                    return "map has marker %d twice within %d mm" % (a[0], REPEAT_APART_MM)
                if a[4:6] != b[4:6]:
                    return "map has marker %d twice, with different heights or sizes" % a[0]
            plates_mm = ((a[5] or outer_mm10) + (b[5] or outer_mm10)) // 6  # 5/3 of the outer rings
            if not _apart(a, b, plates_mm):
                return "map has markers %d and %d at impossible places: their plates overlap" % (b[0], a[0])
    return None


class MarkerMap:
    """The rows of a map in flat arrays; an entry is the index of a row. ValueError as `map_reason`."""

    def __init__(self, rows, known_ids=(), outer_mm10=1500, lens_mm10=0):
        reason = map_reason(rows, known_ids, outer_mm10, lens_mm10)
        if reason:
            raise ValueError(reason)
        rows = [_row(row) for row in rows]
        self.count = len(rows)
        self.ids = array("i", [row[0] for row in rows])
        self.x_mm10 = array("i", [row[1] * 10 for row in rows])
        self.y_mm10 = array("i", [row[2] * 10 for row in rows])
        self.heading_cdeg = array("i", [row[3] for row in rows])
        self.z_mm10 = array("i", [row[4] for row in rows])
        self.outer_mm10 = array("i", [row[5] or outer_mm10 for row in rows])
        self.sigma_mm10 = array("i", [row[6] for row in rows])
        self.sigma_cdeg = array("i", [row[7] for row in rows])

    def find(self, marker_id, start=0):
        """The first entry from `start` on with this ID, -1 when there is none."""
        for entry in range(start, self.count):
            if self.ids[entry] == marker_id:
                return entry
        return -1

    def repeats(self, marker_id):
        """Whether the ID stands at more than one place."""
        first = self.find(marker_id)
        return first >= 0 and self.find(marker_id, first + 1) >= 0
