"""The renderer's geometry against a ray tracer that shares no code with it, and against OpenCV."""

import math

import cv2
import numpy as np
import pytest

from larics.marker import LARICS3
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.plates import Plate, tag_side_mm
from larics_host.render.scene import Scene, Surface
from larics_host.render.view import render_radiance, truth_of

PLAIN = Surface(reflectance=0.6, speckle=0.0, stain=0.0)


def turn_z(angle):
    return np.array(
        [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1.0]]
    )


def camera_axes(mounting_deg=0.0, tilt_deg=0.0, towards_deg=0.0):
    """Columns: image right, image down, out of the lens, in the vehicle frame, by the definitions alone."""
    top = turn_z(math.radians(mounting_deg)) @ [1.0, 0, 0]
    out = np.array([0, 0, 1.0])
    right = np.cross(-top, out)  # x = y cross z of a right-handed camera whose y is down
    towards = math.radians(towards_deg)
    lean = turn_z(towards)
    tilt = math.radians(tilt_deg)
    about_y = np.array([[math.cos(tilt), 0, math.sin(tilt)], [0, 1, 0], [-math.sin(tilt), 0, math.cos(tilt)]])
    return lean @ about_y @ lean.T @ np.stack([right, -top, out], axis=1)


def ink(u, v, marker_id):
    """Whether plate points are black, from the family's numbers."""
    family, radius = LARICS3, np.hypot(u, v)
    half = family.line_mm10 / 20
    black = np.abs(radius - family.outer_mm10 / 10) < half
    black |= np.abs(radius - family.inner_mm10 / 10) < half
    black |= (np.abs(v) < half) & (u > family.outer_mm10 / 10) & (u < family.orientation_end_mm10 / 10)
    start, end = family.code_start_mm10 / 10, family.code_end_mm10 / 10
    if marker_id & 4:
        black |= (np.abs(u) < half) & (v > start) & (v < end)
    if marker_id & 2:
        black |= (np.abs(v) < half) & (-u > start) & (-u < end)
    if marker_id & 1:
        black |= (np.abs(u) < half) & (-v > start) & (-v < end)
    return black


class Tracer:
    """Rays through a grid of points of every pixel at instants of its row's exposure."""

    def __init__(self, camera, pose, motion, ceiling_mm, plate):
        self.camera, self.pose, self.motion = camera, pose, motion
        self.ceiling_mm, self.plate = ceiling_mm, plate
        self.axes = camera_axes(camera.mounting_deg, camera.tilt_deg, camera.tilt_direction_deg)

    def vehicle(self, time):
        """Position and heading by small Euler steps from the middle of the frame."""
        steps = 40
        heading = math.radians(self.pose.heading_deg)
        x, y = self.pose.x_mm, self.pose.y_mm
        dt, rate = time / steps, math.radians(self.motion.turn_deg_s)
        for _ in range(steps):
            middle = heading + rate * dt / 2
            x += dt * (math.cos(middle) * self.motion.forward_mm_s - math.sin(middle) * self.motion.left_mm_s)
            y += dt * (math.sin(middle) * self.motion.forward_mm_s + math.cos(middle) * self.motion.left_mm_s)
            heading += rate * dt
        return x, y, heading

    def undistort(self, x, y):
        distorted = np.hypot(x, y)
        radius = distorted.copy()
        for _ in range(60):
            radius = distorted / (1 + self.camera.k1 * radius**2 + self.camera.k2 * radius**4)
        factor = np.where(distorted > 0, radius / np.maximum(distorted, 1e-12), 1.0)
        return x * factor, y * factor

    def plate_point(self, px, py, vehicle):
        camera = self.camera
        x = (px - camera.center_x_px) / camera.focal_px * (-1 if camera.mirrored else 1)
        x, y = self.undistort(x, (py - camera.center_y_px) / camera.focal_px)
        ray = np.stack([x, y, np.ones_like(x)], axis=-1) @ self.axes.T
        ray *= (self.ceiling_mm / ray[..., 2])[..., None]
        ray[..., 0] += camera.offset_x_mm
        ray[..., 1] += camera.offset_y_mm
        vx, vy, heading = vehicle
        place = ray @ turn_z(heading).T
        east, north = (
            place[..., 0] + vx - self.plate.pose.x_mm,
            place[..., 1] + vy - self.plate.pose.y_mm,
        )
        along = math.radians(self.plate.pose.heading_deg)
        # counterclockwise for one who looks up is clockwise in the map
        u = math.cos(along) * east + math.sin(along) * north
        v = math.sin(along) * east - math.cos(along) * north
        return u, v

    def image(self):
        camera = self.camera
        grid, instants = (6, 12) if camera.exposure_us else (12, 1)
        offsets = (np.arange(grid) + 0.5) / grid - 0.5
        px = np.arange(camera.width)[:, None] + offsets
        result = np.zeros((camera.height, camera.width))
        for row in range(camera.height):
            row_time = (row - (camera.height - 1) / 2) * camera.row_us * 1e-6
            for instant in (np.arange(instants) + 0.5) / instants - 0.5:
                vehicle = self.vehicle(row_time + instant * camera.exposure_us * 1e-6)
                for dy in offsets:
                    u, v = self.plate_point(px, np.full_like(px, row + dy), vehicle)
                    value = np.where(np.hypot(u, v) < LARICS3.plate_mm10 / 10, 1.0, PLAIN.reflectance)
                    value[ink(u, v, self.plate.marker_id)] = 0.0
                    result[row] += value.mean(axis=1)
        return result / (instants * grid)


