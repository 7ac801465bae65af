"""What sigma is made of: the systematic parts, and the model of the odometry."""

from larics.locate.camera_model import Measurement
from larics.locate.uncertainty import OdometryNoise, Systematic, log2_q4, root_of_squares

NAMES = ("map_mm10", "map_cdeg", "focal_ppm", "height_mm10", "tilt_cdeg", "mount_cdeg", "camera_mm10")


def measured(x_mm10, y_mm10, height_mm10=30000):
    out = Measurement()
    out.offset_x_mm10, out.offset_y_mm10, out.height_mm10 = x_mm10, y_mm10, height_mm10
    return out


def only(**given):
    return Systematic(**dict({name: 0 for name in NAMES}, **given))


def test_each_part_by_itself():
    for given, offset, expected in (
        ({"map_mm10": 25}, (0, 0), 25),
        ({"camera_mm10": 14}, (5000, 5000), 14),
        ({"focal_ppm": 2000}, (6000, 0), 12),
        ({"focal_ppm": 2000}, (0, 0), 0),
        ({"height_mm10": 300}, (0, -6000), 60),
        ({"tilt_cdeg": 10}, (0, 0), 52),  # 3 m times 0.1 degrees
        ({"mount_cdeg": 10}, (6000, 0), 10),
        ({"map_cdeg": 10}, (-6000, 0), 10),
    ):
        assert only(**given).of_place(measured(*offset)) == expected, given
    assert only(tilt_cdeg=10, lens_mm10=15000).of_place(measured(0, 0)) == 26  # above the lens, not the floor
    assert only(map_cdeg=3, mount_cdeg=4).of_heading() == 5


def test_an_entry_of_the_map_may_know_better():
    usual = only(map_mm10=25, map_cdeg=10)
    assert usual.of_place(measured(0, 0), 7, 0) == 7 and usual.of_heading(4) == 4
    assert usual.of_place(measured(6000, 0), 1, 100) == 105


def test_the_parts_add_up_and_nothing_overflows():
    assert only(map_mm10=30, camera_mm10=40).of_place(measured(0, 0)) == 50
    most = Systematic(10000, 9000, 100000, 10000, 3000, 9000, 10000)
    for height_mm10 in (0, 1, 300000):
        found = most.of_place(measured(1 << 20, -(1 << 20), height_mm10), 10000, 9000)
        assert 10000 <= found < 1 << 15, found
    assert root_of_squares(20000, 20000) == 28284
    assert (root_of_squares(4, 11), root_of_squares(2, 11), root_of_squares(3, 4)) == (12, 11, 5)  # rounded
    assert only(focal_ppm=2000).of_place(measured(200000, 0)) == 200  # nothing is farther than 10 m
    assert only(map_mm10=10000).of_place(measured(0, 0)) == only(map_mm10=30000).of_place(measured(0, 0))


def test_logarithms():
    for value, unit, expected in ((2500, 2500, 0), (5000, 2500, 16), (3, 2, 8), (1, 4, -32), (0, 9, -192)):
        assert log2_q4(value, unit) == expected
    assert abs(log2_q4(250000, 2500) - 106) <= 1


def test_the_model_in_its_own_units():
    model = OdometryNoise(7000, -7000, 2700, noise_mm2_km=500, track_mm=600)
    assert (model.scale_q20, model.turn_q20) == (7340, -7341)
    assert abs(model.drift_q20 - 49414) < 10  # 47 urad/mm
    assert (model.noise_q4, model.half_track_mm, model.track_q4) == (-39, 300, -32)
