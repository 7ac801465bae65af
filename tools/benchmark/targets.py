"""What our method is to reach, and whether a run's results do."""

from statistics import median
from typing import NamedTuple

from . import evaluate, plan


class Target(NamedTuple):
    """Limits on one number of the results: the value is to be at least, or else at most, `must` and `aim`."""

    label: str
    value: float
    must: float | None  # None: only an aim
    aim: float | None  # None: only a must
    at_least: bool = False
    frames: int | None = None  # that the value rests on
    wrong: int | None = None  # wrong reports among them, when a single one misses the target

    def verdict(self):
        """In words, what is reached."""
        if self.aim is not None and self._keeps(self.aim):
            return "aim reached"
        if self.must is None:
            return "aim missed"
        return "reached" if self._keeps(self.must) else "MISSED"

    def _keeps(self, limit):
        return not self.wrong and (self.value >= limit if self.at_least else self.value <= limit)


_DETECTED = {"sunny": (99.8, 100), "double": (99.8, 100), "fast": (99.8, 100), "cloudy": (99.5, 99.9)}
_DETECTED["harsh"] = (90, 97)
_TROUBLED = ("glossy", "webcam", "dirty_lens", "worn")
_READ = {"harsh": (88, 95), **{preset: (80, 95) for preset in _TROUBLED}}
_WRONG = {"sunny": (0, 0), "double": (0, 0), "fast": (0, 0), "cloudy": (0.1, 0), "harsh": (0.2, 0.05)}
_WRONG.update({preset: (0.2, 0) for preset in _TROUBLED})
_ERRORS = {
    "sunny": ((0.02, 0.005), (0.05, 0.012), (0.02, 0.008), (0.08, 0.025)),
    "cloudy": ((0.05, 0.02), (0.12, 0.05), (0.06, 0.04), (0.2, 0.12)),
}
_ERROR_KEYS = ("centre_median_px", "centre_p95_px", "heading_median_deg", "heading_p95_deg")
_CODED_READ = {preset: (99.8, 99.95) for preset in ("sunny", "cloudy", "double", "fast")}
_CODED_READ["harsh"] = (88, 95)
_CODED_STRESSED = {
    ("occlusion", 0.05): (85, 95), ("occlusion", 0.1): (80, 90), ("occlusion", 0.2): (70, 80),
    ("radius", 10): (97, 99), ("radius", 12): (99.5, 100),
}  # fmt: skip
_STRESSED_PCT = 95  # still to be found, and nothing wrong, at the values `must` and `aim` of plan.SWEEPS
_COSTS = {  # million instructions of a frame
    "search": (("mean", 2.0, 1.1), ("max", 3.5, 2.0)),
    "track": (("mean", 0.8, 0.45),),
    "search, radius 10 to 66 px": (("mean", 7, 4),),
}
_SECOND_OPINION = 8.0  # million instructions that it may add to a frame
_MEMORY = {"search": (96, 64), "search, radius 10 to 66 px": (128, 64)}  # KiB


def _quality(results):
    rows = {preset: by_method["larics"] for preset, by_method in results.items() if "larics" in by_method}

    def target(label, preset, key, *limits, **more):
        return Target(
            "%s: %s" % (preset, label), rows[preset][key], *limits, **more, frames=rows[preset]["frames"]
        )

    for preset, limits in _DETECTED.items():
        if preset in rows:
            yield target("detected, %", preset, "detected_pct", *limits, at_least=True)
    for preset, limits in _READ.items():
        if preset in rows:
            yield target("read, %", preset, "read_pct", *limits, at_least=True)
    for preset, limits in _WRONG.items():
        if preset in rows:
            yield target("wrong IDs, %", preset, "wrong_pct", *limits)
    for preset, limits_of in _ERRORS.items():
        for key, limits in zip(_ERROR_KEYS, limits_of, strict=True):
            if preset in rows and rows[preset][key] is not None:
                yield target(key.replace("_", " "), preset, key, *limits)
    for preset in evaluate.NEGATIVES:
        if preset in rows:
            yield target("false positives", preset, "false_positives", 0, 0)


def _coded(results):
    """Of coded markers: read, and no wrong ID at all."""
    rows = {
        preset: by["larics_coded"]
        for preset, by in results.get("quality", {}).items()
        if "larics_coded" in by
    }
    for preset, limits in _CODED_READ.items():
        if preset in rows:
            row = rows[preset]
            yield Target(
                "%s, coded: read, %%" % preset, row["read_pct"], *limits, at_least=True, frames=row["frames"],
                wrong=row["wrong"],
            )  # fmt: skip
    for (key, value), limits in _CODED_STRESSED.items():
        swept = results.get("sweeps", {}).get(key, {})
        methods = swept.get("methods", {})
        if "larics_coded" in methods and value in swept["values"]:
            row = methods["larics_coded"][list(swept["values"]).index(value)]
            yield Target(
                "%s %g, coded: read, %%" % (key, value), row["read_pct"], *limits, at_least=True,
                frames=row["frames"], wrong=row["wrong"],
            )  # fmt: skip


def stresses(results):
    """What is to be found under each stress, of the results' part "sweeps"."""
    for key, sweep in plan.SWEEPS.items():
        rows = results.get(key, {}).get("methods", {}).get("larics")
        if rows is None or sweep.must is None:
            continue
        cells = dict(zip(results[key]["values"], rows, strict=True))
        limits = ((sweep.must, _STRESSED_PCT, None), (sweep.aim, None, _STRESSED_PCT))
        for value, must, aim in limits:
            row = cells[value]
            yield Target(
                "%s %g: found, %%" % (key, value), row["detected_pct"], must, aim,
                at_least=True, frames=row["frames"], wrong=row["wrong"] + row["false_positives"],
            )  # fmt: skip


def _costs(results):
    costs = results.get("given", {})
    for job, limits in _COSTS.items():
        if costs.get(job, {}).get("unit") == "Minsn":
            for key, must, aim in limits:
                yield Target(
                    "%s: %s, Minsn" % (job, key), costs[job][key], must, aim, frames=costs[job]["frames"]
                )
    for job, added in second_opinion(costs).items():
        if added["unit"] == "Minsn" and added["asked"]:
            label = "blur-model reader, %s: most, Minsn" % job.removeprefix("search, ")
            yield Target(label, added["max"], _SECOND_OPINION, None, frames=added["asked"])
    for job, (must, aim) in _MEMORY.items():
        memory = results.get("unix", {}).get(job, {}).get("memory")
        if memory is not None:
            yield Target("%s: memory, KiB" % job, memory / 1024, must, aim)


def second_opinion(costs):
    """What it adds to the frames in which it was asked, by job that was measured with and without.

    {job: unit, frames, asked (of these), median and max of the difference, found and memory as (off, on)}."""
    added = {}
    for job, on in costs.items():
        off = costs.get(job + plan.WITHOUT)
        if off is None:
            continue
        more = [b - a for a, b, asked in zip(off["each"], on["each"], on["asked"], strict=True) if asked]
        added[job] = {
            "unit": on["unit"],
            "frames": on["frames"],
            "asked": len(more),
            "median": median(more) if more else None,
            "max": max(more, default=None),
            "found": (off["found"], on["found"]),
            "memory": (off["memory"], on["memory"]),
        }
    return added


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
        *_coded(results),
        *stresses(results.get("sweeps", {})),
        *_time(results.get("host_time", {})),
        *_costs(results.get("micropython", {})),
    ]
