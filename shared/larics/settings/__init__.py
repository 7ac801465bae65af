"""The settings: every one with its range, unit, default and meaning, checked alike on board and PC.

    settings = Settings()
    settings.set("ceiling_mm10", 25000)     ValueError with a one-line reason when that cannot be
    settings.update({"output": "nmea"})     all or nothing
    settings.as_dict()                      JSON-able; Settings(dict) and load(dict) read it back

Kinds and what their values are in Python and JSON:

    int      a whole number low..high
    bool     true or false
    choice   one of `choices` (strings or numbers)
    list     up to `length` whole numbers low..high
    ranges   up to `length` whole numbers low..high or [first, last]
    table    up to `length` rows, lists of as many whole numbers as `columns` has (name, low, high), or of the
             first `needed` ones at least: those that are left out become 0

On the wire every setting is a list of numbers (`numbers`, `set_numbers`): bool is 0 or 1, a choice its
index, a table its rows one after the other, a range its ends.
"""

from larics.settings.constraints import camera_reason, detector_reason, family_reason
from larics.settings.fields import FIELDS

VERSION = 1


def field(name_or_key):
    """The Field of a name or key; None when there is none."""
    for entry in FIELDS:  # seldom asked for: on a board tables of them would take more memory than time
        if entry.name == name_or_key or entry.key == name_or_key:
            return entry
    return None


def validate(name, value):
    """None when the setting exists and may have this value, else one line that says why not."""
    entry = field(name) if isinstance(name, str) else None
    if entry is None:
        return "there is no setting %s" % name
    return entry.reason(value)


def conflict(values):
    """None when the values (name: value, every setting) go together, else one line that says why not."""
    if values["confirm_needed"] > values["confirm_frames"]:
        return "confirm_needed = %d is more than confirm_frames = %d" % (
            values["confirm_needed"],
            values["confirm_frames"],
        )
    return family_reason(values) or detector_reason(values) or camera_reason(values) or _places_reason(values)


def _places_reason(values):
    if not values["map"] and not values["route"]:
        return None
    from larics.locate.marker_map import map_reason  # a board without a map does without these
    from larics.locate.route import route_reason

    return map_reason(
        values["map"], values["allowed_ids"], values["outer_mm10"], values["camera_z_mm10"]
    ) or route_reason(values["route"], values["map"])


class Settings:
    """A set of values that is always valid; each setting is an attribute."""

    def __init__(self, values=None):
        """Defaults, then `values` (name: value). ValueError with a one-line reason."""
        for entry in FIELDS:
            setattr(self, entry.name, entry.full(entry.default))
        if values:
            self.update(values)

    def as_dict(self):
        """Name: value of every setting, and "version"; JSON-able."""
        values = {entry.name: entry.full(getattr(self, entry.name)) for entry in FIELDS}
        values["version"] = VERSION
        return values

    def set(self, name, value):
        self.update({name: value})

    def update(self, changes):
        """Takes all of the changes (name: value) or, with a ValueError, none of them."""
        merged = self.as_dict()
        for name, value in changes.items():
            if name == "version":
                if value != VERSION:
                    raise ValueError("settings of version %s, this is version %d" % (value, VERSION))
                continue
            reason = validate(name, value)
            if reason:
                raise ValueError(reason)
            merged[name] = value
        reason = conflict(merged)
        if reason:
            raise ValueError(reason)
        for name in changes:
            if name != "version":
                setattr(self, name, field(name).full(changes[name]))


def load(values, fixed=None):
    """(Settings, reasons): takes what is valid of a stored dict and tells, line by line, what is not.

    For a board that has to start whatever its file holds: unknown names are left out, and what is not
    allowed, alone or together with the others, keeps its default. `fixed`: name: value of what has to be so.
    """
    settings = Settings(fixed)
    if not isinstance(values, dict):
        return settings, ["the settings are no table of names and values"]
    reasons = []
    good = {}
    for name, value in values.items():
        if name == "version":
            if value != VERSION:
                reasons.append("settings of version %s, this is version %d" % (value, VERSION))
            continue
        reason = validate(name, value)
        if reason:
            reasons.append(reason)
        else:
            good[name] = value
    waiting = sorted([name for name in good if not fixed or name not in fixed])
    while waiting:  # one by one, because a conflict must not cost those that have no part in it
        refused = []
        for name in waiting:
            try:
                settings.set(name, good[name])
            except ValueError as error:
                refused.append((name, str(error)))
        if len(refused) == len(waiting):
            return settings, reasons + [reason for _, reason in refused]
        waiting = [name for name, _ in refused]
    return settings, reasons
