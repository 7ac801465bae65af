/* What c_controller.py calls of the vehicle's C library: a whole controller behind plain numbers. */
#include <stdlib.h>

#include "larics_drive.h"
#include "larics_route.h"
#include "larics_supervisor.h"
#include "larics_wheels.h"

typedef struct {
    larics_decoder decoder;
    larics_supervisor camera;
    larics_drive drive;
    larics_route route;
    larics_wheels wheels;
    uint16_t sequence;
    uint16_t ids[1000];
    uint16_t workspace[2000];
    uint8_t is_supervised;
} controller;

controller *controller_new(const int32_t drive[8], int is_supervised)
{
    larics_drive_limits limits = {drive[0], drive[1], drive[2], drive[3], drive[4], drive[5], drive[6], drive[7]};
    controller *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    larics_decoder_init(&c->decoder);
    c->is_supervised = (uint8_t)is_supervised;
    if (larics_drive_init(&c->drive, &limits)) return c;
    free(c);
    return NULL;
}

void controller_free(controller *c)
{
    free(c);
}

/* supervise: baud, buffer_bytes, silent_ms, stalled_ms, challenge_ms, answer_ms, now_ms, seed, most_sigma_mm10,
 * most_sigma_cdeg, most_carried_ms, most_way_mm */
void controller_supervise(controller *c, const uint32_t supervise[12])
{
    larics_limits limits;
    larics_limits_usual(&limits, supervise[0]);
    limits.buffer_bytes = (uint16_t)supervise[1];
    limits.silent_ms = (uint16_t)supervise[2];
    limits.stalled_ms = (uint16_t)supervise[3];
    limits.challenge_ms = (uint16_t)supervise[4];
    limits.answer_ms = (uint16_t)supervise[5];
    limits.most_sigma_mm10 = (uint16_t)supervise[8];
    limits.most_sigma_cdeg = (uint16_t)supervise[9];
    limits.most_carried_ms = (uint16_t)supervise[10];
    limits.most_way_mm = (uint16_t)supervise[11];
    larics_supervisor_init(&c->camera, &limits, supervise[6], supervise[7]);
    larics_wheels_init(&c->wheels, supervise[7]);
}

int controller_roll(controller *c, int32_t left_um, int32_t right_um, uint16_t track_mm, uint32_t now_us)
{
    return larics_wheels_roll(&c->wheels, left_um, right_um, track_mm, now_us);
}

size_t controller_odometry(controller *c, uint32_t now_us, uint8_t frame[LARICS_MAX_FRAME])
{
    return larics_wheels_message(&c->wheels, now_us, &c->sequence, frame);
}

static int may_drive_by(controller *c, uint32_t now_ms)
{
    if (!c->is_supervised) return 1;
    return larics_supervise(&c->camera, &c->decoder.message) &&
           larics_may_drive_by(&c->camera, &c->decoder.message, now_ms);
}

void controller_receive(controller *c, const uint8_t *bytes, size_t count, uint32_t now_ms)
{
    larics_begin_drain(&c->camera, now_ms);
    while (count--)
        if (larics_decode(&c->decoder, *bytes++) && may_drive_by(c, now_ms))
            larics_drive_take(&c->drive, &c->decoder.message);
}

size_t controller_ask(controller *c, uint32_t now_ms, uint8_t frame[LARICS_MAX_FRAME])
{
    return larics_challenge(&c->camera, now_ms, &c->sequence, frame);
}

/* told: state, speed_mm_s, turn_cdeg_s, left_id, is_end, state of the marker, messages accepted */
void controller_step(controller *c, uint32_t now_ms, uint32_t elapsed_ms, int32_t told[7])
{
    if (c->is_supervised) c->drive.is_held = !larics_may_search(&c->camera, now_ms);
    told[0] = larics_drive_step(&c->drive, elapsed_ms);
    told[1] = c->drive.speed_mm_s;
    told[2] = c->drive.turn_cdeg_s;
    told[3] = c->drive.left_id;
    told[4] = c->drive.is_end;
    told[5] = larics_marker_state(&c->camera, now_ms);
    told[6] = (int32_t)c->camera.noticed.accepted;
}

void controller_stop(controller *c)
{
    larics_drive_stop(&c->drive);
}

void controller_start(controller *c)
{
    larics_drive_start(&c->drive);
}

void controller_hold(controller *c, int is_held)
{
    c->drive.is_held = (uint8_t)is_held;
}

int controller_route(controller *c, const uint16_t *ids, uint16_t count, int16_t start)
{
    for (uint16_t k = 0; k < count && k < 1000; k++) c->ids[k] = ids[k];
    return larics_route_init(&c->route, c->ids, count, start, c->workspace);
}

/* told: what it means, position, next position, missed */
void controller_see(controller *c, int32_t id, int32_t told[4])
{
    told[0] = -1;
    if (id == -2)
        told[0] = larics_route_pass_by(&c->route);
    else if (id < 0)
        larics_route_lose_sight(&c->route);
    else
        told[0] = larics_route_see(&c->route, (uint16_t)id);
    told[1] = c->route.position;
    told[2] = larics_route_next(&c->route);
    told[3] = c->route.missed;
}
