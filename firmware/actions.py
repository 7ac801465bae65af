"""What commands from the wire do to the running program; see larics.device.commands."""

from larics.settings import field
from larics.settings.fields import FIELDS, OUTPUT
from status import VERSION

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

# generated: begin indices (tools/make_protocol.py)
_INFO_VERSION_MAJOR = const(2)
_INFO_VERSION_MINOR = const(3)
_INFO_VERSION_PATCH = const(4)
_INFO_WIDTH = const(5)
_INFO_HEIGHT = const(6)
_INFO_SETTINGS = const(7)
_INFO_BOARD = const(8)
_INFO_UNIQUE_ID = const(9)
# generated: end indices


class Actions:
    """watch, settings, parts, faults   as in app.App; keeper: settings_store.SettingsStore, or None where
    settings cannot be kept; board: its name; unique_id: of the processor, bytes. `outbox` and `raw` are set
    when they are made."""

    def __init__(self, watch, settings, parts, faults, keeper, board, unique_id):
        self._watch = watch
        self._settings = settings
        self._parts = parts
        self._faults = faults
        self._keeper = keeper
        self._board, self._unique_id = board, unique_id
        self._copy = None
        self.outbox = self.raw = None

    def info(self, values):
        values[_INFO_VERSION_MAJOR], values[_INFO_VERSION_MINOR], values[_INFO_VERSION_PATCH] = VERSION
        camera = self._watch.camera
        values[_INFO_WIDTH], values[_INFO_HEIGHT] = camera.width, camera.height
        values[_INFO_SETTINGS] = max(entry.key for entry in FIELDS)
        values[_INFO_BOARD] = padded(self._board, 16)
        values[_INFO_UNIQUE_ID] = padded(self._unique_id, 12)

    def settings_changed(self, name):
        """Takes a new value into use: what the setting declares is made anew, and nothing else.

        False when there is no memory for it; then `settings_restored` must follow."""
        rebuilds = field(name).rebuilds
        if rebuilds & OUTPUT:
            self.outbox.divider = self._settings.rate_divider
        return self._parts.rebuild(rebuilds)

    def settings_restored(self, name):
        """Goes on with the value before, whose parts had fitted. False when there is no detector even so."""
        self._parts.restore(field(name).rebuilds)
        return self._parts.sensor.detector is not None

    def save(self):
        """False when the settings could not be kept. Where a whole detector leaves no piece of memory that is
        long enough, it is given up meanwhile."""
        if self._keeper is None:
            return False
        try:
            return self._keeper.save(self._settings)
        except MemoryError:
            return self._parts.without_detector(self._save)

    def _save(self):
        try:
            return self._keeper.save(self._settings)
        except MemoryError:
            return False

    def raw_frame(self):
        camera = self._watch.camera
        if not camera.frame:
            return None
        try:
            if self._copy is None or len(self._copy) != len(camera.frame):
                self._copy = None
                self._copy = bytearray(len(camera.frame))
        except MemoryError:  # the frame itself, then, and no other until it is sent
            self._watch.hold(self.raw)
            return camera.frame, camera.width, camera.height, self._watch.frame_number
        self._copy[:] = camera.frame
        return self._copy, camera.width, camera.height, self._watch.frame_number

    def window(self):
        camera = self._watch.camera
        return self._parts.sensor.window(camera.width, camera.height)


def padded(text, size):
    """Text or bytes as exactly `size` bytes, cut or filled with zeros."""
    data = text.encode() if isinstance(text, str) else bytes(text)
    return (data + bytes(size))[:size]
