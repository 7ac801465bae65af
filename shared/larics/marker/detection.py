"""What a detector reports: one `Detection` for each marker seen."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

FLAG_ID_UNCERTAIN = const(1)  # the pose is certain, the ID is not; marker_id is NO_ID
FLAG_UNCONFIRMED = const(2)  # the ID has not yet been agreed on by enough frames
FLAG_TRACKED = const(4)  # found in the window around the prediction, without a search
FLAG_BORDER = const(8)  # the plate is cut off by the border of the frame
FLAG_BLUR_MODEL = const(16)  # accepted by the blur-model reader, not by the direct reader

FLAG_NAMES = (
    (FLAG_ID_UNCERTAIN, "id_uncertain"),
    (FLAG_UNCONFIRMED, "unconfirmed"),
    (FLAG_TRACKED, "tracked"),
    (FLAG_BORDER, "border"),
    (FLAG_BLUR_MODEL, "model"),
)

NO_ID = const(-1)
NO_SIGMA = const(-1)


class Detection:
    """One marker in one frame.

    marker_id     0..7 plain, 9..4094 coded, or NO_ID when FLAG_ID_UNCERTAIN is set
    x_q8, y_q8    projected centre of the rings, 1/256 px, x right, y down, pixel centres at integers
    heading_cdeg  image angle of the orientation line, counterclockwise as seen, 0..35999
    radius_q8     outer ring, centre of its line, 1/256 px
    margin        0..255, how far the weakest decision is from its limit
    sigma_q12     standard deviation of x and of y, 1/4096 px, at least 1; NO_SIGMA when it is not known
    sigma_mdeg    of the heading, 0.001 degrees, likewise
    flags         sum of FLAG_*

    A detector owns its detections and reuses them: copy what must outlive the next frame.
    """

    __slots__ = (
        "marker_id",
        "x_q8",
        "y_q8",
        "heading_cdeg",
        "radius_q8",
        "margin",
        "flags",
        "sigma_q12",
        "sigma_mdeg",
    )

    def __init__(self):
        self.clear()

    def clear(self):
        self.marker_id = NO_ID
        self.x_q8 = 0
        self.y_q8 = 0
        self.heading_cdeg = 0
        self.radius_q8 = 0
        self.margin = 0
        self.flags = 0
        self.sigma_q12 = NO_SIGMA
        self.sigma_mdeg = NO_SIGMA

    def take(self, other):
        """Becomes a copy of another detection."""
        self.marker_id = other.marker_id
        self.x_q8 = other.x_q8
        self.y_q8 = other.y_q8
        self.heading_cdeg = other.heading_cdeg
        self.radius_q8 = other.radius_q8
        self.margin = other.margin
        self.flags = other.flags
        self.sigma_q12 = other.sigma_q12
        self.sigma_mdeg = other.sigma_mdeg

    def covers(self, x_q8, y_q8):
        """Whether a place lies within a radius of the marker, in x and in y."""
        return abs(x_q8 - self.x_q8) < self.radius_q8 and abs(y_q8 - self.y_q8) < self.radius_q8

    def __repr__(self):
        return "Detection(id=%d, x_q8=%d, y_q8=%d, heading_cdeg=%d, radius_q8=%d, margin=%d, flags=%d)" % (
            self.marker_id,
            self.x_q8,
            self.y_q8,
            self.heading_cdeg,
            self.radius_q8,
            self.margin,
            self.flags,
        )


def flag_names(flags):
    """The names of the flags that are set, as a list."""
    return [name for flag, name in FLAG_NAMES if flags & flag]
