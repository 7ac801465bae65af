/* Who speaks on the line: identity, boot, order and challenge, private to the library. Of the supervisor it reads
 * the limits and writes what concerns the source. */
#ifndef LARICS_SOURCE_H
#define LARICS_SOURCE_H

#include "larics_supervisor.h"

#define LARICS_OLDEST_MS 60000u /* what is older is forgotten, before the clock comes round */
#define LARICS_BIT(code) ((uint32_t)1 << (code))

/* Milliseconds from `then` to `now`; what lies in the near future counts as now. */
uint32_t larics_since_ms(uint32_t then_ms, uint32_t now_ms);

/* What was measured so far is no longer true. */
void larics_source_void(larics_supervisor *camera);

/* Each takes a message; 1 when it is to be believed. */
int larics_source_info(larics_supervisor *camera, const larics_info *info, uint16_t sequence);
int larics_source_status(larics_supervisor *camera, const larics_status *status, uint16_t sequence);
int larics_source_ack(larics_supervisor *camera, const larics_ack *ack, uint16_t sequence);
int larics_source_measurement(larics_supervisor *camera, uint16_t sequence);
int larics_source_is_in_order(larics_supervisor *camera, uint16_t sequence);

/* Whether the one who speaks is the camera, as far as the limits want that proven. */
int larics_source_is_proven(const larics_supervisor *camera, uint32_t now_ms);

#endif
