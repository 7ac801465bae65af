"""Limits of what a reading says of itself: its standard deviations, its radius, a bettered centre."""

from array import array

from larics.blurred import uncertainty as blurred
from larics.blurred.blur_model import SIGMAS
from larics.direct import uncertainty
from larics.direct.reader import DirectReader
from larics.kernels import layouts
from larics.marker import LARICS3
from larics.marker.detection import Detection


class Rings:
    """A clean fit of rings of 60 px, 400 deep all around, that did not move any more."""

    area = 400
    moved_q10 = 0
    radius_q8 = 15360
    outer_means = inner_means = array("i", [32768] * 16 + [400] * 16)


class Robust:
    def __init__(self, variance, square):
        self.variance, self.square = variance, square


class Lines:
    """An orientation line so far from the centre, so dark, and seen in so many crossings."""

    def __init__(self, distance=0, area=256, counted=5):
        self.line = array("i", [0] * layouts.CROSSING_ITEMS)
        self.line[layouts.CROSSING_DISTANCE], self.line[layouts.CROSSING_AREA] = distance, area
        self.line[layouts.CROSSING_COUNTED] = counted


def few_pixels(variance):
    """What 60 px of radius make of a variance."""
    return variance + (variance * (35840 * 256 // 960**2) >> 8)


def test_what_sampling_makes_evens_out():
    for square, left in ((75, 100), (150, 100), (200, 250), (300, 500), (1500, 900)):
        found = uncertainty.centre_variance(Robust(1000, square), Rings, Lines())
        assert found == few_pixels(left * 13 // 16), (square, found)


def test_a_line_that_is_not_seen_may_stray():
    for lines, distance in ((None, 256), (Lines(256), 256), (Lines(100), 100), (Lines(9000), 4096)):
        found = uncertainty.centre_variance(Robust(0, 100), Rings, lines)
        assert found == few_pixels(distance * distance // 22), distance


def test_rings_that_moved_last_are_less_sure():
    class Moved(Rings):
        moved_q10 = 120

    assert uncertainty.centre_variance(Robust(0, 100), Moved, Lines()) == few_pixels(1200)


def test_the_least_and_the_usual_sigma_of_a_heading():
    assert uncertainty.sigma_mdeg(0, Lines(), 7680) == 3  # no heading is surer
    # 51/1024 px of the centre of a line that is 0.84 radii away, at 30 px
    assert 70 <= uncertainty.sigma_mdeg(0, Lines(102), 7680) <= 72
    assert 140 <= uncertainty.sigma_mdeg(0, Lines(102), 3840) <= 144
    assert uncertainty.sigma_mdeg(0, Lines(102, counted=20), 7680) < 40
    assert uncertainty.sigma_mdeg(2080, Lines(), 7680) == uncertainty.sigma_mdeg(0, Lines(102), 7680)
    # 70 paler than it may be, and as much darker, as defocus makes it
    assert (
        uncertainty.sigma_mdeg(0, Lines(area=276), 7680)
        == uncertainty.sigma_mdeg(0, Lines(area=236), 7680)
        == 3
    )
    assert 69 <= uncertainty.sigma_mdeg(0, Lines(area=166), 7680) <= 71
    assert 155 <= uncertainty.sigma_mdeg(0, Lines(area=346), 7680) <= 158
    assert uncertainty.sigma_q12(0) == 1 and uncertainty.sigma_q12(1 << 20) == 4096


class Blurred:
    """A fit of the blur-model reader: 30 sectors with that mean deviation."""

    used_outer, used_inner = 16, 14

    def __init__(self, deviation_q10, still=True, sigma=0, radius_q8=2560):
        self.deviation_q10, self.radius_q8 = deviation_q10, radius_q8
        self.blur = self
        self.still, self.sigma = still, sigma


def variance(deviation_q10, noise, **of_rings):
    return blurred.centre_variance(Blurred(deviation_q10, **of_rings), noise, 0)


def test_without_noise_deviations_do_not_even_out():
    for noise, known in ((0, 48), (12, 48), (13, 46), (28, 24), (43, 1), (44, 0), (70, 0)):
        assert variance(100, noise) == 1000 + known * known, noise
    assert variance(100, 8, still=False) == 1000 + 30 * 30  # where motion blurs
    far = [variance(deviation, 44) for deviation in (2000, 2048, 2049, 9000)]
    assert far[0] < far[1] == far[2] == far[3] == 2048 * 2048 * 3 // 30


def test_a_13th_of_defocus_beyond_16_tenths_of_a_pixel_counts():
    sigma = len(SIGMAS) - 1
    for over_q10, counted in ((0, 0), (13, 1), (260, 20)):
        radius_q8 = -(-1536 * (1638 + over_q10) // SIGMAS[sigma])
        found = variance(0, 44, sigma=sigma, radius_q8=radius_q8)
        assert abs(found - counted * counted) <= 2 * counted, (over_q10, found)
        assert not variance(0, 44, still=False, sigma=sigma, radius_q8=radius_q8)


class Noisy:
    """Lines that fit, with more noise than tells how blurred they are."""

    residual, noise = 0, 100


def test_the_sigma_of_a_blurred_heading():
    for deviation_q10, expected in ((0, 45), (100, 109), (2048, 2048), (9000, 2048)):
        found = blurred.sigma_mdeg(Blurred(deviation_q10, radius_q8=7700), Noisy, 0)
        assert found == expected, (deviation_q10, found)
    tiny = Blurred(2048, radius_q8=300)
    assert blurred.sigma_mdeg(tiny, Noisy, 0) == 16000  # 16 degrees at most by the fit
    assert 22620 <= blurred.sigma_mdeg(tiny, Noisy, 1 << 20) <= 22630  # and by what is uneven


def reader():
    return DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)


def test_rows_and_columns_cross_a_ring_obliquely():
    made, found = reader(), Detection()
    made.is_turned = True
    made.robust = Robust(0, 100)
    for radius_q8, line_q10, told_q8 in ((7680, 119, 7684), (18000, 119, 18010), (18000, 60, 18002)):
        made.rings.radius_q8, made.rings.line_q10 = radius_q8, line_q10
        made.tell(found)
        assert found.radius_q8 == told_q8, radius_q8
