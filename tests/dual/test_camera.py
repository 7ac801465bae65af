"""larics.locate.camera_model on both interpreters: the same numbers, and no allocation for a marker.

The expected values come from the floating-point model of tests/host/test_camera.py."""

from larics.locate.camera_model import Camera, Measurement
from larics.marker.detection import Detection

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock


def tilted_camera():
    return Camera(
        360,
        296,
        171977,
        center_x_q8=46000,
        center_y_q8=37700,
        k1_e5=-12000,
        k2_e5=3000,
        mount_cdeg=3000,
        tilt_forward_cdeg=200,
        tilt_left_cdeg=-150,
        camera_x_mm10=1000,
        camera_y_mm10=-500,
        camera_z_mm10=1500,
        ceiling_mm10=30000,
    )


def seen(x_q8, y_q8, heading_cdeg, radius_q8):
    detection = Detection()
    detection.marker_id = 3
    detection.x_q8, detection.y_q8 = x_q8, y_q8
    detection.heading_cdeg, detection.radius_q8 = heading_cdeg, radius_q8
    return detection


# (x, y, angle, radius) in the image -> (offset x, offset y, height, height by ring, heading)
EXPECTED = (
    ((44727, 34926, 10760, 9027), (2500, -1200, 30000, 30000, 1234)),
    ((52177, 69593, 27944, 9021), (-3100, -3000, 30000, 30000, 20050)),
    ((58543, 44378, 11999, 9069), (0, 0, 30000, 30002, 0)),
    ((64269, 6337, 2989, 8955), (5000, 4000, 30000, 29999, 9000)),
    ((52026, 35546, 12003, 9049), (1805, -203, 30000, 30000, 35999)),
)


def test_the_same_numbers_on_every_interpreter():
    camera, out = tilted_camera(), Measurement()
    for pixels, vehicle in EXPECTED:
        assert camera.locate(seen(*pixels), out)
        got = (out.offset_x_mm10, out.offset_y_mm10, out.height_mm10, out.ring_height_mm10, out.heading_cdeg)
        assert got == vehicle, (pixels, got)


def test_default_mounting():
    camera, out = Camera(360, 296, 671 * 256), Measurement()
    for image_cdeg in (0, 1, 9000, 27000, 35999):
        assert camera.locate(seen(camera.center_x_q8, camera.center_y_q8, image_cdeg, 33 * 256 + 141), out)
        assert out.heading_cdeg == (9000 - image_cdeg) % 36000
        assert out.offset_x_mm10 == 0 and out.offset_y_mm10 == 0
        assert 29990 < out.height_mm10 < 30010


def test_a_marker_allocates_nothing():
    camera, out, detection = tilted_camera(), Measurement(), seen(20000, 60000, 12345, 8600)
    camera.locate(detection, out)
    heap_lock()
    try:
        for _ in range(50):
            detection.x_q8 += 700
            detection.heading_cdeg = (detection.heading_cdeg + 777) % 36000
            found = camera.locate(detection, out, 1500, 29000)
    finally:
        heap_unlock()
    assert found


def is_accepted(**change):
    values = {"width": 360, "height": 296, "focal_q8": 171977}
    values.update(change)
    try:
        Camera(**values)
    except ValueError:
        return False
    return True


def test_the_limits_of_what_can_be():
    for least, most, change in (
        (2048, 2049, {"width": 0, "focal_q8": 400000}),
        (2048, 2049, {"height": 0, "focal_q8": 400000}),
        (3000, 3001, {"tilt_left_cdeg": 0}),
        (-3000, -3001, {"tilt_forward_cdeg": 0}),
        (100000, 100001, {"k1_e5": 0}),
        (-100000, -100001, {"k2_e5": 0}),
        (262143, 262144, {"ceiling_mm10": 0}),
        (42056, 42055, {"focal_q8": 0}),  # the corner lies 54.7 degrees off the axis
        (58000, 57000, {"focal_q8": 0, "k1_e5": 100000}),  # where 25 rounds undo the distortion
    ):
        name = min([key for key in change if not change[key]])
        for value, expected in ((least, True), (most, False)):
            change[name] = value
            assert is_accepted(**change) == expected, change


def test_what_cannot_be_is_refused():
    out = Measurement()
    assert not Camera(360, 296, 671 * 256).locate(seen(40000, 40000, 0, 0), out)
    for change in (
        {"width": 0},
        {"focal_q8": 1},
        {"tilt_left_cdeg": 4000},
        {"k1_e5": -99999, "focal_q8": 40000},
        {"ceiling_mm10": 100, "camera_z_mm10": 200},
    ):
        assert not is_accepted(**change), change
