"""Settings: every limit, conflicts, and the way to and from dicts and the wire."""

import gc

from larics import settings as s
from larics.device.factory import make_detector, make_locator
from larics.settings.constraints import calibrated_camera, camera_reason, seen_ids
from larics.settings.fields import FIELDS, Field


def _refused(changes, *words):
    settings = s.Settings()
    before = settings.as_dict()
    try:
        settings.update(changes)
    except ValueError as error:
        text = str(error)
        assert "\n" not in text
        for word in words:
            assert word in text, (word, text)
    else:
        raise AssertionError("%s was accepted" % changes)
    assert settings.as_dict() == before
    return text


def test_keys_and_names_are_unique():
    assert len({field.key for field in FIELDS}) == len(FIELDS)
    assert len({field.name for field in FIELDS}) == len(FIELDS)
    assert all(1 <= field.key <= 255 for field in FIELDS)


def test_a_setting_holds_only_what_differs():
    plain = Field(1, "one", 0, "int", 0, 0, 9, "", "")
    assert sorted(plain.__dict__) == ["high", "key", "name", "rebuilds"]
    assert (plain.kind, plain.default, plain.low, plain.high) == ("int", 0, 0, 9)
    assert (plain.unit, plain.meaning, plain.choices, plain.length, plain.columns) == ("", "", (), 0, ())
    full = Field(2, "two", 1, "list", (7,), -1, 9, "mm", "what", length=3)
    assert (full.kind, full.default, full.low, full.unit, full.meaning) == ("list", (7,), -1, "mm", "what")
    assert full.length == 3
    assert Field(3, "three", 0, "bool", False, 0, 1, "", "").default is False


def test_defaults_are_valid():
    settings = s.Settings()
    values = settings.as_dict()
    for field in FIELDS:
        assert s.validate(field.name, values[field.name]) is None
        assert field.meaning
    assert s.conflict(values) is None
    assert s.Settings(values).as_dict() == values


def test_limits_of_every_number():
    for field in FIELDS:
        if field.kind != "int":
            continue
        for value in (field.low, field.high):
            assert field.reason(value) is None
        for value in (field.low - 1, field.high + 1, "5", None, True, [1]):
            assert field.name in field.reason(value)


def test_other_kinds():
    assert s.validate("mirrored", True) is None
    assert "true or false" in s.validate("mirrored", 1)
    assert s.validate("baud", 921600) is None
    assert "9600, 19200" in s.validate("baud", 12345)
    assert "larics, nmea or mavlink" in s.validate("output", "xml")
    assert "must be a list" in s.validate("route", 5)
    assert "route[1] = 65535" in s.validate("route", [1, 65535])
    assert "at most 64" in s.validate("route", [1] * 65)
    assert s.validate("map", [[1, 0, -5000, 9000, 0, 0]]) is None
    assert "map[0]" in s.validate("map", [[1, 0, 0]])
    assert "map[1]" in s.validate("map", [[1, 0, 0, 0, 0, 0], [2, 0, 0, 36000, 0, 0]])
    assert "no setting" in s.validate("colour", 1)


def test_conflicts():
    _refused({"focal_q8": 100}, "focal_q8", "5120")
    _refused({"radius_min_px": 61}, "radius_max_px = 60")
    _refused({"radius_min_px": 62, "radius_max_px": 70, "height": 120}, "320x120")
    _refused({"confirm_needed": 3}, "confirm_frames")
    _refused({"line_mm10": 600}, "line_mm10", "outer_mm10")
    _refused({"ceiling_mm10": 100, "camera_z_mm10": 100}, "ceiling_mm10")
    _refused({"allowed_ids": [0, 1]}, "allow_id0")
    _refused({"map": [[1, 0, 0, 0, 0, 0], [1, 1, 1, 1, 0, 0]]}, "marker 1 twice")
    _refused({"map": [[1, 0, 0, 0, 0, 0]], "route": [1, 2]}, "route step 2", "marker 2")
    _refused({"route": [1, 1]}, "route step 2", "impossible step")
    _refused({"version": 2}, "version 2")
    s.Settings({"allowed_ids": [0, 1], "allow_id0": True})


