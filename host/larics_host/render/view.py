"""One frame of a scene: the passes of the renderer in their order, and the truth about the markers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from larics_host.render import painters, rays
from larics_host.render.optics import defocus, pixel_samples, smear
from larics_host.render.reflection import add_reflections
from larics_host.render.scene import texture
from larics_host.truth import Truth

if TYPE_CHECKING:
    from larics_host.render.camera import Camera, Motion, Pose
    from larics_host.render.scene import Scene
    from larics_host.render.sensor import Sensor


RIM = np.linspace(0, 2 * math.pi, 48, endpoint=False)
CIRCLE = np.stack([np.cos(RIM), np.sin(RIM)], axis=1)
# samples of a pixel: at least MIN, and this many per pixel of motion blur
MIN_SAMPLES, SAMPLES_PER_PX, MAX_SAMPLES = 24, 2.5, 128
# the ramp of an edge, as a share of a pixel, that a sample stands for
SAMPLE_RAMP = 0.7
BOX_MARGIN_PX = 4


def render_view(
    scene: Scene,
    pose: Pose,
    motion: Motion,
    camera: Camera,
    sensor: Sensor,
    rng: np.random.Generator,
    *,
    name: str = "",
    time_us: int = 0,
) -> tuple[np.ndarray, list[Truth]]:
    """Take one picture.

    scene    Scene;  camera  Camera;  sensor  Sensor;  rng  numpy Generator of the noise
    pose, motion   the vehicle at mid-exposure of the frame's middle row, and how it moves
    time_us  clock at mid-exposure of the frame's first row
    Returns the frame, (H, W) uint8, and a list of Truth: one for each marker whose outer ring is at least
    in part inside the frame, or a single one without an ID.
    """
    truths = truth_of(scene, pose, motion, camera, name, time_us)
    if sensor.plain:
        return sensor.frame(render_radiance(scene, pose, motion, camera, sensor.defocus_px), rng), truths

    def radiance_at(seconds):
        return render_radiance(scene, motion.pose_after(pose, seconds), motion, camera, sensor.defocus_px)

    return sensor.develop(radiance_at, camera, rng), truths


def truth_of(
    scene: Scene, pose: Pose, motion: Motion, camera: Camera, name: str = "", time_us: int = 0
) -> list[Truth]:
    """The Truth records of a picture, without taking it."""
    truths = []
    for plate in scene.plates:
        truth = _plate_truth(plate, scene.ceiling_mm, pose, motion, camera)
        if truth is not None and truth.visible > 0:
            truth.frame = name
            truth.time_us += time_us
            truths.append(truth)
    if not truths:
        truths.append(
            Truth(
                frame=name,
                time_us=time_us + int(round(camera.middle_row * camera.row_us)),
                vehicle_x_mm=pose.x_mm,
                vehicle_y_mm=pose.y_mm,
                vehicle_heading_deg=pose.heading_deg % 360,
            )
        )
    return truths


def _plate_truth(plate, ceiling_mm, pose, motion, camera):
    center = np.array([plate.pose.x_mm, plate.pose.y_mm])
    heading = math.radians(plate.pose.heading_deg)
    along = np.array([math.cos(heading), math.sin(heading)])
    # the centre, the two ends of what tells the direction, and the outer ring
    tail, head = plate.pointer_mm
    points = [center, center + tail * along, center + head * along, *(center + plate.ring_mm * CIRCLE)]
    pixels, seconds = camera.capture(points, ceiling_mm, pose, motion)
    if np.isnan(pixels).any():
        return None
    direction = pixels[2] - pixels[1]
    ring = pixels[3:]
    inside = (ring > -0.5).all(axis=1) & (ring < (camera.width - 0.5, camera.height - 0.5)).all(axis=1)
    # area of the polygon; a regular polygon in an ellipse misses a known share of it
    x, y = ring.T
    area = abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2
    step = 2 * math.pi / len(ring)
    radius = math.sqrt(area * step / math.sin(step) / math.pi)
    vehicle = motion.pose_after(pose, seconds[0])
    turned = math.radians(vehicle.heading_deg)
    east, north = center[0] - vehicle.x_mm, center[1] - vehicle.y_mm
    return Truth(
        time_us=int(round(seconds[0] * 1e6 + camera.middle_row * camera.row_us)),
        id=plate.marker_id,
        x_px=float(pixels[0, 0]),
        y_px=float(pixels[0, 1]),
        heading_deg=math.degrees(math.atan2(-direction[1], direction[0])) % 360,
        radius_px=radius,
        vehicle_x_mm=vehicle.x_mm,
        vehicle_y_mm=vehicle.y_mm,
        vehicle_heading_deg=vehicle.heading_deg % 360,
        marker_x_mm=plate.pose.x_mm,
        marker_y_mm=plate.pose.y_mm,
        marker_heading_deg=plate.pose.heading_deg % 360,
        offset_x_mm=math.cos(turned) * east + math.sin(turned) * north,
        offset_y_mm=-math.sin(turned) * east + math.cos(turned) * north,
        visible=float(inside.mean()),
    )


def render_radiance(
    scene: Scene,
    pose: Pose,
    motion: Motion,
    camera: Camera,
    defocus_px: float = 0.0,
    min_samples: int = MIN_SAMPLES,
) -> np.ndarray:
    """The light on the sensor, (H, W) float32, the white plate's being 1: no noise, no vignetting."""
    return _Pass(scene, pose, motion, camera, min_samples).run(defocus_px)


