#include "larics_route.h"

/* A story is made of steps: the next marker of the route, or the same one again, costs nothing. */
#define MISSED_COST 2 /* a marker of the route was not seen, at most two in a row */
#define EXTRA_COST 5  /* a marker was seen that does not belong here */
#define MISREAD_COST 6 /* the next marker was reached, but read as another one */
#define MOVED_COST 7  /* the vehicle was put elsewhere on the route */
#define MOST_MISSED 2
#define MOST 60000u

int larics_route_init(larics_route *route, const uint16_t *ids, uint16_t id_count, int16_t start,
                      uint16_t *workspace)
{
    if (id_count < 2 || id_count > 1000 || start < -1 || start >= (int32_t)id_count) return 0;
    for (uint16_t k = 1; k < id_count; k++)
        if (ids[k] == ids[k - 1]) return 0;
    route->ids = ids;
    route->is_closed = id_count > 2 && ids[0] == ids[id_count - 1];
    route->count = (uint16_t)(id_count - route->is_closed);
    route->start = start == (int32_t)route->count ? 0 : start;
    route->cost = workspace;
    route->after = workspace + id_count;
    larics_route_restart(route);
    return 1;
}

void larics_route_restart(larics_route *route)
{
    route->position = route->start;
    route->missed = 0;
    route->last_id = -1;
    for (uint16_t k = 0; k < route->count; k++)
        route->cost[k] = route->start == -1 || route->start == (int32_t)k ? 0 : MOVED_COST;
}

void larics_route_lose_sight(larics_route *route)
{
    route->last_id = -1;
}

int16_t larics_route_next(const larics_route *route)
{
    if (route->position < 0) return -1;
    if (route->position + 1 < (int32_t)route->count) return (int16_t)(route->position + 1);
    return route->is_closed ? 0 : -1;
}

/* The cost of every position after this marker; returns the cheapest, -1 when there are several. */
static int16_t advance(larics_route *route, uint16_t id)
{
    const uint16_t *cost = route->cost;
    uint16_t *after = route->after;
    uint16_t least = MOST;
    int16_t best = -1;
    int32_t count = route->count;
    for (int32_t k = 0; k < count; k++) {
        int fits = route->ids[k] == id;
        uint32_t cheapest = fits ? cost[k] : (uint32_t)cost[k] + EXTRA_COST;
        if (fits && MOVED_COST < cheapest) cheapest = MOVED_COST; /* the least cost is always 0 */
        for (int32_t back = 1; back < MOST_MISSED + 2; back++) {
            int32_t origin = k - back;
            uint32_t way;
            if (origin < 0) {
                if (!route->is_closed || back >= count) break;
                origin += count;
            }
            way = (uint32_t)cost[origin] + (uint32_t)(back - 1) * MISSED_COST + (fits ? 0u : MISREAD_COST);
            if (way < cheapest) cheapest = way;
        }
        if (cheapest > MOST) cheapest = MOST;
        after[k] = (uint16_t)cheapest;
        if (cheapest < least) {
            least = (uint16_t)cheapest;
            best = (int16_t)k;
        } else if (cheapest == least) {
            best = -1;
        }
    }
    for (int32_t k = 0; k < count; k++) after[k] = (uint16_t)(after[k] - least);
    route->after = route->cost;
    route->cost = after;
    return best;
}

static uint8_t meaning(larics_route *route, int32_t before, int32_t now, uint16_t id)
{
    int fits = route->ids[now] == id;
    int32_t steps = now - before;
    if (before < 0) return fits ? LARICS_ROUTE_ON : LARICS_ROUTE_UNEXPECTED;
    if (steps < 0 && route->is_closed) steps += route->count;
    if (steps == 0) return fits ? LARICS_ROUTE_ON : LARICS_ROUTE_UNEXPECTED;
    if (!fits) return LARICS_ROUTE_MISREAD;
    if (steps == 1) return LARICS_ROUTE_ON;
    if (steps < 1 || steps > MOST_MISSED + 1) return LARICS_ROUTE_MOVED;
    route->missed = (uint8_t)(steps - 1);
    return LARICS_ROUTE_MISSED;
}

uint8_t larics_route_see(larics_route *route, uint16_t id)
{
    int16_t before = route->position;
    if ((int32_t)id == route->last_id) return LARICS_ROUTE_SAME;
    route->last_id = id;
    route->position = advance(route, id);
    if (route->position < 0) return LARICS_ROUTE_AMBIGUOUS;
    return meaning(route, before, route->position, id);
}

uint8_t larics_route_pass_by(larics_route *route)
{
    int16_t following = larics_route_next(route);
    if (following < 0) return LARICS_ROUTE_SAME;
    advance(route, route->ids[following]);
    route->position = following;
    route->missed = 1;
    route->last_id = -1;
    return LARICS_ROUTE_MISSED;
}