def test_update_is_all_or_nothing():
    _refused({"width": 640, "height": 480, "rate_divider": 0}, "rate_divider")


def test_values_are_copied():
    route = [1, 2]
    settings = s.Settings({"route": route})
    route.append(999)
    settings.as_dict()["route"].append(999)
    assert settings.route == [1, 2]


def test_wire_numbers_round_trip():
    settings = s.Settings(
        {
            "output": "mavlink",
            "mirrored": True,
            "route": [1, 2, 1],
            "map": [[1, -5, 6, 7, 0, 0], [2, 8, 999, 10, 25000, 750, 12, 9]],
        }
    )
    for field in FIELDS:
        value = getattr(settings, field.name)
        numbers = field.numbers(value)
        assert len(numbers) <= field.most_numbers()
        assert field.value(numbers) == value
    numbers = [1, -5, 6, 7, 0, 0, 0, 0, 2, 8, 999, 10, 25000, 750, 12, 9]
    assert s.field("map").numbers(settings.map) == numbers
    assert s.field("map").reason([[1, 0, 0, 0, 0]]) and s.field("map").reason(
        [[1] * 9]
    )  # too short, too long
    assert s.field("map").value([1, 2, 3]) is None
    assert s.field("baud").value([1, 2]) is None
    assert s.field("baud").reason(s.field("baud").value([99])) is not None
    assert s.field("mirrored").reason(s.field("mirrored").value([2])) is not None
    assert s.field(41).name == "output" and s.field(200) is None


def test_load_keeps_what_is_valid():
    stored = s.Settings({"radius_min_px": 62, "radius_max_px": 70, "line_mm10": 600, "outer_mm10": 3000})
    stored = stored.as_dict()
    settings, reasons = s.load(stored)
    assert reasons == [] and settings.as_dict() == stored
    stored["radius_max_px"] = 6
    stored["colour"] = "red"
    stored["baud"] = 1
    settings, reasons = s.load(stored)
    assert len(reasons) == 4  # both radii, each in conflict with the default of the other
    assert settings.line_mm10 == 600 and settings.outer_mm10 == 3000
    assert settings.baud == 115200
    assert settings.radius_min_px <= settings.radius_max_px
    assert s.load([1])[1] and s.load([1])[0].as_dict() == s.Settings().as_dict()
    assert "version 9" in s.load({"version": 9})[1][0]


def test_what_the_detector_or_the_camera_would_refuse():
    for method in ("larics", "paper"):
        _refused({"method": method, "radius_min_px": 5}, "radius_min_px = 5", "6..72")
        _refused({"method": method, "radius_max_px": 73}, "radius_max_px = 73", "6..72")
        _refused({"method": method, "radius_min_px": 60}, "not below radius_max_px = 60")
        s.Settings({"method": method, "radius_min_px": 6, "radius_max_px": 72})
    _refused({"line_mm10": 40}, "line_mm10", "50 and 300")
    _refused({"allowed_ids": [3, 16]}, "ID 16", "coded family")
    _refused({"allowed_ids": [3, 9], "family": "plain"}, "ID 9", "plain family has IDs 1 to 7")
    _refused({"allowed_ids": [[8, 20]], "family": "plain"}, "IDs 8 to 20", "plain family")
    _refused({"map": [[9, 0, 0, 0, 0, 0]], "family": "plain"}, "map has marker 9", "plain family")
    _refused({"map": [[8, 0, 0, 0, 0, 0]]}, "map has marker 8", "coded family")
    _refused({"family": "golay"}, "family = golay", "plain or coded")
    _refused({"focal_q8": 5120}, "focal_q8 = 5120", "corner")
    _refused({"focal_q8": 400 * 256, "k1_e5": -90000}, "corner")
    _refused({"ceiling_mm10": 290000, "camera_z_mm10": -100000}, "262143")


