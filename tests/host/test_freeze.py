"""What others build on is as it was when it was frozen: see tests/freeze/README.md."""

import pytest

from frozen_frames import FRAMES
from larics.marker import golay
from larics.settings import FIELDS
from larics.wire import messages as m
from larics_host import cli
from larics_host.connection.client import Client
from tests.freeze import encoder, present, tables

# table: what it holds now, the columns that name a row, what is to be done instead of a change
FROZEN = {
    "messages.txt": (
        present.messages,
        ("message", "field"),
        "A type of message never changes: what needs another field, unit, range or meaning becomes a "
        "new type with a new number, beside the old one in shared/larics/wire/messages.py. Only when most "
        "types change, VERSION goes up, and this table begins anew.",
    ),
    "codes.txt": (
        present.codes,
        ("name",),
        "A number keeps its meaning: take the next free one (shared/larics/wire/messages.py, wire_names.py).",
    ),
    "settings.txt": (
        present.settings,
        ("name",),
        "A setting keeps key, name, kind, default, unit and meaning, and what was allowed stays allowed: "
        "take a new name with a new key in shared/larics/settings/fields.py.",
    ),
    "markers.txt": (
        present.markers,
        ("family", "what"),
        "Markers hang for years and are read by every later version: add a new family beside them.",
    ),
    "columns.txt": (
        present.columns,
        ("file", "column"),
        "Columns keep name and place: add one after the others.",
    ),
    "commands.txt": (
        present.commands,
        ("command", "option"),
        "Options keep name, argument and default: add another one; the old one goes on as "
        "docs/compatibility.md says.",
    ),
    "api.txt": (
        present.api,
        ("module", "name"),
        "Names, arguments and defaults stay: add a new name, or an argument with a default after the others.",
    ),
    "vehicle.txt": (
        present.vehicle,
        ("header", "name", "what"),
        "Vehicles are compiled against this: add a new name, or a member after the others.",
    ),
}


def wrong(name):
    """What is another than frozen in a table, with what to do; empty when nothing is."""
    now, key, advice = FROZEN[name]
    found = tables.changes(tables.rows(name), list(now()), key)
    if not found:
        return ""
    where = (
        "What was only added, or is only said more clearly, is written into tests/freeze/%s by hand." % name
    )
    return "\n".join(["tests/freeze/%s:" % name, *found, advice, where])


@pytest.mark.parametrize("name", FROZEN)
def test_nothing_frozen_has_changed(name):
    assert not wrong(name), wrong(name)


@pytest.mark.parametrize("name", FROZEN)
def test_every_cell_counts(name):
    """A cell changed, a row taken away or added, two exchanged: all of it is noticed."""
    key = FROZEN[name][1]
    all_rows = tables.rows(name)
    assert len({tuple(row[column] for column in key) for row in all_rows}) == len(all_rows) > 20
    frozen = all_rows[:: len(all_rows) // 20]
    assert tables.changes(frozen, frozen, key) == []
    for number, row in enumerate(frozen):
        others = frozen[:number] + frozen[number + 1 :]
        assert tables.changes(frozen, others, key) == ["gone: " + tables.line(row)]
        assert tables.changes(others, frozen, key) == ["not in the table yet: " + tables.line(row)]
        for column in row:
            now = [*others, {**row, column: row[column] + "x"}]
            assert any(row[column] + "x" in line for line in tables.changes(frozen, now, key))
    assert tables.changes(frozen, [*frozen[1:], frozen[0]], key) == ["in another order"]


def of_type(change, name="MARKER"):
    """MESSAGES in which one message is what `change` makes of its (name, number, meaning, fields)."""
    return tuple(change(*one) if one[0] == name else one for one in m.MESSAGES)


def with_field(place, **new):
    """A change of the field at a place."""

    def change(name, number, meaning, fields):
        names = ("name", "code", "unit", "least", "most", "meaning")
        field = {**dict(zip(names, fields[place], strict=True)), **new}
        return name, number, meaning, (*fields[:place], tuple(field.values()), *fields[place + 1 :])

    return change


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda a, b, c, d: (a, b, c, (*d[:6], d[7], d[6], *d[8:])), "MARKER y_mm10: byte was '18', is '14'"),
        (with_field(3, code="I"), "MARKER id: code was 'H', is 'I'"),
        (with_field(6, unit="mm"), "MARKER x_mm10: unit was '0.1 mm', is 'mm'"),
        (with_field(6, most=2000000), "MARKER x_mm10: most was '1000000', is '2000000'"),
        (with_field(9, meaning="image top, map frame"), "MARKER heading_cdeg: meaning was 'orientation line"),
        (with_field(10, name="trust"), "gone: 2 | MARKER | 28 | margin"),
        (lambda a, b, c, d: (a, 42, c, d), "MARKER margin: type was '2', is '42'"),
        (lambda a, b, c, d: (a, b, "all markers of a frame", d), "MARKER : meaning was 'one marker in one"),
        (lambda a, b, c, d: (a, b, c, d[:-1]), "gone: 2 | MARKER | 33 | sigma_mdeg"),
        (
            lambda a, b, c, d: (a, b, c, (*d, ("more", "B", "", 0, 1, ""))),
            "not in the table yet: 2 | MARKER | 35",
        ),
    ],
)
def test_a_changed_message_is_noticed(change, said, monkeypatch):
    monkeypatch.setattr(m, "MESSAGES", of_type(change))
    assert said in wrong("messages.txt") and "new type with a new number" in wrong("messages.txt")


