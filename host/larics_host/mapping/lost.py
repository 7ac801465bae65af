"""When the drives of a settled graph do not make one map."""

from __future__ import annotations

import math
from collections import Counter

from larics_host.errors import UserError
from larics_host.mapping.graph import Graph
from larics_host.mapping.layout import Part

_EXPLAINED = 0.8  # of the passages, in a map that did not lose its association
_JUDGED = 10  # passages from which on that is asked
_CARRIED_MM, _CARRIED_RAD = 700.0, 0.35  # more than slips between two markers


def refuse_lost(graph: Graph, passages: list[tuple[int, int, Part]]) -> Counter[int]:
    """Counter of the IDs of passages (number, ID read, Part) that were misread or set aside. UserError where
    they are too many for one map, or where the vehicle went as no wheels do."""
    for one in graph.legs:
        ahead, left, turned = graph.leg_error(one)
        if math.hypot(ahead, left) > _CARRIED_MM or abs(turned) > _CARRIED_RAD:
            raise UserError(
                "the drives do not make one map: between two markers the vehicle went %.1f m and turned %.0f "
                "degrees of which its odometry knows nothing; was it carried? Drive anew, or begin a new log "
                "after that" % (math.hypot(ahead, left) / 1000, math.degrees(abs(turned)))
            )
    read = {one.passage for one in graph.readings if one.used and not one.is_misread}
    aside: Counter[int] = Counter(marker_id for number, marker_id, _ in passages if number not in read)
    if len(passages) >= _JUDGED and aside.total() > (1 - _EXPLAINED) * len(passages):
        raise UserError(
            "the drives do not make one map: %d of %d passages contradict the others; was the vehicle "
            "carried or did it slip, do IDs stand at several places (--repeats)? Drive small loops that pass "
            "each marker several times" % (aside.total(), len(passages))
        )
    return aside