def test_allowed_ids_are_ranges_of_thousands():
    field = s.field("allowed_ids")
    allowed = [[1, 3], 5, [9, 4094]]
    settings = s.Settings({"allowed_ids": allowed})
    assert settings.allowed_ids == allowed
    numbers = field.numbers(allowed)
    assert numbers == [1, 3, 5, 5, 9, 4094] and field.value(numbers) == allowed
    assert field.value([1]) is None and field.value([0, 1] * 33) is None
    assert field.most_numbers() == 64
    assert "at most 32" in s.validate("allowed_ids", [1] * 33)
    for bad in ([[3, 1]], [[1, 2, 3]], [[1, 4095]], [-1], ["1-3"]):
        assert "allowed_ids[0]" in s.validate("allowed_ids", bad)


def test_allowed_ids_of_a_mirrored_sensor():
    # plain markers show 1 for 4 and the other way round; what is coded is put right where it is read
    assert seen_ids([1, 2, [9, 20]], False) == [1, 2, [9, 20]]
    assert seen_ids([1, 2, [9, 20], 100], True) == [4, 2, (9, 20), (100, 100)]
    assert seen_ids([[6, 12]], True) == [3, 7, (8, 12)]
    assert seen_ids([], True) == []


def _drawn_values(seed):
    """Values that are each allowed, pressed to where they conflict, from a small generator."""
    values = {}
    for field in FIELDS:
        if field.name in ("route", "map", "allowed_ids"):
            continue
        seed = (seed * 1103515245 + 12345) & 0x7FFFFFFF
        draw = seed >> 12
        if field.name in ("radius_min_px", "radius_max_px"):
            values[field.name] = 6 + draw % 67
        elif field.name in ("width", "height"):
            values[field.name] = (80, 160, 240, 320)[draw % 4]
        elif field.name in ("k1_e5", "k2_e5"):
            values[field.name] = draw % 20001 - 10000
        elif field.name == "focal_q8":
            values[field.name] = draw % 200000
        elif field.name in ("center_x_q8", "center_y_q8"):
            values[field.name] = draw % 90000
        elif field.name == "line_mm10":
            values[field.name] = draw % 500
        elif field.kind == "int":
            values[field.name] = field.low + draw % (field.high - field.low + 1)
        elif field.kind == "bool":
            values[field.name] = bool(draw & 1)
        else:
            values[field.name] = field.choices[draw % len(field.choices)]
    return values


def test_what_the_settings_allow_can_be_made():
    made = refused = 0
    for seed in range(150):
        for_one = s.Settings()
        values = _drawn_values(seed)
        for name in sorted(values):  # one after the other, as over the wire
            try:
                for_one.set(name, values[name])
            except ValueError:
                refused += 1
        if seed % 8 == 0:
            gc.collect()  # the largest of them needs 200 KB in one piece
            make_detector(for_one)
        make_locator(for_one)
        made += 1
    assert made == 150 and refused > 150


def test_what_the_camera_refuses_is_a_conflict():
    refused = 0
    for seed in range(60):
        values = s.Settings().as_dict()
        values.update(_drawn_values(seed))
        values["focal_q8"] = max(5120, values["focal_q8"])
        try:
            calibrated_camera(values["width"], values["height"], values)
        except ValueError:
            refused += 1
            assert camera_reason(values)
        else:
            assert camera_reason(values) is None
    assert 5 < refused < 60


def test_load_with_a_fixed_size():
    stored = s.Settings({"width": 80, "height": 60, "focal_q8": 40 * 256, "baud": 9600}).as_dict()
    settings, reasons = s.load(stored, {"width": 160, "height": 120})
    assert (settings.width, settings.height, settings.baud, settings.focal_q8) == (160, 120, 9600, 0)
    assert len(reasons) == 1 and "focal_q8" in reasons[0]
