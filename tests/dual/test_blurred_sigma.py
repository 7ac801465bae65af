"""How sure the blur-model reader takes its centre and heading to be, at each limit."""

from larics.arith.fixed import cos_q14
from larics.blurred import uncertainty


class Fitted:
    """Rings of 30 px and lines as a fit left them; one side of the rings is so much paler, or lighter."""

    def __init__(self, paler_q10=0, lighter_q10=0, still=1, sigma=5, deviation_q10=0, noise=0, residual=0):
        self.blur = self
        self.still = still
        self.sigma = sigma
        self.radius_q8 = 7680
        self.deviation_q10 = deviation_q10
        self.used_outer = self.used_inner = 32
        self.noise = noise
        self.residual = residual
        self.levels = []
        for uneven_q10 in (paler_q10, lighter_q10):
            for sector in range(32):
                self.levels.append(2000 + (2 * 2000 * uneven_q10 * cos_q14(2048 * sector + 300) >> 24))

    def heading(self):
        return uncertainty.sigma_mdeg(self, self, uncertainty.uneven_square(self))

    def variance(self):
        return uncertainty.centre_variance(self, self.noise, uncertainty.uneven_square(self))


def assert_heading(fitted, shift_q10):
    """100/1024 px turn a radius of 30 px by 0.187 degrees; 0.045 degrees at least."""
    turned = shift_q10 * 187 // 100
    expected = uncertainty.isqrt(45 * 45 + turned * turned)
    assert abs(fitted.heading() - expected) <= 1 + expected // 25, (shift_q10, fitted.heading(), expected)


def test_rings_that_look_paler_on_one_side_are_less_sure():
    for paler_q10, lighter_q10, still, expected in (
        (0, 0, 1, 0),
        (20, 10, 1, 0),
        (60, 0, 1, 40),
        (0, 60, 1, 100),  # 50 doubled
        (60, 60, 1, 108),
        (60, 60, 0, 0),  # motion blurs each direction differently
    ):
        fitted = Fitted(paler_q10, lighter_q10, still)
        assert abs(uncertainty.uneven_square(fitted) - expected * expected) <= 6 * expected + 1, expected
        assert fitted.variance() == uncertainty.uneven_square(fitted)
        assert_heading(fitted, expected)


def test_a_line_sharper_than_directions_are_apart_is_less_sure():
    for sigma, noise, deviation_q10, expected in (
        (2, 64, 100, 109),  # 0.1 degrees for 0.1 px, and 0.045
        (1, 64, 100, 282),  # twice as much, and 0.2
        (1, 65, 100, 109),
        (1, 64, 0, 200),
    ):
        found = Fitted(sigma=sigma, noise=noise, deviation_q10=deviation_q10).heading()
        assert abs(found - expected) <= 1, (sigma, noise, deviation_q10, found)
    assert_heading(Fitted(residual=125), 100)  # four fifths of what is no line
    fitted = Fitted(sigma=15)  # defocus: half of what it shifts the centre
    shift_q10 = uncertainty.isqrt(fitted.variance())
    assert shift_q10 > 60
    assert_heading(fitted, shift_q10 // 2)


def test_deviation_counts_as_noise_where_there_is_noise():
    for noise, expected in ((12, 4800), (28, 2400), (44, 0)):  # hundredths of 100, and what evens out
        known = expected // 100
        assert Fitted(noise=noise, deviation_q10=100).variance() == 468 + known * known, noise
