/* LARICS camera: which of the markers of a map a route means, where an ID hangs at several places of a building.
 * C99, no allocation.
 *
 *     static const larics_map_marker map[] = {{3, 0, 0}, {4, 2000, 0}, {3, 9000, 0}};
 *     static const uint16_t ids[] = {3, 4, 3};
 *     static uint16_t entries[3];
 *     static uint32_t workspace[3];
 *     if (larics_map_resolve(map, 3, ids, 3, entries, workspace)) ... map[entries[position]] ...
 *
 * The shortest way decides, as in resolve_entries of shared/larics/locate/route.py.
 */
#ifndef LARICS_MAP_H
#define LARICS_MAP_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint16_t id;
    int32_t x_mm; /* -1000000..1000000, as in the setting `map` */
    int32_t y_mm;
} larics_map_marker;

/* Puts the index in the map of each marker of the route into `entries`, which has room for id_count numbers;
 * `workspace` has room for map_count. Runs once, at start. 0 when that cannot be a route (see larics_route_init), or
 * when a marker of it is not in the map. */
int larics_map_resolve(const larics_map_marker *map, uint16_t map_count, const uint16_t *ids, uint16_t id_count,
                       uint16_t *entries, uint32_t *workspace);

#ifdef __cplusplus
}
#endif

#endif
