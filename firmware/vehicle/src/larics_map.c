#include "larics_map.h"

#include "larics_arith.h"

#define NO_WAY 0xFFFFFFFFu

typedef struct {
    const larics_map_marker *map;
    uint16_t map_count;
    const uint16_t *ids;
    uint16_t last; /* step of the route */
    uint8_t is_closed;
    uint32_t *cost; /* by entry: markers of two steps that follow each other have different IDs */
} search;

/* Near enough to the distance to compare. */
static uint32_t way(const larics_map_marker *a, const larics_map_marker *b)
{
    uint32_t dx = (uint32_t)larics_abs(a->x_mm - b->x_mm), dy = (uint32_t)larics_abs(a->y_mm - b->y_mm);
    return dx > dy ? dx + dy / 2u : dy + dx / 2u;
}

static uint16_t places(const search *s, uint16_t step)
{
    uint16_t found = 0;
    for (uint16_t k = 0; k < s->map_count; k++) found = (uint16_t)(found + (s->map[k].id == s->ids[step]));
    return found;
}

/* The entry of step `to` with the cheapest way from `entry` on, the first of equal ones; the cost into *least. */
static uint16_t cheapest(const search *s, uint16_t entry, uint16_t to, uint32_t *least)
{
    uint16_t best = 0;
    *least = NO_WAY;
    for (uint16_t k = 0; k < s->map_count; k++) {
        uint32_t cost;
        if (s->map[k].id != s->ids[to] || s->cost[k] == NO_WAY) continue;
        cost = s->cost[k] + way(&s->map[entry], &s->map[k]);
        if (cost < *least) {
            *least = cost;
            best = k;
        }
    }
    return best;
}

/* The costs from each entry of step `from` to step `until`, of a route that begins at entry `first`. */
static void add_up(const search *s, uint16_t from, uint16_t until, uint16_t first)
{
    int is_bound = until == s->last && s->is_closed;
    for (uint16_t k = 0; k < s->map_count; k++)
        if (s->map[k].id == s->ids[until]) s->cost[k] = is_bound && k != first ? NO_WAY : 0;
    while (until-- > from)
        for (uint16_t k = 0; k < s->map_count; k++)
            if (s->map[k].id == s->ids[until]) cheapest(s, k, (uint16_t)(until + 1u), &s->cost[k]);
}

int larics_map_resolve(const larics_map_marker *map, uint16_t map_count, const uint16_t *ids, uint16_t id_count,
                       uint16_t *entries, uint32_t *workspace)
{
    search s = {map, map_count, ids, (uint16_t)(id_count - 1u), 0, workspace};
    uint32_t least = NO_WAY, cost;
    if (id_count < 2 || id_count > 1000) return 0;
    for (uint16_t step = 0; step < id_count; step++)
        if (!places(&s, step) || (step && ids[step] == ids[step - 1])) return 0;
    s.is_closed = id_count > 2 && ids[0] == ids[s.last];
    entries[0] = 0;
    for (uint16_t k = 0; k < map_count; k++) {
        if (map[k].id != ids[0]) continue;
        add_up(&s, 1, s.last, k);
        cheapest(&s, k, 1, &cost);
        if (cost >= least) continue;
        least = cost;
        entries[0] = k;
    }
    for (uint16_t step = 1; step < id_count; step++) {
        uint16_t until = step; /* what lies beyond a marker that hangs at one place only costs the same for all */
        while (until < s.last && places(&s, until) > 1) until++;
        add_up(&s, step, until, entries[0]);
        entries[step] = cheapest(&s, entries[step - 1], step, &cost);
    }
    return 1;
}
