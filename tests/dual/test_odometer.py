"""larics_vehicle.odometer: a drive around a square, what is left of small steps, and the message of it."""

from larics.wire import messages as m
from larics.wire.codec import Encoder
from larics_vehicle.odometer import Odometer
from wire_values import named

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock


def drive(odometer, steps, forward_um, turn_mcdeg):
    for _ in range(steps):
        odometer.move(forward_um, turn_mcdeg, 0)


def test_a_square_ends_where_it_began():
    odometer = Odometer()
    for side in range(4):
        drive(odometer, 150, 20000, 0)  # 3 m
        corner = ((30000, 0), (30000, 30000), (0, 30000), (0, 0))[side]
        assert abs(odometer.x_mm10 - corner[0]) <= 5 and abs(odometer.y_mm10 - corner[1]) <= 5
        drive(odometer, 90, 0, 100000)
        assert odometer.heading_cdeg == (side + 1) * 9000 % 36000


def test_a_circle_and_the_way_back():
    odometer = Odometer()
    drive(odometer, 1800, 1745, 20000)  # 0.2 degrees and 1.745 mm a step: a circle of 0.5 m
    assert abs(odometer.x_mm10) <= 20 and abs(odometer.y_mm10) <= 20 and odometer.heading_cdeg == 0
    drive(odometer, 900, -1745, -20000)
    assert abs(odometer.x_mm10) <= 20 and abs(odometer.y_mm10 - 10000) <= 40
    assert odometer.heading_cdeg == 18000


def test_small_steps_are_not_lost():
    odometer = Odometer()
    drive(odometer, 1000, 7, 30)
    assert abs(odometer.x_mm10 - 70) <= 1 and odometer.heading_cdeg == 30
    odometer = Odometer()
    drive(odometer, 1000, -7, -30)
    assert abs(odometer.x_mm10 + 70) <= 1 and odometer.heading_cdeg == 35970


def test_the_message_tells_its_age_across_the_clock_s_end():
    odometer = Odometer(epoch=255)
    odometer.move(20000, 0, m.COUNT_MAX - 1000)
    told = named(m.ODOMETRY, odometer.message(500, m.ODOMETRY_SLIP))
    assert (told["time_us"], told["age_us"]) == (m.COUNT_MAX - 1000, 1501)
    assert (told["x_mm10"], told["epoch"], told["flags"]) == (200, 255, m.ODOMETRY_SLIP)
    assert Encoder().encode(m.ODOMETRY, odometer.message(500)) == 30
    odometer.reset()
    told = named(m.ODOMETRY, odometer.message(500))
    assert (told["x_mm10"], told["heading_cdeg"], told["epoch"]) == (0, 0, 0)


def test_nothing_is_allocated():
    odometer, encoder = Odometer(), Encoder()
    odometer.move(1, 1, 1)
    encoder.encode(m.ODOMETRY, odometer.message(2))
    heap_lock()
    try:
        for k in range(50):
            odometer.move(20000, 100000, k)
            encoder.encode(m.ODOMETRY, odometer.message(k))
    finally:
        heap_unlock()
    assert odometer.x_mm10
