"""Locating on a route against a brute-force oracle that tries every story."""

from functools import cache

from hypothesis import given, settings
from hypothesis import strategies as st

from larics.locate import route as r
from larics.locate.route import Route


def stories(ids, closed, start, seen):
    """Least cost of every story that ends at each position, from the costs in locate.route's docstring:
    {position: cost}. Recursive and without normalisation: slow, but plainly the definition."""
    count = len(ids) - 1 if closed else len(ids)

    @cache
    def least(event, position):
        if event < 0:
            return 0 if start in (-1, position) else 7
        fits = ids[position] == seen[event]
        ways = [least(event - 1, position) + (0 if fits else 5)]
        for missed in range(3):
            origin = position - 1 - missed
            if closed and missed + 1 >= count:
                break
            if origin < 0 and not closed:
                break
            ways.append(least(event - 1, origin % count) + 2 * missed + (0 if fits else 6))
        if fits:
            ways.append(7 + min(least(event - 1, other) for other in range(count)))
        return min(ways)

    return {position: least(len(seen) - 1, position) for position in range(count)}


@st.composite
def routes(draw):
    ids = [draw(st.integers(1, 5))]
    for _ in range(draw(st.integers(1, 9))):
        ids.append(draw(st.integers(1, 5).filter(lambda k: k != ids[-1])))
    if draw(st.booleans()) and len(ids) > 2 and ids[-1] != ids[0]:
        ids.append(ids[0])
    return ids


@settings(max_examples=400)
@given(ids=routes(), seen=st.lists(st.integers(1, 6), min_size=1, max_size=9), data=st.data())
def test_position_is_that_of_the_cheapest_story(ids, seen, data):
    start = data.draw(st.integers(-1, len(ids) - 1))
    closed = len(ids) > 2 and ids[0] == ids[-1]
    route = Route(ids, None, start)
    begin = start % route.count if start >= 0 else -1
    events = []
    for marker_id in seen:
        meaning = route.see(marker_id)
        if events and events[-1] == marker_id:
            assert meaning == r.SAME
            continue
        events.append(marker_id)
        cost = stories(tuple(ids), closed, begin, tuple(events))
        least = min(cost.values())
        best = [position for position in cost if cost[position] == least]
        assert route.position == (best[0] if len(best) == 1 else -1)
        assert (meaning == r.AMBIGUOUS) == (len(best) > 1)
        if len(best) == 1:
            fits = ids[best[0]] == marker_id
            assert fits or meaning in (r.UNEXPECTED, r.MISREAD)
        assert "\n" not in route.describe(meaning, marker_id)


@settings(max_examples=200)
@given(ids=routes(), laps=st.integers(1, 3), drop=st.integers(0, 30), wrong=st.integers(0, 30))
def test_a_clean_drive_is_followed_and_one_disturbance_forgotten(ids, laps, drop, wrong):
    """From a known start a drive without errors is always ON_ROUTE; after a missing marker or a foreign one
    (ID 6) the position is right again with the next marker that fits."""
    closed = len(ids) > 2 and ids[0] == ids[-1]
    once = ids[:-1] if closed else ids
    way = [(k % len(once), once[k % len(once)]) for k in range(len(once) * (laps if closed else 1))]
    route = Route(ids, None, 0)
    for position, marker_id in way:
        assert route.see(marker_id) == r.ON_ROUTE and route.position == position
    route = Route(ids, None, 0)
    for k, (position, marker_id) in enumerate(way):
        route.see(marker_id)
        assert route.position == position
        if k == wrong and k + 1 < len(way):
            assert route.see(6) == r.UNEXPECTED and route.position == position
