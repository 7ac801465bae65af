"""Pixels -> millimetres: the calibrated camera, in integers only.

The camera looks up. Its frame has x to the image's right, y down in the image and z along the optical
axis; the vehicle frame has x forward, y left, z up. In the default mounting the top of the image points
forward, so x_vehicle = -y_camera and y_vehicle = x_camera, and an image angle a (counterclockwise as
seen) becomes beta = 90 degrees - a. A camera mounted otherwise is turned from there by

    ray_vehicle = Ry(tilt_forward) * Rx(-tilt_left) * Rz(mount) * ray_default

so `mount` is where the top of the image points (counterclockwise from forward) and the tilts are how far
the optical axis leans to the front and to the left. A mirrored sensor shows the picture with left and
right exchanged about the principal point.

The lens is a pinhole with radial distortion (Brown): distorted = undistorted * (1 + k1 r^2 + k2 r^4) in
units of the focal length, r being the undistorted radius.

Fractions are in 1/2**18 (`_q18`: 0.01 mm at 3 m). The constructor may use long integers; `locate` keeps
every intermediate within +-2**30 and allocates nothing.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import atan2_turn16, cdeg_from_turn16, cos_q14, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.arith.fixed_q18 import div, mul, product, root, sin_cos
from larics.marker import PLAIN_ID_MOST, mirrored_lines
from larics.marker.detection import NO_SIGMA

_ONE = const(262144)  # 1.0 in q18
_CDEG100_PER_RAD = const(572958)
_MAX_SQUARE = const(524288)  # 2.0 in q18: rays up to 54 degrees off the optical axis
_MAX_K_E5 = const(100000)
_ROUNDS = const(25)  # of the undistortion; each gains a digit for any lens that passes the constructor
_MAX_SIDE_PX = const(2048)
_MAX_TILT_CDEG = const(3000)
MAX_HEIGHT_MM10 = const(262143)  # 26 m above the lens


class Measurement:
    """One marker in the vehicle frame; filled by `Camera.locate`, meant to be reused.

    marker_id                    of the detection (a mirrored sensor's already put right), -1 when uncertain
    offset_x_mm10, offset_y_mm10 marker's centre seen from the vehicle's rotation centre
    height_mm10                  marker's plane above the vehicle frame's origin: the known height or, when
                                 there is none, ring_height_mm10
    ring_height_mm10             the same from the size of the outer ring alone, 0 when out of range
    heading_cdeg                 direction of the orientation line, counterclockwise from forward, 0..35999
    radius_q8, margin, flags, sigma_q12, sigma_mdeg   as in the detection
    row_q8                       of its centre, below the middle of the frame, 1/256 px
    sigma_mm10                   standard deviation of the vehicle's place by this marker alone, along x and
                                 along y, at least 1; NO_SIGMA when the detection's is not known
    """

    __slots__ = (
        "marker_id",
        "offset_x_mm10",
        "offset_y_mm10",
        "height_mm10",
        "ring_height_mm10",
        "heading_cdeg",
        "radius_q8",
        "row_q8",
        "margin",
        "flags",
        "sigma_q12",
        "sigma_mdeg",
        "sigma_mm10",
    )

    def __init__(self):
        self.marker_id = -1
        self.offset_x_mm10 = self.offset_y_mm10 = self.height_mm10 = self.ring_height_mm10 = 0
        self.heading_cdeg = self.radius_q8 = self.row_q8 = self.margin = self.flags = 0
        self.sigma_q12 = self.sigma_mdeg = self.sigma_mm10 = NO_SIGMA


class Camera:
    """A calibrated camera on a vehicle.

    width, height                frame, px
    focal_q8                     focal length, 1/256 px
    center_x_q8, center_y_q8     principal point, 1/256 px; None: the middle of the frame
    k1_e5, k2_e5                 radial distortion, 1/100000
    mount_cdeg                   where the top of the image points, counterclockwise from forward
    mirrored                     the sensor delivers the picture with left and right exchanged
    tilt_forward_cdeg, tilt_left_cdeg   lean of the optical axis, up to 30 degrees each
    camera_x_mm10, _y_, _z_      lens in the vehicle frame (origin: rotation centre; z from the floor or
                                 from wherever the heights are counted)
    ceiling_mm10                 height of the markers in the vehicle frame; 0: unknown, taken from the rings

    Raises ValueError, in one line, for what no camera can be.
    """

    def __init__(
        self,
        width,
        height,
        focal_q8,
        center_x_q8=None,
        center_y_q8=None,
        k1_e5=0,
        k2_e5=0,
        mount_cdeg=0,
        mirrored=False,
        tilt_forward_cdeg=0,
        tilt_left_cdeg=0,
        camera_x_mm10=0,
        camera_y_mm10=0,
        camera_z_mm10=0,
        ceiling_mm10=0,
    ):
        if not (0 < width <= _MAX_SIDE_PX and 0 < height <= _MAX_SIDE_PX):
            raise ValueError("frame %dx%d: each side must be 1 to %d px" % (width, height, _MAX_SIDE_PX))
        if not 20 * 256 <= focal_q8 < 1 << 20:
            raise ValueError("focal length %d/256 px: must be 20 to 4095 px" % focal_q8)
        if abs(tilt_forward_cdeg) > _MAX_TILT_CDEG or abs(tilt_left_cdeg) > _MAX_TILT_CDEG:
            raise ValueError(
                "tilt %d, %d: must be within +-%d hundredths of a degree"
                % (tilt_forward_cdeg, tilt_left_cdeg, _MAX_TILT_CDEG)
            )
        if abs(k1_e5) > _MAX_K_E5 or abs(k2_e5) > _MAX_K_E5:
            raise ValueError(
                "distortion k1 %d, k2 %d: must be within +-%d/100000" % (k1_e5, k2_e5, _MAX_K_E5)
            )
        if ceiling_mm10 and not 0 < ceiling_mm10 - camera_z_mm10 <= MAX_HEIGHT_MM10:
            raise ValueError(
                "ceiling %d must be above the lens at %d by at most %d (0.1 mm)"
                % (ceiling_mm10, camera_z_mm10, MAX_HEIGHT_MM10)
            )
        self.width = width
        self.height = height
        self.focal_q8 = focal_q8
        self.center_x_q8 = (width - 1) * 128 if center_x_q8 is None else center_x_q8
        self.center_y_q8 = (height - 1) * 128 if center_y_q8 is None else center_y_q8
        self.mirrored = bool(mirrored)
        self.mount_cdeg = mount_cdeg
        self.camera_x_mm10 = camera_x_mm10
        self.camera_y_mm10 = camera_y_mm10
        self.camera_z_mm10 = camera_z_mm10
        self.ceiling_mm10 = ceiling_mm10
        self._k1_q18 = ((k1_e5 << 18) + 50000) // 100000
        self._k2_q18 = ((k2_e5 << 18) + 50000) // 100000
        self._distorted = bool(k1_e5 or k2_e5)
        self._tilted = bool(tilt_forward_cdeg or tilt_left_cdeg)
        self._ray = [0, 0, 0]
        self._lens_q18 = _ONE  # distortion at the last point: radius ratio, its derivative, inverse ratio
        self._slope_q18 = 0
        self._stretch_q18 = _ONE

        sin, cos = sin_cos(mount_cdeg)
        side = -1 if mirrored else 1
        matrix = [[-side * sin, -cos, 0], [side * cos, -sin, 0], [0, 0, _ONE]]
        self._untilted = tuple(matrix[0][:2] + matrix[1][:2])
        sin, cos = sin_cos(-tilt_left_cdeg)
        matrix = product([[_ONE, 0, 0], [0, cos, -sin], [0, sin, cos]], matrix)
        sin, cos = sin_cos(tilt_forward_cdeg)
        matrix = product([[cos, 0, sin], [0, _ONE, 0], [-sin, 0, cos]], matrix)
        self._matrix = tuple(matrix[0] + matrix[1] + matrix[2])
        self._check_corners()

    def _check_corners(self):
        for x_q8 in (0, (self.width - 1) * 256):
            for y_q8 in (0, (self.height - 1) * 256):
                if not self._look(x_q8, y_q8):
                    raise ValueError(
                        "this lens and tilt have no meaning at the corner (%d, %d) px: "
                        "focal length too short, distortion too strong, or the view meets the horizon"
                        % (x_q8 >> 8, y_q8 >> 8)
                    )

    def _look(self, x_q8, y_q8):
        """The ray through a pixel into self._ray (camera frame, z = 1, q18); False where there is none."""
        ray = self._ray
        u = x_q8 - self.center_x_q8
        v = y_q8 - self.center_y_q8
        focal = self.focal_q8
        if not -2 * focal < u < 2 * focal or not -2 * focal < v < 2 * focal:
            return False
        u = div(u, focal)
        v = div(v, focal)
        square = mul(u, u) + mul(v, v)
        if square > _MAX_SQUARE:
            return False
        if self._distorted:
            scale = self._undistort(root(square))
            if not scale:
                return False
            u = mul(u, scale)
            v = mul(v, scale)
        ray[0] = u
        ray[1] = v
        ray[2] = _ONE
        m = self._matrix
        depth = mul(u, m[6]) + mul(v, m[7]) + m[8]
        return depth > _ONE >> 2

    def _undistort(self, distorted):
        """Undistorted over distorted radius (q18) by fixed-point iteration; 0 when it does not converge.

        Leaves the lens's state at that point for the direction and the area."""
        k1, k2 = self._k1_q18, self._k2_q18
        scale = _ONE
        for _ in range(_ROUNDS):
            square = mul(distorted, scale)
            square = mul(square, square)
            if square > _MAX_SQUARE:
                return 0
            first = mul(square, k1)
            second = mul(mul(square, square), k2)
            lens = _ONE + first + second
            if not _ONE >> 1 < lens < 3 * _ONE:
                return 0
            change = div(_ONE, lens) - scale
            scale += change
            if -2 < change < 2:
                break
        if not -5 < change < 5:  # a few units of rounding may remain
            return 0
        stretch = lens + 2 * first + 4 * second  # derivative of the distorted radius by the undistorted
        if not _ONE >> 3 < stretch < 3 * _ONE:
            return 0
        self._lens_q18 = lens
        self._slope_q18 = 2 * (k1 + 2 * mul(square, k2))  # twice the derivative of `lens` by the square
        self._stretch_q18 = stretch
        return scale

    def locate(self, detection, out, outer_mm10=1500, height_mm10=0):
        """Where the marker of a `Detection` is in the vehicle frame, into the Measurement `out`.

        outer_mm10 is the radius of its outer ring (up to 4000), height_mm10 its height in the vehicle frame
        when that is known better than by the camera's ceiling_mm10. Returns False, leaving `out` without
        meaning, for a pixel or radius that no marker above the vehicle can give.
        """
        if not self._look(detection.x_q8, detection.y_q8):
            return False
        m = self._matrix
        u, v = self._ray[0], self._ray[1]
        x = mul(u, m[0]) + mul(v, m[1]) + m[2]
        y = mul(u, m[3]) + mul(v, m[4]) + m[5]
        z = mul(u, m[6]) + mul(v, m[7]) + m[8]
        x = div(x, z)
        y = div(y, z)
        if not -2 * _ONE < x < 2 * _ONE or not -2 * _ONE < y < 2 * _ONE:
            return False

        by_ring = self._height_by_ring(detection.radius_q8, outer_mm10, z)
        above = height_mm10 or self.ceiling_mm10
        above = above - self.camera_z_mm10 if above else by_ring
        if not 0 < above <= MAX_HEIGHT_MM10:
            return False
        out.offset_x_mm10 = self.camera_x_mm10 + mul(above, x)
        out.offset_y_mm10 = self.camera_y_mm10 + mul(above, y)
        out.height_mm10 = above + self.camera_z_mm10
        out.ring_height_mm10 = by_ring + self.camera_z_mm10 if by_ring else 0

        image_cdeg = detection.heading_cdeg
        heading_cdeg = self.mount_cdeg + (image_cdeg - 9000 if self.mirrored else 9000 - image_cdeg)
        if self._tilted or self._distorted:
            heading_cdeg += self._heading_correction(image_cdeg, x, y)
        out.heading_cdeg = heading_cdeg % 36000

        out.marker_id = self.read_id(detection.marker_id)
        out.radius_q8 = detection.radius_q8
        out.row_q8 = detection.y_q8 - (self.height - 1) * 128
        out.margin = detection.margin
        out.flags = detection.flags
        out.sigma_q12 = detection.sigma_q12
        out.sigma_mdeg = detection.sigma_mdeg
        out.sigma_mm10 = NO_SIGMA
        if detection.sigma_q12 != NO_SIGMA:
            out.sigma_mm10 = self._sigma_mm10(out, above)
        return True

    def _sigma_mm10(self, out, above_mm10):
        """What the marker's centre and its heading, at its distance, add to the vehicle's place."""
        centre = above_mm10 * min(out.sigma_q12, 4095) // (16 * self.focal_q8)
        away = min(65535, max(abs(out.offset_x_mm10), abs(out.offset_y_mm10)))
        turned = 0
        if out.sigma_mdeg != NO_SIGMA:
            turned = away * (min(out.sigma_mdeg, 163830) // 10) // 5730
        return max(1, centre, turned)

    def read_id(self, marker_id):
        """The ID on the ceiling: a mirrored sensor meets a plain marker's lines in the opposite order."""
        if self.mirrored and 0 < marker_id <= PLAIN_ID_MOST:
            return mirrored_lines(marker_id)
        return marker_id

    def _height_by_ring(self, radius_q8, outer_mm10, depth_q18):
        """Height above the lens at which a ring of outer_mm10 has this radius; 0 when out of range.

        An area in the image shrinks by lens * stretch (distortion) and depth**3 (perspective of a
        tilted camera); the radius is the geometric mean of the ellipse's axes, hence the square root.
        Distortion over the ring itself, which is not a point, adds k1 * radius**2."""
        if not 256 <= radius_q8 < self.focal_q8:
            return 0
        whole = self.focal_q8 // radius_q8
        rest = (self.focal_q8 - whole * radius_q8) << 8
        middle = rest // radius_q8
        rest = (rest - middle * radius_q8) << 8
        ratio_q16 = (whole << 16) + (middle << 8) + (rest + (radius_q8 >> 1)) // radius_q8
        if (ratio_q16 >> 16) * outer_mm10 > MAX_HEIGHT_MM10:
            return 0
        height = (outer_mm10 * (ratio_q16 >> 8) + (outer_mm10 * (ratio_q16 & 255) >> 8) + 128) >> 8
        if not (self._tilted or self._distorted):
            return height
        shrinkage = depth_q18  # of an area, but for depth**2, which is taken out of the root
        if self._distorted:
            shrinkage = mul(shrinkage, self._lens_q18)
            if shrinkage > 2 * _ONE:
                return 0
            shrinkage = mul(shrinkage, self._stretch_q18)
            ring = div(radius_q8, self.focal_q8)
            height += mul(height, mul(mul(ring, ring), self._k1_q18))
        if shrinkage > 3 * _ONE:
            return 0
        height = mul(height, root(shrinkage))
        if height > MAX_HEIGHT_MM10:
            return 0
        height = mul(height, depth_q18)
        return height if height <= MAX_HEIGHT_MM10 else 0

    def _heading_correction(self, image_cdeg, x, y):
        """What tilt and distortion add to the heading, cdeg: the direction carried through the derivative
        of the projection, against the same direction without them. (x, y): the ray at z = 1, vehicle."""
        turn16 = turn16_from_cdeg(image_cdeg)
        du = cos_q14(turn16) << 4
        dv = -sin_q14(turn16) << 4
        t = self._untilted
        plain_x = mul(du, t[0]) + mul(dv, t[1])
        plain_y = mul(du, t[2]) + mul(dv, t[3])
        if self._distorted:
            u, v = self._ray[0], self._ray[1]
            along = mul(mul(u, du) + mul(v, dv), self._slope_q18)
            du = mul(du, self._stretch_q18) - mul(u, along)
            dv = mul(dv, self._stretch_q18) - mul(v, along)
        m = self._matrix
        dz = mul(du, m[6]) + mul(dv, m[7])
        dx = mul(du, m[0]) + mul(dv, m[1]) - mul(dz, x)
        dy = mul(du, m[3]) + mul(dv, m[4]) - mul(dz, y)
        across = mul(plain_x, dy) - mul(plain_y, dx)
        ahead = mul(plain_x, dx) + mul(plain_y, dy)
        if not 2 * abs(across) < ahead < 8 * _ONE:
            return wrap_cdeg(cdeg_from_turn16(atan2_turn16(across >> 2, ahead >> 2)))
        t = div(across >> 1, ahead >> 1)
        square = mul(t, t)
        series = _ONE // 7 - mul(square, _ONE // 9)
        series = _ONE // 5 - mul(square, series)
        series = _ONE // 3 - mul(square, series)
        angle = t - mul(t, mul(square, series))
        return (mul(_CDEG100_PER_RAD, angle) + 50) // 100