def test_a_new_message_asks_for_its_rows(monkeypatch):
    monkeypatch.setattr(m, "MESSAGES", (*m.MESSAGES, ("NEW", 11, "what is new", (m.MESSAGES[0][3][0],))))
    lines = wrong("messages.txt").splitlines()
    assert (
        "not in the table yet: 11 | NEW |  |  |  |  |  |  | what is new" in lines and "by hand" in lines[-1]
    )


def changed_field(number, **changes):
    """FIELDS in which one is another."""
    one = FIELDS[number]
    names = (
        "key",
        "name",
        "rebuilds",
        "kind",
        "default",
        "low",
        "high",
        "unit",
        "meaning",
        "choices",
        "length",
    )
    new = type(one)(**{**{name: getattr(one, name) for name in names}, **changes})
    return (*FIELDS[:number], new, *FIELDS[number + 1 :])


METHOD = [field.name for field in FIELDS].index("method")


@pytest.mark.parametrize(
    "number, changes, said",
    [
        (0, {"key": 99}, "width: key was '1', is '99'"),
        (0, {"name": "columns"}, "gone: 1 | width"),
        (0, {"default": 640}, "width: default was '320', is '640'"),
        (0, {"high": 512}, "width: allowed was '80..1024', is '80..512'"),
        (0, {"unit": "mm"}, "width: unit was 'px', is 'mm'"),
        (METHOD, {"choices": ("paper", "larics")}, "method: allowed was"),
    ],
)
def test_a_changed_setting_is_noticed(number, changes, said, monkeypatch):
    monkeypatch.setattr(present, "FIELDS", changed_field(number, **changes))
    assert said in wrong("settings.txt")


def test_a_changed_code_is_noticed(monkeypatch):
    order = golay.ORDER
    monkeypatch.setattr(golay, "ORDER", order[1:2] + order[:1] + order[2:])
    found = wrong("markers.txt")
    assert "coded cells of 9: value was" in found and "coded SHA-256 of IDs and cells: value was" in found


def test_a_changed_argument_is_noticed(monkeypatch):
    monkeypatch.setattr(Client, "get", lambda self, key: None)
    assert "Client.get: told was '(name)', is '(key)'" in wrong("api.txt")


def test_a_changed_option_is_noticed(monkeypatch):
    monkeypatch.setattr(cli, "COMMANDS", [name for name in cli.COMMANDS if name != "replay"])
    assert "gone: larics replay | --rounds | a value |  | 1" in wrong("commands.txt")


# bytes


def test_the_frozen_bytes_are_those_of_an_independent_encoder():
    codes = {}
    for row in tables.rows("messages.txt"):
        if row["field"]:
            codes.setdefault(int(row["type"]), []).append(row["code"])
    for number, sequence, values, text in FRAMES:
        assert encoder.frame(number, sequence, codes[number], values).hex() == text
    assert {frame[0] for frame in FRAMES} == set(codes)


def test_every_field_is_frozen_at_its_least_and_most():
    told = {}
    for number, _, values, _ in FRAMES:
        told.setdefault(number, []).append(values)
    place = {}
    for row in tables.rows("messages.txt"):
        if row["field"]:
            number = int(row["type"])
            k = place.setdefault(number, 0)
            place[number] += 1
            values = {frame[k] for frame in told[number]}
            ends = int(row["least"]), int(row["most"])
            if row["code"][-1] == "s":
                ends = (bytes([end]) * int(row["code"][:-1]) for end in ends)
            assert values.issuperset(ends), row
