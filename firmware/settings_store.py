"""The settings between flash and program: never without valid ones, whatever the file holds."""

import json

from atomic_file import CORRUPT, MISSING, RESTORED
from larics.settings import VERSION, Settings, load
from larics.settings.fields import FIELDS
from larics.wire import messages as m


def texts(settings):
    """The JSON text of all settings, in pieces short enough for the smallest heaps."""
    yield "{"
    for entry in FIELDS:
        yield '"%s": ' % entry.name
        value = getattr(settings, entry.name)
        if isinstance(value, list):
            yield "["
            for index in range(len(value)):
                yield (", " if index else "") + json.dumps(value[index])
            yield "]"
        else:
            yield json.dumps(value)
        yield ", "
    yield '"version": %d}' % VERSION


class SettingsStore:
    """`store`: atomic_file.AtomicFile. Each trouble is a fault: what lasts until the next
    save begins; what is over is counted."""

    def __init__(self, store, faults):
        self._store = store
        self._faults = faults

    def load(self):
        """The Settings on the flash, as far as they are valid; defaults for the rest."""
        faults = self._faults
        text, state = self._store.load()
        if state == MISSING:
            faults.begin(m.FAULT_SETTINGS_MISSING)
        elif state == RESTORED:
            faults.report(m.FAULT_SAVE_INTERRUPTED)
        elif state == CORRUPT:
            faults.begin(m.FAULT_SETTINGS_CORRUPT)
        if text is None:
            return Settings()
        try:
            values = json.loads(text)
        except ValueError:
            values = None
        if isinstance(values, dict) and values.get("version", VERSION) != VERSION:
            faults.begin(m.FAULT_SETTINGS_VERSION)
            values.pop("version")
        settings, reasons = load(values)
        if reasons and not faults.active >> m.FAULT_SETTINGS_VERSION & 1:
            faults.begin(m.FAULT_SETTINGS_CORRUPT)
        return settings

    def save(self, settings):
        """Writes them; False when the flash did not take them, and the old ones are kept."""
        faults = self._faults
        try:
            self._store.save(texts(settings))
        except OSError:
            faults.begin(m.FAULT_STORAGE)
            return False
        for code in (
            m.FAULT_STORAGE,
            m.FAULT_SETTINGS_MISSING,
            m.FAULT_SETTINGS_CORRUPT,
            m.FAULT_SETTINGS_VERSION,
        ):
            faults.end(code)
        return True
