"""What our method is to reach, and whether a run's results do."""

from typing import NamedTuple


class Target(NamedTuple):
    """Limits on one number of the results: the value is to be at least, or else at most, `must` and `aim`."""

    label: str
    value: float
    must: float | None  # None: only an aim
    aim: float
    at_least: bool = False

    def verdict(self):
        """In words, what is reached."""
        if self._keeps(self.aim):
            return "aim reached"
        if self.must is None:
            return "aim missed"
        return "reached" if self._keeps(self.must) else "MISSED"

    def _keeps(self, limit):
        return self.value >= limit if self.at_least else self.value <= limit


_DETECTED = {"sunny": (99.8, 100), "double": (99.8, 100), "fast": (99.8, 100), "cloudy": (99.5, 99.9)}
_DETECTED["harsh"] = (90, 97)
_WRONG = {"sunny": (0, 0), "double": (0, 0), "fast": (0, 0), "cloudy": (0.1, 0), "harsh": (0.3, 0.05)}
_ERRORS = {
    "sunny": ((0.02, 0.005), (0.05, 0.012), (0.02, 0.008), (0.08, 0.025)),
    "cloudy": ((0.05, 0.02), (0.12, 0.05), (0.06, 0.04), (0.2, 0.12)),
}
_ERROR_KEYS = ("centre_median_px", "centre_p95_px", "heading_median_deg", "heading_p95_deg")
_STRESSES = {  # the worst value at which 95 % are found without a wrong ID: must, aim
    "radius": (8, 6),
    "blur": (8, 12),
    "defocus": (2.5, 3.5),
    "tilt": (25, 35),
    "contrast": (8, 5),
}
_COSTS = {  # million instructions of a frame
    "search": (("mean", 2.0, 1.1), ("max", 3.5, 2.0)),
    "track": (("mean", 0.8, 0.45),),
    "search, radius 10 to 66 px": (("mean", 7, 4),),
}
_MEMORY = {"search": (96, 64), "search, radius 10 to 66 px": (128, 64)}  # KiB


def _quality(results):
    rows = {preset: by_method.get("larics") for preset, by_method in results.items()}
    for preset, (must, aim) in _DETECTED.items():
        if rows.get(preset):
            yield Target("%s: detected, %%" % preset, rows[preset]["detected_pct"], must, aim, at_least=True)
    for preset, (must, aim) in _WRONG.items():
        if rows.get(preset):
            yield Target("%s: wrong IDs, %%" % preset, rows[preset]["wrong_pct"], must, aim)
    for preset, limits in _ERRORS.items():
        for key, (must, aim) in zip(_ERROR_KEYS, limits, strict=True):
            if rows.get(preset) and rows[preset][key] is not None:
                yield Target("%s: %s" % (preset, key.replace("_", " ")), rows[preset][key], must, aim)
    for preset in ("negative", "photographs"):
        if rows.get(preset):
            yield Target("%s: false positives" % preset, rows[preset]["false_positives"], 0, 0)


def _stresses(results):
    for key, (must, aim) in _STRESSES.items():
        if "larics" not in results.get(key, {}).get("methods", {}):
            continue
        cells = list(zip(results[key]["values"], results[key]["methods"]["larics"], strict=True))
        for value in (must, aim):
            row = next(row for cell, row in cells if cell == value)
            label = "%s %g: found (0: a wrong ID), %%" % (key, value)
            share = 0.0 if row["wrong"] else row["detected_pct"]
            yield Target(label, share, 95 if value == must else None, 95, at_least=True)


def _costs(results):
    costs = results.get("given", {})
    for job, limits in _COSTS.items():
        if costs.get(job, {}).get("unit") == "Minsn":
            for key, must, aim in limits:
                yield Target("%s: %s, Minsn" % (job, key), costs[job][key], must, aim)
    for job, (must, aim) in _MEMORY.items():
        memory = results.get("unix", {}).get(job, {}).get("memory")
        if memory is not None:
            yield Target("%s: memory, KiB" % job, memory / 1024, must, aim)


def _time(results):
    ratios = {name: ratio for name, (_, ratio) in results.items()}
    for name, least in (("aruco", 1.0), ("apriltag2", 2.0)):
        if "larics" in ratios and name in ratios:
            label = "times faster than %s" % name
            yield Target(label, ratios[name] / ratios["larics"], None, least, at_least=True)
    if "larics" in results:
        yield Target("ms a frame on the host", results["larics"][0], 1.0, 1.0)


def targets(results):
    """All targets that the results of a run can be held against."""
    return [
        *_quality(results.get("quality", {})),
        *_stresses(results.get("sweeps", {})),
        *_time(results.get("host_time", {})),
        *_costs(results.get("micropython", {})),
    ]
