"""The marker: the one table of its geometry, and the bits of an ID.

Lengths are tenths of a millimetre (`_mm10`), angles hundredths of a degree (`_cdeg`), counterclockwise
as seen by whoever looks at the printed face; the orientation line lies at angle 0.

There are two families. The plain one is that of the LARICS paper: two rings, an orientation line outside
them, three coding lines inside; IDs 1 to 7. The coded one adds 24 cells outside the rings, in eight groups
of three that leave white what the lines need; they carry the ID's word of `larics.marker.golay`. ID 8 k + b
has the coding lines of b, 1 to 7, so that whoever knows nothing of cells reads b; its IDs below 8 are the
plain markers, without a dark cell, and 4095, dark all around, is not used: 3,583 IDs.
"""

from larics.marker import golay

CODE_ANGLES_CDEG = (9000, 18000, 27000)  # most significant, middle, least significant bit
BITS = len(CODE_ANGLES_CDEG)
ID_COUNT = 1 << BITS

PLAIN_ID_MOST = ID_COUNT - 1
CODED_ID_MOST = 4094
FAMILY_NAMES = ("plain", "coded")

CELLS_OF_GROUP = 3
CELL_CDEG = 900  # width of a cell
# where a group begins, counterclockwise: first cell 0 of each quarter turn, then its cell 3
GROUPS_CDEG = tuple([9000 * quarter + angle for quarter in range(4) for angle in (1400, 4900)])
# the outer ring's radius in the image that is looked for when nobody says which
RADIUS_MIN_PX = 10
RADIUS_MAX_PX = 60

RING = "ring"
LINE = "line"
ARC = "arc"


def is_used(marker_id, coded=True, allow_id0=False):
    """Whether a family uses an ID."""
    if marker_id <= PLAIN_ID_MOST:
        return 0 < marker_id or (marker_id == 0 and allow_id0)
    return coded and marker_id <= CODED_ID_MOST and marker_id & PLAIN_ID_MOST > 0


def mirrored_lines(marker_id):
    """The ID whose coding lines a plain marker of this ID has in a mirror."""
    return (marker_id & 1) << 2 | marker_id & 2 | marker_id >> 2


def ids_in_words(coded=True, allow_id0=False):
    """The IDs that a family uses, as text for messages."""
    text = "IDs %d to %d" % (0 if allow_id0 else 1, PLAIN_ID_MOST)
    if coded:
        text += ", and to %d those that are no multiple of %d" % (CODED_ID_MOST, ID_COUNT)
    return "the %s family has %s" % (FAMILY_NAMES[1 if coded else 0], text)


