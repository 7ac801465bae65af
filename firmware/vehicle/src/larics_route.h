/* LARICS camera: where on its route the vehicle is, from the IDs passed so far. C99, no allocation.
 *
 * A route is a list of IDs in the order of driving, such as 1-2-3-4-3-2-1; one that ends where it began is driven
 * again and again. An ID may occur several times, so one marker alone may not tell the position: every position is
 * kept with the cost of the cheapest story that leads there, and the vehicle is located when one story is cheaper
 * than all others. One wrong marker is reported and does not move the vehicle on its route; a second one that fits
 * elsewhere does. It does step by step what shared/larics/locate/route.py does.
 *
 *     static const uint16_t ids[] = {3, 4, 7, 3};
 *     static uint16_t workspace[2 * 4];
 *     larics_route route;
 *     larics_route_init(&route, ids, 4, -1, workspace);
 *     while a marker is reached:  larics_route_see(&route, id);
 */
#ifndef LARICS_ROUTE_H
#define LARICS_ROUTE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What larics_route_see found out. */
#define LARICS_ROUTE_SAME 0       /* still the same marker: nothing happened */
#define LARICS_ROUTE_ON 1         /* the marker that the route expected */
#define LARICS_ROUTE_AMBIGUOUS 2  /* several positions explain the markers passed equally well */
#define LARICS_ROUTE_MISSED 3     /* one or two markers of the route were not seen: `missed` */
#define LARICS_ROUTE_UNEXPECTED 4 /* a marker that does not belong here; the position is kept */
#define LARICS_ROUTE_MISREAD 5    /* the expected marker was reached, but another ID was read */
#define LARICS_ROUTE_MOVED 6      /* elsewhere on the route than one could have driven: position found again */

typedef struct {
    const uint16_t *ids;
    uint8_t is_closed;
    uint16_t count;    /* of positions: one less than IDs when the route is closed */
    int16_t position;  /* index in the route of the marker reached last, -1 while unknown */
    uint8_t missed;    /* how many markers the last LARICS_ROUTE_MISSED passed over */
    int16_t start;     /* private from here on */
    int32_t last_id;
    uint16_t *cost;
    uint16_t *after;
} larics_route;

/* `ids` of 2 to 1000 markers and `workspace` of twice as many numbers must stay; `start`: index of the first marker
 * to be met, -1 when the vehicle may be anywhere. 0 when that cannot be a route: too short, a marker after itself,
 * a start outside. */
int larics_route_init(larics_route *route, const uint16_t *ids, uint16_t id_count, int16_t start,
                      uint16_t *workspace);

/* Forgets the markers passed. */
void larics_route_restart(larics_route *route);

/* Takes the ID of the marker that the vehicle is at; call it as often as it is seen. LARICS_ROUTE_... */
uint8_t larics_route_see(larics_route *route, uint16_t id);

/* The last marker went out of view: its ID, when read again, is a new marker passed. */
void larics_route_lose_sight(larics_route *route);

/* The vehicle was at the place of the next marker and did not see it, by its odometry: it counts as passed. Returns
 * LARICS_ROUTE_MISSED, or LARICS_ROUTE_SAME when there is no next one. */
uint8_t larics_route_pass_by(larics_route *route);

/* Index in the route of the marker to drive to; -1 at the end, or while the position is unknown. */
int16_t larics_route_next(const larics_route *route);

#ifdef __cplusplus
}
#endif

#endif