CASES = {
    "level": (Camera(width=92, height=80, focal_px=400.0), Motion(), 3000.0, 1),
    "everything": (
        Camera(
            width=92,
            height=80,
            focal_px=300.0,
            center_x_px=43.0,
            center_y_px=41.2,
            k1=-0.25,
            k2=0.1,
            mounting_deg=20.0,
            tilt_deg=12.0,
            tilt_direction_deg=70.0,
            offset_x_mm=40.0,
            offset_y_mm=-25.0,
            row_us=150.0,
            exposure_us=9000.0,
        ),
        Motion(900.0, 500.0, 90.0),
        2000.0,
        5,
    ),
    "mirrored": (
        Camera(width=92, height=80, focal_px=300.0, mirrored=True, tilt_deg=5.0),
        Motion(),
        2200.0,
        6,
    ),
}


def placed(camera, ceiling_mm, marker_id, heading_deg):
    """A pose, and a plate that it sees a little off the middle of the picture."""
    axes = camera_axes(camera.mounting_deg, camera.tilt_deg, camera.tilt_direction_deg)
    axis = axes[:, 2] * ceiling_mm / axes[2, 2]
    pose = Pose(1234.5, -567.8, 33.0)
    x, y, _ = turn_z(math.radians(pose.heading_deg)) @ (
        axis + np.array([camera.offset_x_mm + 17.3, camera.offset_y_mm - 22.1, 0])
    )
    return pose, Plate(marker_id, Pose(pose.x_mm + x, pose.y_mm + y, heading_deg))


