"""How a reader ends with a candidate: numbers, in the order in which the steps can fail."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

ACCEPTED = const(0)
ID_UNCERTAIN = const(1)
NO_RADIUS = const(2)  # the candidate's edges do not lie on two rings
NO_FIT = const(3)  # the rings do not hold under the fit
POOR_RINGS = const(4)  # coverage, ratio, depth or residual are not those of a marker
OUT_OF_RANGE = const(5)
NO_ORIENTATION = const(6)
TWO_ORIENTATIONS = const(7)
NOT_EMPTY = const(8)  # something where nothing is printed, or too doubtful altogether
NO_CODE = const(9)  # ID 0 while it is not enabled
VERDICT_NAMES = (
    "accepted", "id_uncertain", "no_radius", "no_fit", "poor_rings", "out_of_range", "no_orientation",
    "two_orientations", "not_empty", "no_code",
)  # fmt: skip

MARGIN_MIN = const(16)  # what is closer than that to a limit is more often furniture than a marker
