"""The map as a file: versioned JSON.

    {"version": 1,
     "markers": [
      {"id": 3, "x_mm": 0, "y_mm": 1500.5, "heading_deg": 90.0, "height_mm": null, "radius_mm": null,
       "sigma_mm": 1.2, "sigma_deg": 0.08}
     ],
     "route": [3, 5, 3]}

Height (of the marker in the vehicle frame) and radius (of the outer ring) may be null or left out: then
the camera's settings for the ceiling and the size hold. So may the standard deviations of place (along x and
along y) and direction: then those of the settings hold, map_sigma_mm10 and map_sigma_cdeg.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from larics import settings as setting_rules
from larics.wire import messages as m
from larics_host import files
from larics_host.errors import UserError
from larics_host.tables import read_rows

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


VERSION = 1
_FIELDS = ("id", "x_mm", "y_mm", "heading_deg", "height_mm", "radius_mm", "sigma_mm", "sigma_deg")
_REQUIRED = _FIELDS[:4]
_PER_UNIT = (1, 1, 1, 100, 10, 10, 10, 100)  # of the columns of the setting `map`
_HEADING_MOST_DEG = 720.0  # more is no angle that somebody measured


@dataclass
class Marker:
    """Place and direction in the map frame; what follows is None for that of the settings."""

    id: int
    x_mm: float
    y_mm: float
    heading_deg: float
    height_mm: float | None = None
    radius_mm: float | None = None
    sigma_mm: float | None = None
    sigma_deg: float | None = None

    def row(self) -> list[int]:
        """The row of the setting `map`."""
        return [
            self.id,
            round(self.x_mm),
            round(self.y_mm),
            round(100 * self.heading_deg) % 36000,
            round(10 * (self.height_mm or 0)),
            round(10 * (self.radius_mm or 0)),
            math.ceil(10 * (self.sigma_mm or 0)),
            math.ceil(100 * (self.sigma_deg or 0)),
        ]


@dataclass
class Map:
    """Markers in any order, and a route of IDs, which may be empty."""

    markers: list = field(default_factory=list)
    route: list = field(default_factory=list)

    def rows(self) -> list[list[int]]:
        return [marker.row() for marker in self.markers]


def _marker(values, where, as_texts=False):
    """A Marker of a dict of numbers, or of what stands for them in a file of texts; UserError with `where` in
    front."""
    unknown = [name for name in values if name not in _FIELDS]
    if unknown:
        raise UserError("%s: unknown %s; a marker has %s" % (where, unknown[0], ", ".join(_FIELDS)))
    numbers = {}
    for name in _FIELDS:
        value = values.get(name)
        if value in (None, ""):
            if name in _REQUIRED:
                raise UserError("%s: %s is missing" % (where, name))
            numbers[name] = None
            continue
        if isinstance(value, str) and not as_texts:
            text = "%s: %s is the text %s: write a number, without quotes"
            raise UserError(text % (where, name, json.dumps(value)))
        try:
            numbers[name] = float(value)
        except (TypeError, ValueError, OverflowError):
            raise UserError("%s: %s is %.60r, not a number" % (where, name, value)) from None
        if isinstance(value, bool) or not math.isfinite(numbers[name]):
            raise UserError("%s: %s is %.60r, not a number" % (where, name, value))
    if numbers["id"] != int(numbers["id"]):
        raise UserError("%s: id is %r, not a whole number" % (where, values["id"]))
    if abs(numbers["heading_deg"]) > _HEADING_MOST_DEG:
        text = "%s: heading_deg is %g: give degrees, counterclockwise, -360 to 720"
        raise UserError(text % (where, numbers["heading_deg"]))
    numbers["heading_deg"] %= 360
    numbers["id"] = int(numbers["id"])
    marker = Marker(**numbers)
    row = marker.row()
    for name, number, (_, low, high), per_unit in zip(
        _FIELDS, row, setting_rules.field("map").columns, _PER_UNIT, strict=True
    ):
        if not low <= number <= high:
            ends = low // per_unit, high // per_unit
            raise UserError("%s: %s is %g: %d to %d are allowed" % (where, name, numbers[name], *ends))
    return marker


def parse_marker(text: str) -> Marker:
    """A Marker of the option --marker, "ID,X,Y,HEADING[,HEIGHT[,RADIUS[,SIGMA[,SIGMA_DEG]]]]"; of the
    last four, one that is empty is not given."""
    parts, option = text.split(","), "--marker %s" % text
    if not len(_REQUIRED) <= len(parts) <= len(_FIELDS):
        raise UserError("%s: give ID,X,Y,DEG, such as 3,0,1500,90; HEIGHT and RADIUS may follow" % option)
    return _marker(dict(zip(_FIELDS, parts, strict=False)), option, as_texts=True)


def _route(ids, where):
    if not isinstance(ids, list) or not all(type(item) is int and 0 <= item < m.ID_NONE for item in ids):
        raise UserError("%s: the route is a list of IDs" % where)
    return ids


def of_settings(values: dict[str, Any], where: str = "settings") -> Map:
    """The Map in a dict of settings."""
    markers = []
    for row in values.get("map", []):
        rest = [number / unit or None for number, unit in zip(row[4:], (10, 10, 10, 100), strict=False)]
        numbers = [row[0], row[1], row[2], row[3] / 100, *rest, *[None] * (4 - len(rest))]
        markers.append(_marker(dict(zip(_FIELDS, numbers, strict=True)), where))
    return Map(markers, _route(list(values.get("route", [])), where))


def read_map(path: StrPath) -> Map:
    """The Map of a file: of this format, or of settings that hold a map. UserError in one line."""
    data = files.read_json(path)
    if isinstance(data, dict) and "map" in data:
        from larics_host.connection.camera_settings import read_file

        return of_settings(read_file(path), str(path))
    if not isinstance(data, dict) or not isinstance(data.get("markers"), list):
        raise UserError("%s is no map: it has no list of markers" % path)
    if data.get("version") != VERSION:
        told = json.dumps(data.get("version"))
        raise UserError("%s is a map of version %s, this is version %d" % (path, told, VERSION))
    unknown = [name for name in data if name not in ("version", "markers", "route")]
    if unknown:
        raise UserError("%s: unknown %s; a map has version, markers and route" % (path, unknown[0]))
    markers = []
    for number, values in enumerate(data["markers"], 1):
        where = "%s, marker %d" % (path, number)
        if not isinstance(values, dict):
            raise UserError("%s: not a table of names and values" % where)
        markers.append(_marker(values, where))
    return Map(markers, _route(data.get("route", []), str(path)))


def read_csv(path: StrPath) -> list[Marker]:
    """Markers of a survey: a CSV with the columns id, x_mm, y_mm, heading_deg and, if need be, the others."""
    rows = read_rows(path, _FIELDS, _REQUIRED, "a survey")
    return [_marker(row, "%s line %d" % (path, number), as_texts=True) for number, row in rows]


def write_map(path: StrPath, hall: Map) -> None:
    """Writes a Map, one marker a line."""
    lines = []
    for marker in hall.markers:
        values = {name: getattr(marker, name) for name in _FIELDS}
        for name in ("x_mm", "y_mm", "heading_deg", "sigma_mm", "sigma_deg"):
            values[name] = None if values[name] is None else round(values[name], 2)
        lines.append("  " + json.dumps(values))
    text = '{\n "version": %d,\n "markers": [\n%s\n ],\n "route": %s\n}\n' % (
        VERSION,
        ",\n".join(lines),
        json.dumps(hall.route),
    )
    files.write_file(path, text)
