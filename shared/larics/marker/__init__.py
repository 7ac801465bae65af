"""The marker: the one table of its geometry, and the bits of an ID.

Lengths are tenths of a millimetre (`_mm10`), angles hundredths of a degree (`_cdeg`), counterclockwise
as seen by whoever looks at the printed face; the orientation line lies at angle 0. The default family
is that of the LARICS paper: two rings, an orientation line outside them, three coding lines inside.
"""

CODE_ANGLES_CDEG = (9000, 18000, 27000)  # most significant, middle, least significant bit
BITS = len(CODE_ANGLES_CDEG)
ID_COUNT = 1 << BITS

RING = "ring"
LINE = "line"


class Family:
    """Markers of one size and one line width; immutable by convention.

    outer_mm10, inner_mm10             radii of the two rings, to the centre of their line
    line_mm10                          width of every line
    orientation_end_mm10               the orientation line runs from the outer ring to this radius
    code_start_mm10, code_end_mm10     radii between which a coding line runs
    plate_mm10                         radius of the white plate
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
        self.outer_mm10 = outer_mm10
        self.inner_mm10 = inner_mm10
        self.line_mm10 = line_mm10
        self.orientation_end_mm10 = orientation_end_mm10
        self.code_start_mm10 = code_start_mm10
        self.code_end_mm10 = code_end_mm10
        self.plate_mm10 = plate_mm10
        self.allow_id0 = allow_id0

    def scaled(self, outer_mm10, line_mm10=0, allow_id0=None):
        """The same marker with another outer radius, every length in proportion, rounded to 0.1 mm.

        line_mm10 other than 0 sets the line width instead; allow_id0 is kept unless given.
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
        )

    def ids(self):
        """The IDs in use, ascending."""
        return tuple(range(0 if self.allow_id0 else 1, ID_COUNT))

    def bits(self, marker_id):
        """The bits of an ID in the order of CODE_ANGLES_CDEG: 1 where there is a line.

        Raises ValueError for an ID that the family does not use.
        """
        if marker_id not in self.ids():
            raise ValueError("unknown marker ID %s" % marker_id)
        return tuple([marker_id >> (BITS - 1 - index) & 1 for index in range(BITS)])

    def strokes(self, marker_id):
        """What is black on the plate, as a tuple of primitives, all with butt ends:

        (RING, radius_mm10, width_mm10)
        (LINE, angle_cdeg, start_mm10, end_mm10, width_mm10), radial, start and end along the radius
        """
        strokes = [
            (RING, self.outer_mm10, self.line_mm10),
            (RING, self.inner_mm10, self.line_mm10),
            (LINE, 0, self.outer_mm10, self.orientation_end_mm10, self.line_mm10),
        ]
        for bit, angle_cdeg in zip(self.bits(marker_id), CODE_ANGLES_CDEG):
            if bit:
                strokes.append((LINE, angle_cdeg, self.code_start_mm10, self.code_end_mm10, self.line_mm10))
        return tuple(strokes)


LARICS3 = Family()
