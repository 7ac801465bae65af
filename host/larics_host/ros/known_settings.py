"""The camera's settings, put together from SETTING messages that pass."""

from __future__ import annotations

from typing import Any

from larics import settings as setting_rules

MOUNTING = (
    "camera_x_mm10", "camera_y_mm10", "camera_z_mm10", "mount_cdeg", "tilt_forward_cdeg", "tilt_left_cdeg",
)  # fmt: skip
HALL = ("ceiling_mm10", "outer_mm10", "route", "map")


class KnownSettings:
    """`values`: {name: value} of what is known, of a file and of messages, the newer instead of the older."""

    def __init__(self, values: dict[str, Any] | None = None) -> None:
        self.values: dict[str, Any] = dict(values or {})
        self._parts: dict[int, dict[int, int]] = {}

    def add(self, fields: Any) -> str | None:
        """Takes a SETTING record; the name of the setting when that made it whole and new."""
        field = setting_rules.field(fields.key)
        if field is None:
            return None
        if fields.first == 0:
            self._parts[fields.key] = {}
        parts = self._parts.setdefault(fields.key, {})
        parts.update(enumerate(fields.values, fields.first))
        if any(index not in parts for index in range(fields.count)):
            return None
        value = field.value([parts[index] for index in range(fields.count)])
        if value is None or (field.name in self.values and self.values[field.name] == value):
            return None
        self.values[field.name] = value
        return field.name

    def has(self, *names: str) -> bool:
        """Whether all of these are known."""
        return all(name in self.values for name in names)
