"""larics.locate.camera_model against a floating-point 3-D model, and the conventions of angles and frames."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from larics.locate.camera_model import Camera, Measurement
from larics.marker.detection import NO_SIGMA, Detection
from tests.host.camera_model import FloatCamera, angle_difference, rotation
from tests.host.small_int import Small

FOCAL_30_DEG = 180 / math.tan(math.radians(15))  # 360 px wide, 30 degrees: the published camera


def make_pair(
    width=360,
    height=296,
    focal=FOCAL_30_DEG,
    center=None,
    k1=0.0,
    k2=0.0,
    mount=0.0,
    mirrored=False,
    tilt_forward=0.0,
    tilt_left=0.0,
    position=(0.0, 0.0, 0.0),
    ceiling=0.0,
):
    """The integer camera and its oracle with the very same (rounded) parameters."""
    focal_q8 = round(focal * 256)
    q8 = [None, None] if center is None else [round(c * 256) for c in center]
    k1_e5, k2_e5 = round(k1 * 1e5), round(k2 * 1e5)
    mount, tilt_forward, tilt_left = (round(a * 100) for a in (mount, tilt_forward, tilt_left))
    position = [round(p * 10) for p in position]
    camera = Camera(
        width,
        height,
        focal_q8,
        q8[0],
        q8[1],
        k1_e5,
        k2_e5,
        mount,
        mirrored,
        tilt_forward,
        tilt_left,
        position[0],
        position[1],
        position[2],
        round(ceiling * 10),
    )
    model = FloatCamera(
        width,
        height,
        focal_q8 / 256,
        center and (q8[0] / 256, q8[1] / 256),
        k1_e5 / 1e5,
        k2_e5 / 1e5,
        mount / 100,
        mirrored,
        tilt_forward / 100,
        tilt_left / 100,
        [p / 10 for p in position],
    )
    return camera, model


def detect(model, x, y, z, heading, outer=150.0):
    px, py, angle, radius = model.view(x, y, z, heading, outer)
    d = Detection()
    d.marker_id = 5
    d.x_q8, d.y_q8, d.radius_q8 = round(px * 256), round(py * 256), round(radius * 256)
    d.heading_cdeg = round(angle * 100) % 36000
    return d, px, py


# ------------------------------------------------------------------ conventions


def test_default_mounting_turns_image_angles_into_90_degrees_minus_a():
    camera, _ = make_pair(ceiling=3000)
    out, d = Measurement(), Detection()
    d.x_q8, d.y_q8, d.radius_q8 = camera.center_x_q8, camera.center_y_q8, 30 * 256
    for image_cdeg in range(0, 36000, 777):
        d.heading_cdeg = image_cdeg
        assert camera.locate(d, out)
        assert out.heading_cdeg == (9000 - image_cdeg) % 36000
        assert (out.offset_x_mm10, out.offset_y_mm10, out.height_mm10) == (0, 0, 30000)


def test_top_of_the_image_is_forward_and_image_right_is_vehicle_left():
    camera, _ = make_pair(ceiling=3000)
    out, d = Measurement(), Detection()
    d.radius_q8 = 30 * 256
    d.x_q8, d.y_q8 = camera.center_x_q8, camera.center_y_q8 - 100 * 256
    assert camera.locate(d, out) and out.offset_x_mm10 > 4000 and out.offset_y_mm10 == 0
    d.x_q8, d.y_q8 = camera.center_x_q8 + 100 * 256, camera.center_y_q8
    assert camera.locate(d, out) and out.offset_x_mm10 == 0 and out.offset_y_mm10 > 4000


def test_positive_tilts_see_what_is_in_front_and_on_the_left():
    out, d = Measurement(), Detection()
    d.radius_q8 = 30 * 256
    for tilts, axis in ((dict(tilt_forward=10), "offset_x_mm10"), (dict(tilt_left=10), "offset_y_mm10")):
        for mount in (0, 90, 213):
            camera, _ = make_pair(ceiling=3000, mount=mount, **tilts)
            d.x_q8, d.y_q8 = camera.center_x_q8, camera.center_y_q8
            assert camera.locate(d, out)
            assert getattr(out, axis) == pytest.approx(30000 * math.tan(math.radians(10)), abs=1)


@given(
    vx=st.floats(-5e3, 5e3),
    vy=st.floats(-5e3, 5e3),
    vehicle=st.floats(0, 360),
    marker=st.floats(0, 360),
    dx=st.floats(-300, 300),
    dy=st.floats(-300, 300),
)
def test_map_pose_follows_from_offset_and_heading(vx, vy, vehicle, marker, dx, dy):
    """DESIGN: vehicle heading = marker heading - beta; position = marker - offset turned by that heading."""
    camera, model = make_pair(ceiling=3000)
    mx, my = vx + dx, vy + dy
    in_vehicle = rotation("z", -vehicle) @ [mx - vx, my - vy, 0]
    d, _, _ = detect(model, in_vehicle[0], in_vehicle[1], 3000, marker - vehicle)
    out = Measurement()
    assert camera.locate(d, out)
    heading = marker - out.heading_cdeg / 100
    assert abs(angle_difference(heading, vehicle)) < 0.0151
    back = rotation("z", heading) @ [out.offset_x_mm10 / 10, out.offset_y_mm10 / 10, 0]
    assert math.hypot(mx - back[0] - vx, my - back[1] - vy) < 0.3


# ------------------------------------------------------------------ accuracy

# Stated bounds at 3 m, the published camera: 0.12 mm for each axis, 0.02 degrees; the share of the
# detection's own rounding (q8, cdeg) is in them.


@settings(max_examples=300)
@given(data=st.data())
def test_offset_and_heading_with_everything_switched_on(data):
    number = lambda low, high: data.draw(st.floats(low, high))  # noqa: E731
    camera, model = make_pair(
        center=(number(160, 200), number(130, 165)),
        k1=number(-0.4, 0.4),
        k2=number(-0.3, 0.3),
        mount=number(-180, 180),
        mirrored=data.draw(st.booleans()),
        tilt_forward=number(-12, 12),
        tilt_left=number(-12, 12),
        position=(number(-300, 300), number(-300, 300), number(0, 300)),
        ceiling=3000,
    )
    px, py = number(5, 354), number(5, 290)
    z = 3000.0
    # a ground point whose pixel is near (px, py): any will do, so step along the vehicle's axes
    flat = model.to_vehicle @ [
        (-1 if model.mirrored else 1) * (px - model.center[0]) / model.focal,
        (py - model.center[1]) / model.focal,
        1,
    ]
    scale = (z - model.position[2]) / flat[2]
    x, y = model.position[0] + flat[0] * scale, model.position[1] + flat[1] * scale
    heading = number(0, 360)
    d, _, _ = detect(model, x, y, z, heading)
    out = Measurement()
    assert camera.locate(d, out)
    assert abs(out.offset_x_mm10 / 10 - x) < 0.12 and abs(out.offset_y_mm10 / 10 - y) < 0.12
    assert abs(angle_difference(out.heading_cdeg / 100, heading)) < 0.02
    assert out.height_mm10 == 30000
    above = z - model.position[2]
    # the area of the ring is taken to second order only; the rest is the rounding of the radius
    assert abs(out.ring_height_mm10 / 10 - z) < above * (0.0012 + 0.6 / d.radius_q8)


@settings(max_examples=150)
@given(
    k1=st.floats(-0.15, 0.1),
    k2=st.floats(0, 0.08),
    px=st.floats(2, 317),
    py=st.floats(2, 237),
    heading=st.floats(0, 360),
    z=st.floats(1500, 8000),
)
def test_wide_lens(k1, k2, px, py, heading, z):
    """QVGA behind a 2.8 mm lens, 71 degrees: strong distortion, markers near the corners."""
    camera, model = make_pair(320, 240, focal=225, k1=k1, k2=k2, ceiling=round(z, 1))
    z = round(z, 1)
    u, v = (px - model.center[0]) / model.focal, (py - model.center[1]) / model.focal
    flat = model.to_vehicle @ [u, v, 1]
    x, y = flat[0] * z, flat[1] * z
    d, at_x, at_y = detect(model, x, y, z, heading)
    assume(0 <= at_x <= 319 and 0 <= at_y <= 239)
    out = Measurement()
    assert camera.locate(d, out)
    pixel_mm = z / 225 / 256 * 2.5  # half a q8 step in each axis, stretched by the lens at the corner
    assert math.hypot(out.offset_x_mm10 / 10 - x, out.offset_y_mm10 / 10 - y) < 0.12 + z / 20000 + pixel_mm
    assert abs(angle_difference(out.heading_cdeg / 100, heading)) < 0.03


@settings(max_examples=150)
@given(
    x=st.floats(-250, 250),
    y=st.floats(-250, 250),
    z=st.floats(1800, 6000),
    outer=st.sampled_from([75.0, 150.0]),
)
def test_height_from_the_rings(x, y, z, outer):
    camera, model = make_pair(tilt_forward=3, tilt_left=-2, k1=-0.1)
    d, _, _ = detect(model, x, y, z, 33, outer)
    out = Measurement()
    assert camera.locate(d, out, outer_mm10=round(outer * 10))
    assert out.height_mm10 == out.ring_height_mm10
    assert abs(out.height_mm10 / 10 - z) < z * (0.0004 + 0.6 / d.radius_q8)


def test_a_known_height_of_one_marker_overrides_the_ceiling():
    camera, model = make_pair(ceiling=3000, position=(0, 0, 200))
    d, _, _ = detect(model, 120, -80, 2500, 10)
    out = Measurement()
    assert camera.locate(d, out, height_mm10=25000)
    assert (out.height_mm10, out.offset_x_mm10, out.offset_y_mm10) == (25000, 1200, -800)
    assert abs(out.ring_height_mm10 - 25000) < 30


def test_a_mirrored_sensor_reads_the_coding_lines_in_the_opposite_order():
    camera, model = make_pair(mirrored=True, ceiling=3000)
    d, _, _ = detect(model, 0, 0, 3000, 0)
    out = Measurement()
    for seen, really in ((-1, -1), (0, 0), (1, 4), (3, 6), (4, 1), (5, 5), (6, 3), (7, 7)):
        d.marker_id = seen
        assert camera.locate(d, out) and out.marker_id == really


# ------------------------------------------------------------------ small integers


@settings(max_examples=300)
@given(data=st.data())
def test_every_intermediate_is_a_small_integer_whatever_is_detected(data):
    whole = lambda low, high: data.draw(st.integers(low, high))  # noqa: E731
    width, height = data.draw(st.sampled_from([(360, 296), (320, 240), (640, 480), (1280, 800)]))
    try:
        camera = Camera(
            width,
            height,
            whole(width * 90, (1 << 20) - 1),
            k1_e5=whole(-60000, 60000),
            k2_e5=whole(-60000, 60000),
            mount_cdeg=whole(-36000, 36000),
            mirrored=whole(0, 1),
            tilt_forward_cdeg=whole(-3000, 3000),
            tilt_left_cdeg=whole(-3000, 3000),
            camera_z_mm10=whole(0, 5000),
            ceiling_mm10=whole(0, 1) and whole(6000, 260000),
        )
    except ValueError:
        assume(False)
    for name, value in vars(camera).items():
        if type(value) is int:
            setattr(camera, name, Small(value))
    camera._matrix = tuple(map(Small, camera._matrix))
    camera._untilted = tuple(map(Small, camera._untilted))
    d = Detection()
    d.marker_id = Small(3)
    d.x_q8, d.y_q8 = Small(whole(-(1 << 20), 1 << 20)), Small(whole(-(1 << 20), 1 << 20))
    if whole(0, 3):
        d.x_q8, d.y_q8 = Small(whole(0, width * 256)), Small(whole(0, height * 256))
    d.heading_cdeg, d.radius_q8 = Small(whole(0, 35999)), Small(whole(0, 1 << 20))
    out = Measurement()
    if camera.locate(d, out, outer_mm10=Small(whole(100, 4000))):
        assert 0 <= out.heading_cdeg < 36000


# ------------------------------------------------------------------ bad input


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(width=0), "frame 0x296"),
        (dict(focal_q8=100), "focal length"),
        (dict(focal_q8=100 * 256), "too short"),
        (dict(k1_e5=200000), "distortion"),
        (dict(tilt_left_cdeg=4000), "tilt"),
        (dict(ceiling_mm10=1000, camera_z_mm10=2000), "above the lens"),
        (dict(focal_q8=300 * 256, k1_e5=-90000), "corner"),
    ],
)
def test_impossible_cameras_are_refused_in_one_line(change, words):
    with pytest.raises(ValueError) as caught:
        Camera(**dict(dict(width=360, height=296, focal_q8=672 * 256), **change))
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_places_no_marker_can_be_at_are_refused():
    camera, _ = make_pair()
    d, out = Detection(), Measurement()
    d.x_q8, d.y_q8, d.radius_q8 = 180 * 256, 148 * 256, 0
    assert not camera.locate(d, out)
    d.radius_q8 = 300
    assert not camera.locate(d, out)
    d.radius_q8, d.x_q8 = 30 * 256, 1 << 24
    assert not camera.locate(d, out)


def test_a_measurement_tells_the_sigma_of_the_place_it_gives():
    camera, out, d = Camera(360, 296, focal_q8=600 << 8), Measurement(), Detection()
    d.x_q8, d.y_q8, d.radius_q8, d.heading_cdeg = 180 << 8, 148 << 8, 30 << 8, 0
    assert camera.locate(d, out, 1500, 30000)
    assert (out.sigma_q12, out.sigma_mdeg, out.sigma_mm10) == (NO_SIGMA, NO_SIGMA, NO_SIGMA)
    d.sigma_q12, d.sigma_mdeg = 410, 100  # a tenth of a px, a tenth of a degree
    assert camera.locate(d, out, 1500, 30000)
    assert (out.sigma_q12, out.sigma_mdeg) == (410, 100)
    assert out.sigma_mm10 == 30000 * 410 // (4096 * 600)  # 0.5 mm at 3 m
    d.x_q8, d.sigma_mdeg = 340 << 8, 1000  # 800 mm away a degree is more
    assert camera.locate(d, out, 1500, 30000)
    assert abs(out.sigma_mm10 - 139) <= 2
