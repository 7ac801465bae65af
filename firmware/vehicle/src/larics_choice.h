/* LARICS camera: which of several markers in view to steer by, with hysteresis.
 *
 * The supervisor (larics_supervisor.h) holds one and feeds it with what may be used; it works alone as well:
 *
 *     larics_choice choice;
 *     larics_choice_init(&choice, NULL);           nearest marker, usual hysteresis
 *     for each MARKER message that may be used:
 *         larics_choice_take(&choice, &message.as.marker, now_ms);
 *     if (choice.has_target) ... choice.target ...
 */
#ifndef LARICS_CHOICE_H
#define LARICS_CHOICE_H

#include "larics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* larics_choice_rule.mode */
#define LARICS_NEAREST 0 /* the marker that the vehicle is nearest to */
#define LARICS_BY_ID 1   /* `id` and no other */
#define LARICS_BY_ROUTE 2 /* `next_id` as soon as it is in view, `id` until then, and no other */

typedef struct {
    uint8_t mode;
    uint8_t nearer_percent; /* another marker must be nearer by this share of the target's distance ... */
    uint16_t nearer_mm10;   /* ... and by this, 0.1 mm ... */
    uint8_t frames;         /* ... in so many frames one after the other, before it becomes the target */
    uint16_t keep_ms;       /* a target that is out of view stays the target for this long */
    uint16_t id;            /* for LARICS_BY_ID and LARICS_BY_ROUTE */
    uint16_t next_id;       /* for LARICS_BY_ROUTE */
} larics_choice_rule;

typedef struct {
    larics_choice_rule rule;
    larics_marker target; /* valid when has_target */
    uint8_t has_target;
    uint32_t target_ms; /* when it arrived, on the caller's clock */
    uint32_t changes;   /* of the target's ID */
    larics_marker rival; /* private from here on */
    uint32_t rival_ms;
    int32_t before_x_mm10;
    int32_t before_y_mm10;
    uint32_t frame;
    uint32_t seen_ms;
    uint16_t rival_id;
    uint8_t rival_frames;
    uint8_t has_rival;
    uint8_t has_frame;
    uint8_t is_seen;
    uint8_t is_open;
} larics_choice;

/* `rule` NULL: the nearest marker; another one must be nearer by a fifth and by 50 mm in three frames. */
void larics_choice_init(larics_choice *choice, const larics_choice_rule *rule);

/* Forgets the target; the rule stays. */
void larics_choice_forget(larics_choice *choice);

/* Takes a usable marker that arrived at now_ms. The markers of a frame come one after the other. */
void larics_choice_take(larics_choice *choice, const larics_marker *marker, uint32_t now_ms);

/* Chooses by route: go to `next_id` as soon as it is in view, steer by `here_id` until then. */
void larics_choice_follow(larics_choice *choice, uint16_t here_id, uint16_t next_id);

/* Horizontal distance from the vehicle to the marker, 0.1 mm, 5 mm or better. */
uint32_t larics_distance_mm10(const larics_marker *marker);

#ifdef __cplusplus
}
#endif

#endif
