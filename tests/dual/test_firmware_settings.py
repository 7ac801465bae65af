"""A changed setting makes anew what its field declares and leaves the rest as it was: over all fields."""

from app import App
from larics.device.factory import make_detector, make_locator, make_navigator, make_rolling
from larics.settings import FIELDS, Settings, field
from larics.settings.fields import DETECTOR, EXPOSURE, LOCATOR, NAVIGATOR, OUTPUT, RESTART
from pc.pipe_camera import FrameClock

# a camera of which every part exists
BASE = {
    "width": 160,
    "height": 120,
    "radius_min_px": 15,
    "radius_max_px": 25,
    "focal_q8": 200 * 256,
    "ceiling_mm10": 20000,
    "outer_mm10": 1490,
    "line_mm10": 180,
    "confirm_needed": 2,
    "confirm_frames": 3,
    "allowed_ids": [1, 2, 3, 4, 5],
    "map": [[5, 0, 0, 0, 0, 0], [3, 1000, 0, 0, 0, 0]],
    "route": [5, 3],
}
# another value that goes together with the rest; the other fields take their limits
OTHER = {
    "width": 176,
    "height": 144,
    "focal_q8": 210 * 256,
    "center_x_q8": 81 * 256,
    "center_y_q8": 61 * 256,
    "k1_e5": 100,
    "k2_e5": 100,
    "camera_z_mm10": 100,
    "ceiling_mm10": 21000,
    "radius_min_px": 14,
    "radius_max_px": 26,
    "outer_mm10": 1500,
    "line_mm10": 200,
    "allowed_ids": [3, 5],
    "confirm_needed": 3,
    "confirm_frames": 4,
    "route": [3, 5],
    "map": [[5, 0, 0, 0, 0, 0], [3, 1100, 0, 0, 0, 0]],
}


class Camera:
    """Delivers nothing; can be exposed."""

    ended = False
    width, height = 160, 120
    frame = None
    frame_number = -1
    skipped = capture_us = 0

    def start(self):
        pass

    def exposure(self, us=None):
        return 5000

    def gain(self, cdb=None):
        return 0


class Uart:
    def write(self, buffer, offset, count):
        return count

    def any(self):
        return 0


def other_value(entry):
    if entry.name in OTHER:
        return OTHER[entry.name]
    usual = BASE.get(entry.name, entry.default)
    if entry.kind == "bool":
        return not usual
    if entry.kind == "choice":
        return [choice for choice in entry.choices if choice != usual][0]
    return entry.high if usual != entry.high else entry.low


def parts_of(app):
    """(bit of the part, what stands for it)."""
    sensor = app.parts.sensor
    return (
        (DETECTOR, sensor.detector),
        (LOCATOR, sensor.locator),
        (NAVIGATOR, sensor.navigator),
        (EXPOSURE, app.parts.exposure),
        (OUTPUT, app.outbox.divider),
    )


def test_a_change_makes_anew_what_the_field_declares_and_nothing_else():
    app = App(Settings(BASE), Camera(), Uart(), "test", clock=FrameClock(0))
    for entry in FIELDS:
        before = parts_of(app)
        assert all([part is not None for _, part in before])
        usual = getattr(app.settings, entry.name)
        app.settings.set(entry.name, other_value(entry))
        app.actions.settings_changed(entry.name)
        remade = 0
        for (bit, old), (_, new) in zip(before, parts_of(app)):
            remade |= 0 if new is old else bit
        assert remade == entry.rebuilds & ~RESTART, (entry.name, remade, entry.rebuilds)
        assert not app.faults.active, (entry.name, app.faults.last)
        app.settings.set(entry.name, usual)
        app.actions.settings_changed(entry.name)


class Reads:
    """Settings that note which of them are read."""

    def __init__(self, settings):
        self.settings = settings
        self.names = set()

    def __getattr__(self, name):
        self.names.add(name)
        return getattr(self.settings, name)


def test_fields_declare_what_the_parts_read():
    from exposure import Exposure

    for bit, make in (
        (DETECTOR, lambda settings: make_detector(settings, (160, 120))),
        (LOCATOR, lambda settings: (make_locator(settings, (160, 120)), make_rolling(settings))),
        (NAVIGATOR, make_navigator),
        (EXPOSURE, lambda settings: Exposure(Camera(), settings)),
    ):
        reads = Reads(Settings(BASE))
        make(reads)
        declared = {entry.name for entry in FIELDS if entry.rebuilds & bit}
        declared -= {"exposure", "exposure_us", "gain_db10"}  # read where the policy is chosen
        assert reads.names == declared, (bit, reads.names, declared)


def test_the_line_rate_costs_neither_pose_nor_route():
    app = App(Settings(BASE), Camera(), Uart(), "test", clock=FrameClock(0))
    navigator = app.parts.sensor.navigator
    navigator.pose.state, navigator.route_position = 2, 1
    app.settings.set("rate_divider", 2)
    app.actions.settings_changed("rate_divider")
    assert app.outbox.divider == 2 and app.parts.sensor.navigator is navigator
    assert app.parts.sensor.navigator.pose.state == 2


def test_every_field_declares_something():
    for entry in FIELDS:
        assert 0 < entry.rebuilds <= DETECTOR | LOCATOR | NAVIGATOR | EXPOSURE | OUTPUT | RESTART
    assert field("baud").rebuilds == field("output").rebuilds == field("width").rebuilds == RESTART
