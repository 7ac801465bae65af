"""In which order and by how many processes the tests are run, and that none is judged by its time."""

import os
from itertools import islice

import hypothesis
import pytest

hypothesis.settings.register_profile(
    "any time", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("any time")
_WORKERS_PER_CORE = 2  # many tests wait: for a line, another process, a vehicle's clock


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    return _WORKERS_PER_CORE * (os.cpu_count() or 1)


def dealt(items, seconds, workers):
    """The items in one list, of which each worker takes its part: each part begins with its share of the
    long ones, so that none of them begins when the others have ended. The rest keeps its order, as neighbours
    share what they set up. seconds: of an item, 0 where it is not long."""
    longest = sorted(filter(seconds, items), key=seconds, reverse=True)
    short = iter([item for item in items if not seconds(item)])
    order = []
    for k in range(workers):
        begin = len(order)
        order += longest[k::workers]
        size = (len(items) - begin) // (workers - k)  # as `--dist worksteal` cuts it
        order += islice(short, max(0, begin + size - len(order)))
    return order


def pytest_collection_modifyitems(items):
    def seconds(item):
        mark = item.get_closest_marker("long")
        return mark.args[0] if mark else 0

    items[:] = dealt(items, seconds, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))