class Family:
    """Markers of one size and one line width; immutable by convention.

    outer_mm10, inner_mm10             radii of the two rings, to the centre of their line
    line_mm10                          width of every line
    orientation_end_mm10               the orientation line runs from the outer ring to this radius
    code_start_mm10, code_end_mm10     radii between which a coding line runs
    plate_mm10                         radius of the white plate
    cell_start_mm10, cell_end_mm10     radii between which a cell runs
    coded                              whether there are cells: the coded family, which includes the plain one
    allow_id0                          ID 0 has no coding line at all, which makes it the one that clutter
                                       imitates most easily; it is off unless asked for

    Raises ValueError when the parts would touch each other or leave the plate.
    """

    __slots__ = (
        "outer_mm10",
        "inner_mm10",
        "line_mm10",
        "orientation_end_mm10",
        "code_start_mm10",
        "code_end_mm10",
        "plate_mm10",
        "allow_id0",
        "coded",
        "cell_start_mm10",
        "cell_end_mm10",
    )

    def __init__(
        self,
        outer_mm10=1500,
        inner_mm10=1000,
        line_mm10=200,
        orientation_end_mm10=2300,
        code_start_mm10=250,
        code_end_mm10=800,
        plate_mm10=2500,
        allow_id0=False,
        coded=False,
        cell_start_mm10=2200,
        cell_end_mm10=2440,
    ):
        half = (line_mm10 + 1) // 2
        if not line_mm10 > 0 or not code_start_mm10 > 0:
            raise ValueError("line width and radii of a marker are positive")
        if not (
            code_start_mm10 < code_end_mm10
            and code_end_mm10 + half < inner_mm10
            and inner_mm10 + 2 * half < outer_mm10
            and outer_mm10 + half < orientation_end_mm10 <= plate_mm10
        ):
            raise ValueError("the marker's lines are too wide, or its radii are not in order")
        if coded and not outer_mm10 + half < cell_start_mm10 < cell_end_mm10 <= plate_mm10:
            raise ValueError("the marker's cells must lie between its rings and the rim of its plate")
        self.outer_mm10 = outer_mm10
        self.inner_mm10 = inner_mm10
        self.line_mm10 = line_mm10
        self.orientation_end_mm10 = orientation_end_mm10
        self.code_start_mm10 = code_start_mm10
        self.code_end_mm10 = code_end_mm10
        self.plate_mm10 = plate_mm10
        self.allow_id0 = allow_id0
        self.coded = coded
        self.cell_start_mm10 = cell_start_mm10
        self.cell_end_mm10 = cell_end_mm10

    @property
    def name(self):
        """One of FAMILY_NAMES."""
        return FAMILY_NAMES[1 if self.coded else 0]

    def scaled(self, outer_mm10, line_mm10=0, allow_id0=None, coded=None):
        """The same marker with another outer radius, every length in proportion, rounded to 0.1 mm.

        line_mm10 other than 0 sets the line width instead; allow_id0 and coded are kept unless given.
        """
        if not outer_mm10 > 0:
            raise ValueError("the outer radius of a marker is positive")
        old = self.outer_mm10

        def scale(length_mm10):
            return (2 * length_mm10 * outer_mm10 + old) // (2 * old)

        return Family(
            outer_mm10,
            scale(self.inner_mm10),
            line_mm10 if line_mm10 else scale(self.line_mm10),
            scale(self.orientation_end_mm10),
            scale(self.code_start_mm10),
            scale(self.code_end_mm10),
            scale(self.plate_mm10),
            self.allow_id0 if allow_id0 is None else allow_id0,
            self.coded if coded is None else coded,
            scale(self.cell_start_mm10),
            scale(self.cell_end_mm10),
        )

    def ids(self):
        """The IDs in use, ascending: 7 of the plain family, 3,583 of the coded one."""
        return tuple([i for i in range(CODED_ID_MOST + 1 if self.coded else ID_COUNT) if self.has(i)])

    def has(self, marker_id):
        """Whether the family uses an ID."""
        return is_used(marker_id, self.coded, self.allow_id0)

    def _check(self, marker_id):
        if not self.has(marker_id):
            raise ValueError(
                "no marker has ID %s: %s" % (marker_id, ids_in_words(self.coded, self.allow_id0))
            )

    def cells(self, marker_id):
        """The dark cells of an ID, a bit for each of 24; cell 6 q + i is the i-th of the q-th quarter turn.

        Raises ValueError for an ID that the family does not use.
        """
        self._check(marker_id)
        return golay.cells(marker_id) if marker_id > PLAIN_ID_MOST else 0

    def bits(self, marker_id):
        """The bits of an ID in the order of CODE_ANGLES_CDEG: 1 where there is a line.

        Raises ValueError for an ID that the family does not use.
        """
        self._check(marker_id)
        return tuple([marker_id >> (BITS - 1 - index) & 1 for index in range(BITS)])

    def strokes(self, marker_id):
        """What is black on the plate, as a tuple of primitives, all with butt ends:

        (RING, radius_mm10, width_mm10)
        (LINE, angle_cdeg, start_mm10, end_mm10, width_mm10), radial, start and end along the radius
        (ARC, first_cdeg, last_cdeg, start_mm10, end_mm10), between two angles and two radii: dark cells,
        those beside each other in one
        """
        strokes = [
            (RING, self.outer_mm10, self.line_mm10),
            (RING, self.inner_mm10, self.line_mm10),
            (LINE, 0, self.outer_mm10, self.orientation_end_mm10, self.line_mm10),
        ]
        for bit, angle_cdeg in zip(self.bits(marker_id), CODE_ANGLES_CDEG):
            if bit:
                strokes.append((LINE, angle_cdeg, self.code_start_mm10, self.code_end_mm10, self.line_mm10))
        dark = self.cells(marker_id)
        for first_cdeg in GROUPS_CDEG:
            first = 0
            for index in range(CELLS_OF_GROUP):
                if not dark >> index & 1:
                    first = index + 1
                elif index + 1 == CELLS_OF_GROUP or not dark >> (index + 1) & 1:
                    ends = (first_cdeg + CELL_CDEG * first, first_cdeg + CELL_CDEG * (index + 1))
                    strokes.append((ARC, ends[0], ends[1], self.cell_start_mm10, self.cell_end_mm10))
            dark >>= CELLS_OF_GROUP
        return tuple(strokes)

    def smallest_mm10(self, marker_id):
        """The narrowest dark field of an ID's print: the line, or the shorter side of a cell."""
        smallest = self.line_mm10
        if self.cells(marker_id):
            # 9 degrees are 1/6.366 of the radius
            along = self.cell_start_mm10 * 157 // 1000
            smallest = min(smallest, along, self.cell_end_mm10 - self.cell_start_mm10)
        return smallest


LARICS3 = Family()
CODED = Family(coded=True)