@pytest.mark.parametrize("case", CASES)
def test_picture_and_truth_agree_with_ray_tracing(case):
    camera, motion, ceiling_mm, marker_id = CASES[case]
    pose, plate = placed(camera, ceiling_mm, marker_id, 151.0)
    scene = Scene(ceiling_mm=ceiling_mm, surface=PLAIN, plates=(plate,))
    image = render_radiance(scene, pose, motion, camera)
    tracer = Tracer(camera, pose, motion, ceiling_mm, plate)
    traced = tracer.image()
    assert np.abs(image - traced).max() < 0.12
    assert np.abs(image - traced).mean() < 0.006

    # the shift and the turn between both pictures, by least squares over their gradients
    truth = truth_of(scene, pose, motion, camera)[0]
    down, right = np.gradient(traced)
    y, x = np.mgrid[: camera.height, : camera.width]
    around = (x - truth.x_px) * down - (y - truth.y_px) * right
    inside = np.hypot(x - truth.x_px, y - truth.y_px) < 1.8 * truth.radius_px
    model = np.stack([right[inside], down[inside], around[inside]], axis=1)
    shift, *_ = np.linalg.lstsq(model, (image - traced)[inside], rcond=None)
    assert np.hypot(shift[0], shift[1]) < 0.002
    assert abs(math.degrees(shift[2])) < 0.02

    # the truth lies where the tracer's ray of that row's instant hits the marker's centre
    def centre_at(px, py):
        time = (py - (camera.height - 1) / 2) * camera.row_us * 1e-6
        u, v = tracer.plate_point(np.array([px]), np.array([py]), tracer.vehicle(time))
        return u[0], v[0]

    # 0.001 px is 7 micrometres on the ceiling
    assert np.hypot(*centre_at(truth.x_px, truth.y_px)) < 0.001 * ceiling_mm / camera.focal_px
    # and the heading points at the middle of the orientation line
    reach = np.linspace(0.5, 2.5, 4001) * truth.radius_px
    angle = math.radians(truth.heading_deg)
    far_x, far_y = truth.x_px + reach * math.cos(angle), truth.y_px - reach * math.sin(angle)
    places = np.array([centre_at(a, b) for a, b in zip(far_x[::40], far_y[::40], strict=True)])
    nearest = np.argmin(np.abs(places[:, 0] - 190.0))
    assert abs(places[nearest, 1]) < 0.2


def test_projection_agrees_with_opencv():
    camera = Camera(focal_px=550.0, center_x_px=180.3, center_y_px=146.0, k1=-0.21, k2=0.05, tilt_deg=8.0)
    points = np.random.default_rng(5).uniform(-600, 600, (50, 3)) + np.array([0, 0, 2500])
    rotation = camera_axes(0.0, 8.0, 0.0).T  # vehicle -> camera
    matrix = np.array([[550.0, 0, 180.3], [0, 550.0, 146.0], [0, 0, 1]])
    lens = np.array([-0.21, 0.05, 0, 0])
    expected, _ = cv2.projectPoints(points, cv2.Rodrigues(rotation)[0], np.zeros(3), matrix, lens)
    assert np.abs(camera.project(points) - expected[:, 0]).max() < 1e-6


@pytest.mark.parametrize("marker_heading", [0.0, 77.0, 200.0])
@pytest.mark.parametrize("vehicle_heading", [0.0, 30.0, 275.0])
def test_beta_is_90_degrees_minus_the_image_angle(vehicle_heading, marker_heading):
    """Image right is the vehicle's left: both frames turn against each other."""
    camera = Camera()
    pose = Pose(-300.0, 900.0, vehicle_heading)
    ahead = turn_z(math.radians(vehicle_heading)) @ [200.0, 120.0, 0]
    plate = Plate(3, Pose(pose.x_mm + ahead[0], pose.y_mm + ahead[1], marker_heading))
    truth = truth_of(Scene(plates=(plate,)), pose, Motion(), camera)[0]
    # 200 mm ahead is towards the top, 120 mm to the left is towards the right of the picture
    scale = camera.focal_px / 3000.0
    assert truth.x_px == pytest.approx(179.5 + 120 * scale, abs=1e-9)
    assert truth.y_px == pytest.approx(147.5 - 200 * scale, abs=1e-9)
    assert (truth.offset_x_mm, truth.offset_y_mm) == (pytest.approx(200), pytest.approx(120))
    beta = 90 - truth.heading_deg
    assert (marker_heading - beta - vehicle_heading + 180) % 360 - 180 == pytest.approx(0, abs=1e-9)
    assert truth.radius_px == pytest.approx(150 * scale)


