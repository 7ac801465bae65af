"""What a camera with given settings reports of single frames, for whoever draws or judges them on this PC."""

from __future__ import annotations

from typing import Any

import numpy as np

from larics.device.sensor import EVERY_PART, Sensor
from larics.settings import Settings
from larics_host.detection.detectors import as_dict
from larics_host.errors import UserError

# what makes a frame depend on those before it
ALONE = {"tracking": False, "confirm_needed": 1}


class CameraView:
    """The camera's own detector, lens and map, made of its settings (name: value, the rest defaults) as the
    firmware makes them. UserError when they do not suit frames of that size."""

    def __init__(self, settings: dict[str, Any], width: int, height: int) -> None:
        try:
            values = Settings({**settings, **ALONE, "width": width, "height": height})
            self._sensor = Sensor(values)
            self._sensor.rebuild(EVERY_PART)
        except ValueError as error:
            raise UserError(
                "the settings do not suit frames of %d x %d: %s" % (width, height, error)
            ) from None

    def detect(self, frame: np.ndarray) -> list[dict[str, Any]]:
        """The markers that would be reported of a frame ((height, width) uint8), best first: dicts as of
        `detectors.as_dict`, `id` being that on the wire."""
        sensor, shown = self._sensor, []
        for found in sensor.detector.detect(np.ascontiguousarray(frame).reshape(-1)):
            if sensor.place([found]):
                marker_id = sensor.measurements[0].marker_id
                shown.append({**as_dict(found), "id": marker_id if marker_id >= 0 else None})
        return shown
