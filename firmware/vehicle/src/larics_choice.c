#include "larics_choice.h"

#include <string.h>

static const larics_choice_rule usual = {LARICS_NEAREST, 20, 500, 3, 200, LARICS_ID_NONE, LARICS_ID_NONE};

void larics_choice_init(larics_choice *choice, const larics_choice_rule *rule)
{
    memset(choice, 0, sizeof *choice);
    choice->rule = rule ? *rule : usual;
    choice->rival_id = LARICS_ID_NONE;
}

void larics_choice_forget(larics_choice *choice)
{
    choice->has_target = choice->has_rival = choice->has_frame = choice->is_open = 0;
    choice->rival_frames = 0;
    choice->rival_id = LARICS_ID_NONE;
}

void larics_choice_follow(larics_choice *choice, uint16_t here_id, uint16_t next_id)
{
    choice->rule.mode = LARICS_BY_ROUTE;
    choice->rule.id = here_id;
    choice->rule.next_id = next_id;
}

static uint32_t magnitude(int32_t value)
{
    return (uint32_t)(value < 0 ? -value : value);
}

uint32_t larics_distance_mm10(const larics_marker *marker)
{
    uint32_t x = magnitude(marker->x_mm10), y = magnitude(marker->y_mm10);
    uint32_t square, root = 0, bit = (uint32_t)1 << 30;
    uint8_t shift = 0;
    while ((x | y) > 32767u) { /* so that the square fits into 32 bits */
        x >>= 1;
        y >>= 1;
        shift++;
    }
    square = x * x + y * y;
    while (bit > square) bit >>= 2;
    for (; bit; bit >>= 2) {
        if (square >= root + bit) {
            square -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return root << shift;
}

static int is_allowed(const larics_choice_rule *rule, uint16_t id)
{
    if (rule->mode == LARICS_NEAREST) return 1;
    return id == rule->id || (rule->mode == LARICS_BY_ROUTE && id == rule->next_id);
}

/* How far from where the target was in the frame before. */
static uint32_t moved(const larics_choice *choice, const larics_marker *marker)
{
    return magnitude(marker->x_mm10 - choice->before_x_mm10) +
           magnitude(marker->y_mm10 - choice->before_y_mm10);
}

static int is_better(const larics_choice *choice)
{
    const larics_choice_rule *rule = &choice->rule;
    uint32_t now = larics_distance_mm10(&choice->target), then = larics_distance_mm10(&choice->rival);
    if (rule->mode == LARICS_BY_ROUTE && rule->id != rule->next_id)
        return choice->rival.id == rule->next_id && choice->target.id != rule->next_id;
    return then + rule->nearer_mm10 <= now && then <= now / 100u * (100u - rule->nearer_percent);
}

static void aim(larics_choice *choice)
{
    if (!choice->has_target || choice->target.id != choice->rival.id) choice->changes++;
    choice->target = choice->rival;
    choice->target_ms = choice->seen_ms = choice->rival_ms;
    choice->has_target = choice->is_seen = 1;
    choice->has_rival = choice->rival_frames = 0;
    choice->rival_id = LARICS_ID_NONE;
}

/* All markers of a frame have come: is another one to be the target? */
static void end_frame(larics_choice *choice)
{
    if (!choice->is_open) return;
    choice->is_open = 0;
    if (!choice->has_rival) {
        choice->rival_frames = 0;
        choice->rival_id = LARICS_ID_NONE;
    } else if (!choice->has_target ||
               (!choice->is_seen && choice->rival_ms - choice->seen_ms >= choice->rule.keep_ms)) {
        aim(choice);
    } else if (!is_better(choice) || (!choice->is_seen && choice->rule.mode != LARICS_BY_ROUTE)) {
        choice->rival_frames = 0;
        choice->rival_id = LARICS_ID_NONE;
    } else {
        if (choice->rival_id != choice->rival.id) choice->rival_frames = 0;
        choice->rival_id = choice->rival.id;
        if (++choice->rival_frames >= choice->rule.frames) aim(choice);
    }
}

void larics_choice_take(larics_choice *choice, const larics_marker *marker, uint32_t now_ms)
{
    if (choice->has_target && !is_allowed(&choice->rule, choice->target.id)) larics_choice_forget(choice);
    if (!choice->has_frame || marker->frame != choice->frame) {
        end_frame(choice);
        choice->frame = marker->frame;
        choice->has_frame = choice->is_open = 1;
        choice->has_rival = choice->is_seen = 0;
        choice->before_x_mm10 = choice->target.x_mm10;
        choice->before_y_mm10 = choice->target.y_mm10;
    }
    if (choice->has_target && marker->id == choice->target.id) {
        /* the target itself; of two with its ID in one frame, the one nearer to where it was */
        if (!choice->is_seen || moved(choice, marker) < moved(choice, &choice->target)) {
            choice->target = *marker;
            choice->target_ms = choice->seen_ms = now_ms;
            choice->is_seen = 1;
        }
    } else if (is_allowed(&choice->rule, marker->id) &&
               (!choice->has_rival ||
                larics_distance_mm10(marker) < larics_distance_mm10(&choice->rival))) {
        choice->rival = *marker;
        choice->rival_ms = now_ms;
        choice->has_rival = 1;
    }
    if ((uint16_t)(marker->index + 1u) >= marker->count) end_frame(choice);
}