def test_looking_up_turns_counterclockwise_around():
    """A line that points left of the vehicle (counterclockwise in the map) points right in the picture."""
    camera = Camera()
    scene = Scene(plates=(Plate(1, Pose(0, 0, 90.0)),))
    assert truth_of(scene, Pose(0, 0, 0), Motion(), camera)[0].heading_deg == pytest.approx(0)
    image = render_radiance(Scene(surface=PLAIN, plates=scene.plates), Pose(0, 0, 0), Motion(), camera)
    # the orientation line at the right; the last bit of ID 1 is 270 degrees counterclockwise: below
    assert image[147, 179 + 38] < 0.1
    assert image[147, 179 - 38] > 0.9
    assert image[147 + 10, 179] < 0.1
    assert image[147 - 10, 179] > 0.9


def test_rolling_shutter_shears_what_moves():
    still = Camera(focal_px=500.0, row_us=50.0)
    scene = Scene(plates=(Plate(1, Pose(400.0, 100.0, 90.0)),))
    moving = truth_of(scene, Pose(), Motion(forward_mm_s=1500.0), still)[0]
    standing = truth_of(scene, Pose(), Motion(), still)[0]
    # driving towards it, an early (upper) row sees it farther ahead, so nearer to the top
    assert moving.y_px < standing.y_px - 0.5
    assert moving.offset_x_mm > 400.0
    expected = (moving.y_px - (still.height - 1) / 2) * 50e-6 * 1500.0
    assert moving.vehicle_x_mm == pytest.approx(expected, abs=1e-6)
    assert moving.radius_px != pytest.approx(standing.radius_px, abs=0.01)


def test_behind_the_camera_or_outside_there_is_no_marker():
    camera = Camera(tilt_deg=50.0)
    scene = Scene(plates=(Plate(1, Pose(-9000.0, 0.0, 0.0)), Plate(2, Pose(90000.0, 0.0, 0.0))))
    truths = truth_of(scene, Pose(), Motion(), camera)
    assert [truth.id for truth in truths] == [None]


def test_a_lens_that_folds_over_is_refused():
    with pytest.raises(ValueError, match="folds over"):
        Camera(focal_px=150.0, k1=-0.6)


@pytest.mark.parametrize(
    ("target", "dictionary"),
    [("aruco", cv2.aruco.DICT_4X4_50), ("apriltag", cv2.aruco.DICT_APRILTAG_36h11)],
)
def test_tags_are_read_where_the_truth_says(target, dictionary):
    camera = Camera(focal_px=1200.0, tilt_deg=4.0)
    plate = Plate(6, Pose(20.0, 210.0, 130.0), target=target)
    scene = Scene(surface=PLAIN, plates=(plate,))
    pose = Pose(0, 0, 10.0)
    frame = np.clip(render_radiance(scene, pose, Motion(), camera) * 200 + 20, 0, 255).astype(np.uint8)
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary), parameters)
    corners, ids, _ = detector.detectMarkers(frame)
    assert ids is not None and ids.ravel().tolist() == [6]
    corners = corners[0][0]
    truth = truth_of(scene, pose, Motion(), camera)[0]
    # the diagonals cross at the centre of a square seen in perspective
    a, b, c, d = (np.array([*corner, 1.0]) for corner in corners)
    centre = np.cross(np.cross(a, c), np.cross(b, d))
    assert np.hypot(*(centre[:2] / centre[2] - (truth.x_px, truth.y_px))) < 0.1
    left, right = (corners[0] + corners[3]) / 2, (corners[1] + corners[2]) / 2
    heading = math.degrees(math.atan2(left[1] - right[1], right[0] - left[0]))
    assert abs((heading - truth.heading_deg + 180) % 360 - 180) < 0.3
    assert np.linalg.norm(corners[0] - corners[1]) == pytest.approx(tag_side_mm(target) * 0.4, rel=0.02)


def test_what_lies_beyond_the_fold_of_a_lens_is_not_seen():
    camera = Camera(focal_px=672.0, k1=-0.166)
    there = camera.project([[0.0, 0.0, 3000.0], [7400.0, 0.0, 3000.0], [500.0, 0.0, 3000.0]])
    assert np.isnan(there).any(axis=1).tolist() == [False, True, False]
    assert not np.isnan(Camera(focal_px=672.0, k1=0.1).project([[9000.0, 0.0, 3000.0]])).any()
