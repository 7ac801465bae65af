"""Integer trigonometry and roots, against exact or recomputed values."""

from larics.arith import fixed


def sine_q14_reference(angle_turn16):
    """sin by its series, in 2**-30, without floats: the angle is first brought into a quarter turn."""
    angle = angle_turn16 & 65535
    sign = -1 if angle >= 32768 else 1
    angle &= 32767
    if angle > 16384:
        angle = 32768 - angle
    one = 1 << 30
    x = angle * 6746518852 // 65536  # 2 pi * 2**30
    term, total = x, x
    for k in (2, 4, 6, 8, 10, 12):
        term = -term * x // one * x // one // (k * (k + 1))
        total += term
    return sign * ((total + (1 << 15)) >> 16)


def test_sine_everywhere():
    for angle in range(-70000, 140000, 37):
        assert abs(fixed.sin_q14(angle) - sine_q14_reference(angle)) < 2, angle
        assert abs(fixed.cos_q14(angle) - sine_q14_reference(angle + 16384)) < 2, angle


def test_sine_at_the_corners():
    assert [fixed.sin_q14(angle) for angle in (0, 16384, 32768, 49152, 65536)] == [0, 16384, 0, -16384, 0]
    assert fixed.cos_q14(0) == 16384 and fixed.cos_q14(32768) == -16384


def test_arc_tangent_inverts_sine_and_cosine():
    for angle in range(0, 65536, 41):
        # 1 of 16384 in a coordinate is 4 units of angle; longer vectors are more exact
        x, y = 100 * fixed.cos_q14(angle), 100 * fixed.sin_q14(angle)
        difference = (fixed.atan2_turn16(y, x) - angle + 32768 & 65535) - 32768
        assert abs(difference) <= 6, angle


def test_arc_tangent_on_the_axes_and_diagonals():
    for size in (1, 2, 1000, 16383, 16384, 4000000):
        assert fixed.atan2_turn16(0, size) == 0
        assert fixed.atan2_turn16(size, size) == 8192
        assert fixed.atan2_turn16(size, 0) == 16384
        assert fixed.atan2_turn16(0, -size) == 32768
        assert fixed.atan2_turn16(-size, -size) == 40960
        assert fixed.atan2_turn16(-size, 0) == 49152
    assert fixed.atan2_turn16(0, 0) == 0


def test_square_root_is_the_floor():
    for root in (0, 1, 2, 3, 7, 255, 256, 4095, 65535, 1 << 20, (1 << 30) - 1):
        for value in (root * root, root * root + root, root * root + 2 * root):
            assert fixed.isqrt(value) == root, value


def test_angles_survive_both_units():
    for angle_cdeg in range(0, 36000, 7):
        back = fixed.cdeg_from_turn16(fixed.turn16_from_cdeg(angle_cdeg))
        assert abs(fixed.wrap_cdeg(back - angle_cdeg)) <= 1, angle_cdeg
        assert 0 <= back < 36000
    assert fixed.turn16_from_cdeg(9000) == 16384 and fixed.turn16_from_cdeg(-9000) == 49152
    assert fixed.cdeg_from_turn16(65535) in (0, 35999)


def test_wrap():
    assert [fixed.wrap_cdeg(a) for a in (0, 18000, -18000, 17999, 36000, 54000, -1)] == [
        0,
        -18000,
        -18000,
        17999,
        0,
        -18000,
        -1,
    ]


def test_tables_have_their_length():
    assert len(memoryview(fixed.tables.COSINE_Q14_BIASED)) == 2 * 320
    assert len(memoryview(fixed.tables.LOG_GREY_Q8)) == 2 * 256
