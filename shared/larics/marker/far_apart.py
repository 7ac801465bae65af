"""IDs of the coded family that are more than usually unlike each other, for places with few markers."""

# Any two of them, and each of them and a plain marker, differ in at least 12 of 24 cells instead of 8: what
# the rotations of two complementary words of the cyclic Golay code of weight 12 leave when the IDs without a
# coding line are taken out.
FAR_APART_IDS = (
    122, 166, 245, 332, 491, 643, 665, 821, 863, 982, 1054, 1229, 1287, 1331, 1433, 1637, 1643, 1726, 1964,
    1986, 2109, 2131, 2369, 2452, 2458, 2479, 2575, 2662, 2764, 2866, 3041, 3113, 3274, 3287, 3430, 3452,
    3604, 3763, 3850, 3929, 3973,
)  # fmt: skip
FAR_APART_DISTANCE = 12
