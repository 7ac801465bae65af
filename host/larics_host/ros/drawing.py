"""The map and what is seen, as visualization_msgs/MarkerArray: rings, arrows along the orientation lines,
IDs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from larics.marker import LARICS3
from larics.wire import messages as m
from larics_host.connection.records import known
from larics_host.ros.frames import quaternion
from larics_host.ros.topics import header, time_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

_ARROW, _CYLINDER, _LINE_STRIP, _TEXT = 0, 3, 4, 9
_ADD, _DELETE = 0, 2
_PARTS = 3  # of one marker: ring, arrow, text
_THIN_M = 0.005
_SEEN_NS = 500_000_000  # what nobody renews is no longer seen

_MAPPED = (0.85, 0.85, 0.9)
_CERTAIN = (0.0, 0.8, 0.3)
_UNCERTAIN = (1.0, 0.65, 0.0)  # amber, as in the pictures of `larics detect`
_ROUTE = (0.2, 0.5, 1.0)


class _Layer:
    """Collects the parts of one namespace in one frame."""

    def __init__(self, stamp_ns, frame, name, lifetime_ns=0):
        self._base = {"header": header(stamp_ns, frame), "ns": name, "lifetime": time_of(lifetime_ns)}
        self.parts = []

    def add(self, number, kind, colour, pose=None, **more):
        red, green, blue = colour
        colours = {"r": red, "g": green, "b": blue, "a": 0.8}
        pose = {"orientation": {"w": 1.0}} if pose is None else pose
        told = {**self._base, "id": number, "type": kind, "action": _ADD, "pose": pose, "color": colours}
        self.parts.append({**told, **more})

    def delete(self, number):
        self.parts.append({**self._base, "id": number, "action": _DELETE})

    def marker(self, index, place, angle_rad, outer_m, colour, text):
        """place: x, y, z in m."""
        position = dict(zip("xyz", place, strict=True))
        flat = {"position": position, "orientation": quaternion(angle_rad)}
        number = _PARTS * index
        disc = {"x": 2 * outer_m, "y": 2 * outer_m, "z": _THIN_M}
        self.add(number, _CYLINDER, colour, flat, scale=disc)
        end_m = outer_m * LARICS3.orientation_end_mm10 / LARICS3.outer_mm10
        arrow = {"x": end_m, "y": outer_m / 4, "z": _THIN_M}
        self.add(number + 1, _ARROW, colour, flat, scale=arrow)
        above = {"position": {**position, "z": position["z"] + outer_m}, "orientation": {"w": 1.0}}
        self.add(number + 2, _TEXT, colour, above, scale={"z": outer_m}, text=text)


class Sightings:
    """What is seen of one frame after the other, in the frame of the vehicle."""

    def __init__(self, frame: str) -> None:
        self.outer_m = LARICS3.outer_mm10 / 1e4  # of markers whose size nobody told
        self._frame = frame
        self._shown = 0

    def array(self, markers: Iterable[Any], stamp_ns: int) -> dict[str, Any]:
        """A MarkerArray of the MARKER records of one frame; what the frame before had and this has not goes.
        A marker whose offset is not known, without a calibration, has no place to be drawn at."""
        layer = _Layer(stamp_ns, self._frame, "seen", _SEEN_NS)
        count = 0
        for record in markers:
            place = [known(record, "%s_mm10" % axis) for axis in "xyz"]
            heading = known(record, "heading_cdeg")
            if None in place or heading is None:
                continue
            marker_id = known(record, "id")
            unsure = marker_id is None or record.flags & m.MARKER_UNCONFIRMED
            layer.marker(
                count,
                [value / 1e4 for value in place],
                math.radians(heading / 100),
                self.outer_m,
                _UNCERTAIN if unsure else _CERTAIN,
                "ID ?" if marker_id is None else "ID %d" % marker_id,
            )
            count += 1
        for number in range(_PARTS * count, _PARTS * self._shown):
            layer.delete(number)
        self._shown = count
        return {"markers": layer.parts}


def map_array(
    rows: Sequence[Sequence[int]],
    route: Sequence[int],
    settings: Mapping[str, Any],
    frame: str,
    stamp_ns: int,
) -> dict[str, Any]:
    """A MarkerArray of a map: rows of the setting `map`, IDs of the route.

    settings: may tell ceiling_mm10 and outer_mm10. A marker whose height nobody told is drawn on the floor,
    and says so."""
    layer = _Layer(stamp_ns, frame, "map")
    places: dict[int, dict[str, float]] = {}
    for index, row in enumerate(rows):
        marker_id, x_mm, y_mm, heading_cdeg, height_mm10, outer_mm10 = row[:6]
        height = height_mm10 or settings.get("ceiling_mm10", 0)
        outer = outer_mm10 or settings.get("outer_mm10", LARICS3.outer_mm10)
        place = x_mm / 1e3, y_mm / 1e3, height / 1e4
        text = "ID %d" % marker_id + ("" if height else " (height ?)")
        layer.marker(index, place, math.radians(heading_cdeg / 100), outer / 1e4, _MAPPED, text)
        places.setdefault(marker_id, dict(zip("xyz", place, strict=True)))
    way = [places[marker_id] for marker_id in route if marker_id in places]
    if len(way) > 1:
        line = _Layer(stamp_ns, frame, "route")
        line.add(0, _LINE_STRIP, _ROUTE, scale={"x": 0.03}, points=way)
        layer.parts += line.parts
    return {"markers": layer.parts}