class _Pass:
    """The working state of one picture; coordinates are relative to the vehicle's pose."""

    def __init__(self, scene, pose, motion, camera, min_samples):
        self.scene, self.pose, self.motion, self.camera = scene, pose, motion, camera
        self.min_samples = min_samples
        sign = -1.0 if camera.mirrored else 1.0
        lens = (sign * camera.focal_px, camera.focal_px, camera.center_x_px, camera.center_y_px)
        self.cam = np.array([*lens, *camera.rotation.ravel()])
        heading, turn = math.radians(pose.heading_deg), math.radians(motion.turn_deg_s)
        self.path = np.array(
            [
                *(0.0, 0.0, heading),
                *(motion.forward_mm_s, motion.left_mm_s, turn),
                *(camera.row_us * 1e-6, camera.middle_row),
                *(camera.offset_x_mm, camera.offset_y_mm),
            ]
        )
        self.lens = (camera.lens_table, camera.lens_step)
        self.exposure_s = camera.exposure_us * 1e-6
        self.shape = (camera.height, camera.width)
        self.mm_per_px = scene.ceiling_mm / camera.focal_px
        self.shift_px = self._shift()

    def _shift(self):
        """How far the picture's middle moves during an exposure, (x, y) px."""
        plane = np.empty((2, 1, 1), np.float32)
        cam = self.cam.copy()
        cam[2], cam[3] = 0.0, 0.0  # the pixel at 0, 0 becomes the principal point
        path = self.path.copy()
        path[6] = 0.0
        rays.fill_plane(plane, cam, *self.lens, path, self.scene.ceiling_mm)
        middle = plane[:, 0, 0].astype(float)[None] + (self.pose.x_mm, self.pose.y_mm)
        half = self.exposure_s / 2
        ends = [
            self.camera.look_at(middle, self.scene.ceiling_mm, self.motion.pose_after(self.pose, time))[0]
            for time in (-half, half)
        ]
        shift = ends[1] - ends[0]
        return (0.0, 0.0) if np.isnan(shift).any() else tuple(shift)

    def run(self, defocus_px):
        plane = self.plane = np.empty((2, *self.shape), np.float32)
        rays.fill_plane(plane, self.cam, *self.lens, self.path, self.scene.ceiling_mm)
        corners = plane[:, (0, 0, -1, -1), (0, -1, 0, -1)].astype(float)
        low, high = corners.min(axis=1), corners.max(axis=1)
        self.middle, self.half = (low + high) / 2, 0.55 * (high - low)
        image = np.empty(self.shape, np.float32)
        surface = self.scene.surface.row(self.pose.x_mm, self.pose.y_mm, self.mm_per_px)
        painters.paint_ceiling(image, plane, texture(), surface)
        for row, box in self._visible(self.scene.objects):
            painters.paint_object(image, plane, row, box, self.mm_per_px)
        image = smear(image, self.shift_px)
        boxes = [self._paint_plate(image, plate) for plate in self.scene.plates]
        self._light(image, boxes)
        return defocus(image, defocus_px)

    def _visible(self, rows, reach=lambda row: row[painters.SOFT] / 2):
        """(object relative to the vehicle, its box in the frame) of those that may be seen."""
        if not len(rows):
            return
        # far ones go first, all at once
        size = rows[:, painters.A] + rows[:, painters.B] + [reach(row) for row in rows]
        away_x = np.abs(rows[:, painters.X] - self.pose.x_mm - self.middle[0]) - self.half[0]
        away_y = np.abs(rows[:, painters.Y] - self.pose.y_mm - self.middle[1]) - self.half[1]
        rows = rows[np.maximum(away_x, away_y) < size]
        kind, a, b = rows[:, painters.KIND], rows[:, painters.A], rows[:, painters.B]
        long = np.where(kind == painters.BOX, a, a + b)
        wide = np.where((kind == painters.BOX) | (kind == painters.GRILLE) | (kind == painters.ROD), b, long)
        margin = 2 * self.mm_per_px + np.array([reach(row) for row in rows])
        # a dozen points around each, so that a lens cannot bend a part out of the box
        along = np.array([-1, -0.5, 0, 0.5, 1, 1, 1, 0.5, 0, -0.5, -1, -1]) * (long + margin)[:, None]
        across = np.array([-1, -1, -1, -1, -1, 0, 1, 1, 1, 1, 1, 0]) * (wide + margin)[:, None]
        cos, sin = rows[:, painters.COS, None], rows[:, painters.SIN, None]
        x = rows[:, painters.X, None] + cos * along - sin * across
        y = rows[:, painters.Y, None] + sin * along + cos * across
        pixels = self._pixels(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(-1, along.shape[1], 2)
        rows[:, painters.X] -= self.pose.x_mm
        rows[:, painters.Y] -= self.pose.y_mm
        for row, around in zip(rows, pixels, strict=True):
            box = self._box(around)
            if box is not None:
                yield row, box

    def _pixels(self, map_points):
        return self.camera.look_at(map_points, self.scene.ceiling_mm, self.pose)

    def _box(self, pixels):
        """Rows and columns from .. to around image points, with a margin; None outside the frame."""
        height, width = self.shape
        if np.isnan(pixels).any():
            return np.array([0, height, 0, width])
        # the rolling shutter shows the first and last rows from elsewhere on the path
        late = self.camera.row_us * 1e-6 * height / 2
        speed = math.hypot(self.motion.forward_mm_s, self.motion.left_mm_s) / self.mm_per_px
        margin = BOX_MARGIN_PX + late * (
            speed + math.radians(abs(self.motion.turn_deg_s)) * self.camera.width
        )
        left, top = np.floor(pixels.min(axis=0) - margin).astype(int)
        right, bottom = np.ceil(pixels.max(axis=0) + margin).astype(int) + 1
        box = np.array([max(top, 0), min(bottom, height), max(left, 0), min(right, width)])
        return box if box[0] < box[1] and box[2] < box[3] else None

    def _paint_plate(self, image, plate):
        """Paint one plate; returns its box in the frame, None where it is out of sight."""
        center = np.array([[plate.pose.x_mm, plate.pose.y_mm]])
        # local scale: mm on the ceiling per px, in the coarsest direction
        steps = center + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        pixels = self.camera.look_at(steps, self.scene.ceiling_mm, self.pose)
        if np.isnan(pixels).any():
            return None
        scales = np.linalg.svd(np.stack([pixels[1] - pixels[0], pixels[2] - pixels[0]]), compute_uv=False)
        coarse, mean = 1.3 / scales[1], 1.0 / math.sqrt(scales[0] * scales[1])
        turn = math.radians(abs(self.motion.turn_deg_s))
        away = math.hypot(center[0, 0] - self.pose.x_mm, center[0, 1] - self.pose.y_mm) + plate.radius_mm
        speed = math.hypot(self.motion.forward_mm_s, self.motion.left_mm_s) + turn * away
        blur_mm = speed * self.exposure_s
        count = self.min_samples + 2 * math.ceil(SAMPLES_PER_PX / 2 * blur_mm * scales[0])
        samples = pixel_samples(min(count, MAX_SAMPLES), self.exposure_s)
        reach = 0.75 * coarse + blur_mm / 2 + mean
        heading = math.radians(plate.pose.heading_deg)
        rim = plate.radius_mm * (1.45 if plate.finish.sheet else 1.0) + reach
        box = self._box(self._pixels(center + rim * CIRCLE))
        if box is None:
            return None
        row = np.array(
            [
                *(plate.pose.x_mm - self.pose.x_mm, plate.pose.y_mm - self.pose.y_mm),
                *(math.cos(heading), math.sin(heading)),
                *(plate.radius_mm, plate.white, plate.black),
                *(SAMPLE_RAMP * mean, reach),
            ]
        )
        view = (self.cam, *self.lens, self.path, self.scene.ceiling_mm)
        finish = (*plate.finish.row(), texture())
        rays.paint_plate(image, *view, row, *finish, *plate.pattern(), samples, box)
        return box

    def _lens_xy(self):
        """Map position of the lens at mid-exposure of the frame's middle, mm."""
        heading = math.radians(self.pose.heading_deg)
        cos, sin = math.cos(heading), math.sin(heading)
        ahead, left = self.camera.offset_x_mm, self.camera.offset_y_mm
        return self.pose.x_mm + cos * ahead - sin * left, self.pose.y_mm + sin * ahead + cos * left

    def _light(self, image, boxes):
        """Occluders, shadows and lamps over the picture of ceiling and plates."""
        scene = self.scene
        color = alpha = glow = image  # stand-ins of the right type where a layer is absent
        shade = np.ones(self.shape, np.float32)
        for row, box in self._visible(scene.shades):
            painters.paint_shade(shade, self.plane, row, box, self.mm_per_px)
        if len(scene.occluders):
            color, alpha = np.zeros(self.shape, np.float32), np.zeros(self.shape, np.float32)
            for row, box in self._visible(scene.occluders):
                painters.paint_occluder(color, alpha, self.plane, row, box, self.mm_per_px)
            color, alpha = smear(color, self.shift_px), smear(alpha, self.shift_px)
        mirrors = bool(scene.low_lamps) and any(plate.finish.gloss for plate in scene.plates)
        if len(scene.lamps) or mirrors:
            glow = np.zeros(self.shape, np.float32)
            for row, box in self._visible(scene.lamps, lambda row: 5 * row[painters.SOFT]):
                painters.paint_glow(glow, self.plane, row, box, self.mm_per_px)
            glow = smear(glow, self.shift_px)
            if mirrors:
                mirrored = np.zeros(self.shape, np.float32)
                origin = (self.pose.x_mm, self.pose.y_mm)
                add_reflections(mirrored, self.plane, scene, origin, self._lens_xy(), boxes, self.mm_per_px)
                mirrored = smear(mirrored, self.shift_px)
                # what hangs before a plate hides what it mirrors
                glow += mirrored * (1 - alpha) if len(scene.occluders) else mirrored
        layers = np.array([len(scene.occluders) > 0, len(scene.lamps) > 0 or mirrors])
        painters.merge(image, color, alpha, shade, glow, layers)
