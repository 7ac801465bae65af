"""The `larics` command and the Python API, of which the names below are what others use: PC only.

    from larics_host import Camera

They are imported when they are first asked for; importing this package alone costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from larics_host.api.camera import Camera, CameraError, Picture
    from larics_host.api.items import Health, Item, Measurement, Motion, NothingSeen, Pose, Started

_MODULES = {
    "Camera": "camera",
    "CameraError": "camera",
    "Picture": "camera",
    "Health": "items",
    "Item": "items",
    "Measurement": "items",
    "Motion": "items",
    "NothingSeen": "items",
    "Pose": "items",
    "Started": "items",
}

__all__ = [
    "Camera",
    "CameraError",
    "Health",
    "Item",
    "Measurement",
    "Motion",
    "NothingSeen",
    "Picture",
    "Pose",
    "Started",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    import importlib

    return getattr(importlib.import_module("larics_host.api." + _MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
