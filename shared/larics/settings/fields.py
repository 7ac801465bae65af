"""The table of settings, `FIELDS`, and what a single value may be. See `larics.settings`."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.marker import CODED_ID_MOST, FAMILY_NAMES, RADIUS_MAX_PX, RADIUS_MIN_PX
from larics.marker.id_set import ends_of

# what has to be made anew when a setting changes: Field.rebuilds is a sum of these
DETECTOR = const(1)
LOCATOR = const(2)
NAVIGATOR = const(4)
EXPOSURE = const(8)
OUTPUT = const(16)
RESTART = const(32)  # all of them, by a restart: until then the value before stays in use


class Field:
    """One setting. `key` is its number on the wire and never changes its meaning; `rebuilds` says what a
    change makes anew, 0 for nothing. The other parts stay as they are: a new line rate costs no pose."""

    # what most have alike: on a board with little memory a setting holds only what differs
    kind = "int"
    default = 0
    low = 0
    unit = ""
    meaning = ""
    choices = ()
    length = 0
    columns = ()
    needed = 0

    def __init__(
        self, key, name, rebuilds, kind, default, low, high, unit, meaning, choices=(), length=0, columns=(),
        needed=0,
    ):  # fmt: skip
        self.key = key
        self.name = name
        self.rebuilds = rebuilds
        self.high = high
        if kind != "int":
            self.kind = kind
        if default != 0 or default is False:
            self.default = default
        if low:
            self.low = low
        if unit:
            self.unit = unit
        if meaning:
            self.meaning = meaning
        if choices:
            self.choices = choices
        if length:
            self.length = length
        if columns:
            self.columns = columns
            self.needed = needed or len(columns)  # further columns may be left out: they are 0 then

    def range_text(self):
        """The allowed values, for people: "1..100", "larics, nmea or mavlink"."""
        if self.kind == "choice":
            names = [str(choice) for choice in self.choices]
            return ", ".join(names[:-1]) + " or " + names[-1]
        if self.kind == "bool":
            return "true or false"
        if self.kind == "list":
            return "up to %d numbers %d..%d" % (self.length, self.low, self.high)
        if self.kind == "ranges":
            return "up to %d numbers or [first, last] of %d..%d" % (self.length, self.low, self.high)
        if self.kind == "table":
            columns = ["%s %d..%d" % column for column in self.columns]
            return "up to %d rows [%s]" % (self.length, ", ".join(columns))
        return "%d..%d" % (self.low, self.high)

    def reason(self, value):
        """None when the value is allowed, else one line that says why not."""
        if self.kind == "bool":
            allowed = value is True or value is False
        elif self.kind == "choice":
            allowed = not isinstance(value, bool) and value in self.choices
        elif self.kind == "int":
            allowed = _is_within(value, self.low, self.high)
        elif not isinstance(value, (list, tuple)):
            return "%s must be a list: %s" % (self.name, self.range_text())
        elif len(value) > self.length:
            return "%s has %d entries, at most %d fit" % (self.name, len(value), self.length)
        else:
            for k in range(len(value)):
                if not self._is_entry(value[k]):
                    return "%s[%d] = %s is not allowed: %s" % (self.name, k, value[k], self.range_text())
            return None
        if allowed:
            return None
        unit = " " + self.unit if self.unit else ""
        return "%s = %s is not allowed: %s%s" % (self.name, value, self.range_text(), unit)

    def _is_entry(self, entry):
        if self.kind == "list" or (self.kind == "ranges" and not isinstance(entry, (list, tuple))):
            return _is_within(entry, self.low, self.high)
        if self.kind == "ranges":
            ends = len(entry) == 2 and all(_is_within(end, self.low, self.high) for end in entry)
            return ends and entry[0] <= entry[1]
        if not isinstance(entry, (list, tuple)) or not self.needed <= len(entry) <= len(self.columns):
            return False
        return all(_is_within(entry[k], self.columns[k][1], self.columns[k][2]) for k in range(len(entry)))

    def full(self, value):
        """A copy of an allowed value, the rows of a table with all their columns."""
        if self.kind == "table":
            return [list(row) + [0] * (len(self.columns) - len(row)) for row in value]
        if isinstance(value, (list, tuple)):
            return [list(entry) if isinstance(entry, (list, tuple)) else entry for entry in value]
        return value

    def numbers(self, value):
        """An allowed value as the list of numbers that stands for it on the wire."""
        if self.kind == "choice":
            return [self.choices.index(value)]
        if self.kind == "table":
            return [number for row in self.full(value) for number in row]
        if self.kind == "list":
            return list(value)
        if self.kind == "ranges":
            return [end for entry in value for end in ends_of(entry)]
        return [int(value)]

    def value(self, numbers):
        """The value of a list of numbers from the wire; None when there are too few or too many."""
        if self.kind == "list":
            return list(numbers) if len(numbers) <= self.length else None
        if self.kind == "ranges":
            if len(numbers) & 1 or len(numbers) > 2 * self.length:
                return None
            ends = [(numbers[k], numbers[k + 1]) for k in range(0, len(numbers), 2)]
            return [first if first == last else [first, last] for first, last in ends]
        if self.kind == "table":
            width = len(self.columns)
            if len(numbers) % width or len(numbers) > width * self.length:
                return None
            return [list(numbers[k : k + width]) for k in range(0, len(numbers), width)]
        if len(numbers) != 1:
            return None
        number = numbers[0]
        if self.kind == "bool" and 0 <= number <= 1:
            return bool(number)
        if self.kind == "choice" and 0 <= number < len(self.choices):
            return self.choices[number]
        return number  # out of range, which `reason` tells, or an int

    def most_numbers(self):
        """How many numbers the longest value of this setting has."""
        width = 2 if self.kind == "ranges" else max(1, len(self.columns))
        return self.length * width if self.length else 1


def _is_within(value, low, high):
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


# fmt: off
FIELDS = (
    Field(1, "width", RESTART, "int", 320, 80, 1024, "px", "frame width"),
    Field(2, "height", RESTART, "int", 240, 60, 1024, "px", "frame height"),
    Field(3, "focal_q8", LOCATOR | NAVIGATOR | EXPOSURE, "int", 0, 0, 1048575, "1/256 px",
          "focal length, from 5120 on; 0: not calibrated"),
    Field(4, "center_x_q8", LOCATOR, "int", 0, 0, 262143, "1/256 px",
          "principal point; 0: middle of the frame"),
    Field(5, "center_y_q8", LOCATOR, "int", 0, 0, 262143, "1/256 px",
          "principal point; 0: middle of the frame"),
    Field(6, "k1_e5", LOCATOR, "int", 0, -100000, 100000, "1/100000",
          "radial lens distortion, with r squared"),
    Field(7, "k2_e5", LOCATOR, "int", 0, -100000, 100000, "1/100000",
          "radial lens distortion, with r to the 4th"),
    Field(8, "mount_cdeg", LOCATOR, "int", 0, 0, 35999, "0.01 deg",
          "where the image top points, ccw from forward"),
    Field(9, "mirrored", DETECTOR | LOCATOR, "bool", False, 0, 1, "",
          "the sensor shows left and right exchanged"),
    Field(10, "tilt_forward_cdeg", LOCATOR, "int", 0, -3000, 3000, "0.01 deg",
          "lean of the optical axis, forward"),
    Field(11, "tilt_left_cdeg", LOCATOR, "int", 0, -3000, 3000, "0.01 deg",
          "lean of the optical axis to the left"),
    Field(12, "camera_x_mm10", LOCATOR, "int", 0, -100000, 100000, "0.1 mm",
          "lens in the vehicle frame, forward"),
    Field(13, "camera_y_mm10", LOCATOR, "int", 0, -100000, 100000, "0.1 mm",
          "lens in the vehicle frame, to the left"),
    Field(14, "camera_z_mm10", LOCATOR | NAVIGATOR | EXPOSURE, "int", 0, -100000, 100000, "0.1 mm",
          "lens in the vehicle frame, up"),
    Field(15, "ceiling_mm10", LOCATOR | EXPOSURE, "int", 0, 0, 300000, "0.1 mm",
          "height of the markers; 0: from their size"),
    Field(19, "method", DETECTOR, "choice", "larics", 0, 0, "",
          "how markers are found", choices=("larics", "paper")),
    Field(20, "radius_min_px", DETECTOR, "int", RADIUS_MIN_PX, 6, 72, "px",
          "smallest outer ring to look for, below the largest"),
    Field(21, "radius_max_px", DETECTOR | EXPOSURE, "int", RADIUS_MAX_PX, 6, 72, "px",
          "largest outer ring to look for"),
    Field(22, "outer_mm10", DETECTOR | NAVIGATOR | EXPOSURE, "int", 1500, 100, 4000, "0.1 mm",
          "radius of the markers' outer ring"),
    Field(23, "line_mm10", DETECTOR, "int", 0, 0, 1000, "0.1 mm",
          "width of their lines; 0: 2/15 of the radius"),
    Field(18, "family", DETECTOR, "choice", "coded", 0, 0, "",
          "coded: 3,583 IDs, plain ones included; plain: 1..7", choices=FAMILY_NAMES),
    Field(24, "allowed_ids", DETECTOR | NAVIGATOR, "ranges", (), 0, CODED_ID_MOST, "",
          "the only IDs reported; empty: all of the family", length=32),
    Field(25, "allow_id0", DETECTOR, "bool", False, 0, 1, "", "also ID 0, the one without a coding line"),
    Field(26, "tracking", DETECTOR, "bool", True, 0, 1, "", "look around the predicted place first"),
    Field(27, "second_opinion", DETECTOR, "bool", True, 0, 1, "",
          "slower check of a blurred or tiny candidate"),
    Field(28, "confirm_needed", DETECTOR, "int", 1, 1, 10, "frames",
          "an ID counts when so many frames agree ..."),
    Field(29, "confirm_frames", DETECTOR, "int", 1, 1, 10, "frames", "... of so many"),
    Field(30, "max_tilt_cdeg", DETECTOR, "int", 0, 0, 4000, "0.01 deg",
          "of the camera: widens the radii searched"),
    Field(31, "max_speed_mm_s", NAVIGATOR | EXPOSURE, "int", 500, 0, 5000, "mm/s",
          "fastest drive, for the motion blur limit"),
    Field(32, "margin_min", DETECTOR, "int", 16, 0, 255, "",
          "report no marker of less; more: fewer wrong and found"),
    Field(40, "baud", RESTART, "choice", 115200, 0, 0, "", "speed of the line",
          choices=(9600, 19200, 38400, 57600, 115200, 230400, 250000, 460800, 500000, 921600, 1000000)),
    Field(41, "output", RESTART, "choice", "larics", 0, 0, "",
          "encoding", choices=("larics", "nmea", "mavlink")),
    Field(42, "rate_divider", OUTPUT, "int", 1, 1, 255, "", "send the measurements of every n-th frame"),
    Field(43, "mavlink_system", RESTART, "int", 1, 1, 255, "", "MAVLink system ID"),
    Field(44, "mavlink_component", RESTART, "int", 197, 1, 255, "", "MAVLink component ID"),
    Field(45, "mavlink_target", RESTART, "choice", "none", 0, 0, "",
          "LANDING_TARGET of a camera that looks down, for whom", choices=("none", "ardupilot", "px4")),
    Field(50, "exposure", EXPOSURE, "choice", "auto", 0, 0, "", "exposure policy", choices=("auto", "fixed")),
    Field(51, "exposure_us", EXPOSURE, "int", 5000, 10, 100000, "us",
          "exposure time when fixed, first one when auto"),
    Field(52, "exposure_max_us", EXPOSURE, "int", 33000, 10, 100000, "us", "longest exposure time when auto"),
    Field(53, "gain_db10", EXPOSURE, "int", 0, 0, 480, "0.1 dB", "gain when fixed, first one when auto"),
    Field(54, "gain_max_db10", EXPOSURE, "int", 240, 0, 480, "0.1 dB", "highest gain when auto"),
    Field(55, "blur_max_q8", EXPOSURE, "int", 512, 64, 5120, "1/256 px",
          "motion blur allowed at max_speed_mm_s when auto"),
    Field(56, "target_grey", EXPOSURE, "int", 110, 20, 235, "", "mean grey aimed at when auto"),
    Field(60, "route", NAVIGATOR, "list", (), 0, 65534, "",
          "IDs of the markers in the order of driving", length=64),
    Field(
        61, "map", NAVIGATOR, "table", (), 0, 0, "",
        "where the markers are: ID, place and direction of the orientation line in the map frame, height "
        "in the vehicle frame (0: ceiling_mm10), radius of the outer ring (0: outer_mm10), standard "
        "deviations of place and direction (0: map_sigma_mm10, map_sigma_cdeg; may be left out)",
        length=63,
        needed=6,
        columns=(
            ("id", 0, 65534),
            ("x_mm", -10000000, 10000000),
            ("y_mm", -10000000, 10000000),
            ("heading_cdeg", 0, 35999),
            ("z_mm10", 0, 300000),
            ("outer_mm10", 0, 4000),
            ("sigma_mm10", 0, 10000),
            ("sigma_cdeg", 0, 9000),
        ),
    ),
    Field(70, "map_sigma_mm10", NAVIGATOR, "int", 10, 0, 10000, "0.1 mm",
          "standard deviation of a marker's x and y in the map"),
    Field(71, "map_sigma_cdeg", NAVIGATOR, "int", 10, 0, 9000, "0.01 deg", "that of its heading"),
    Field(72, "focal_sigma_ppm", NAVIGATOR, "int", 1000, 0, 100000, "ppm", "that of focal_q8"),
    Field(73, "height_sigma_mm10", NAVIGATOR, "int", 30, 0, 10000, "0.1 mm", "that of the markers' height"),
    Field(74, "tilt_sigma_cdeg", NAVIGATOR, "int", 5, 0, 3000, "0.01 deg", "that of each tilt"),
    Field(75, "mount_sigma_cdeg", NAVIGATOR, "int", 5, 0, 9000, "0.01 deg", "that of mount_cdeg"),
    Field(76, "camera_sigma_mm10", NAVIGATOR, "int", 10, 0, 10000, "0.1 mm", "that of camera_x and camera_y"),
    Field(80, "odometry_scale_ppm", NAVIGATOR, "int", 0, -100000, 100000, "ppm",
          "by how much the way driven is longer than told"),
    Field(81, "odometry_turn_ppm", NAVIGATOR, "int", 0, -100000, 100000, "ppm",
          "by how much the turn is larger: wrong track"),
    Field(82, "odometry_drift_mdeg_m", NAVIGATOR, "int", 0, -15000, 15000, "0.001 deg/m",
          "turn to the left a metre that is told straight"),
    Field(83, "odometry_scale_sigma_ppm", NAVIGATOR, "int", 7000, 0, 100000, "ppm",
          "standard deviation of the scale"),
    Field(84, "odometry_turn_sigma_ppm", NAVIGATOR, "int", 7000, 0, 100000, "ppm", "that of the turn"),
    Field(85, "odometry_drift_sigma_mdeg_m", NAVIGATOR, "int", 2700, 0, 15000, "0.001 deg/m",
          "that of the drift"),
    Field(86, "odometry_noise_mm2_km", NAVIGATOR, "int", 2500, 0, 250000, "mm2/km",
          "variance of a wheel's way; 25,000 a slip each metre"),
    Field(87, "odometry_speed_noise_us", NAVIGATOR, "int", 240, 0, 10000, "us",
          "the same times the speed: what encoders do not see"),
    Field(88, "odometry_track_mm", NAVIGATOR, "int", 300, 20, 5000, "mm", "between the wheels"),
    Field(89, "row_ns", LOCATOR, "int", 0, -200000, 200000, "ns",
          "rolling shutter: from a row to the one below; 0: none, or not known"),
)
# fmt: on
