#include "larics_supervisor.h"

#include <string.h>

#include "larics_source.h"

#define NEAR_FUTURE_MS 60000u
#define UNUSABLE_FLAGS (LARICS_MARKER_ID_UNCERTAIN | LARICS_MARKER_UNCONFIRMED | LARICS_MARKER_NO_OFFSET)
#define HALF_OF_COUNT ((LARICS_COUNT_MAX + 1) / 2)

void larics_limits_usual(larics_limits *limits, uint32_t baud)
{
    larics_choice usual;
    memset(limits, 0, sizeof *limits);
    limits->baud = baud ? baud : 115200u;
    limits->buffer_bytes = 64;
    limits->max_age_ms = 100;
    limits->silent_ms = 1500;
    limits->stalled_ms = 500;
    limits->frozen_frames = 50;
    limits->most_gap = 600;
    limits->most_loss_percent = 25;
    limits->faults = LARICS_BIT(LARICS_FAULT_CAMERA_TIMEOUT) | LARICS_BIT(LARICS_FAULT_SETTINGS_CORRUPT) |
                     LARICS_BIT(LARICS_FAULT_DETECT) | LARICS_BIT(LARICS_FAULT_MEMORY) |
                     LARICS_BIT(LARICS_FAULT_SAFE_MODE) | LARICS_BIT(LARICS_FAULT_CAMERA) |
                     LARICS_BIT(LARICS_FAULT_LOOP) | LARICS_BIT(LARICS_FAULT_CAMERA_FROZEN) |
                     LARICS_BIT(LARICS_FAULT_CAMERA_DARK) | LARICS_BIT(LARICS_FAULT_CAMERA_WHITE);
    limits->most_sigma_mm10 = 1000;
    limits->most_sigma_cdeg = 500;
    limits->most_carried_ms = 30000;
    limits->most_way_mm = 10000;
    limits->answer_ms = 150;
    larics_choice_init(&usual, NULL);
    limits->choice = usual.rule;
    limits->status_ms = 5000;
}

/* Milliseconds of a whole message on the line, rounded up. */
static uint16_t line_ms(uint8_t type, uint32_t baud)
{
    return (uint16_t)((uint32_t)larics_frame_size(type) * 10000u / baud + 1u);
}

void larics_supervisor_init(larics_supervisor *camera, const larics_limits *limits, uint32_t now_ms,
                            uint32_t seed)
{
    memset(camera, 0, sizeof *camera);
    camera->limits = *limits;
    if (camera->limits.baud < 300u) camera->limits.baud = 115200u;
    larics_choice_init(&camera->choice, &limits->choice);
    camera->drained_ms = camera->arrived_ms = now_ms;
    camera->random = seed ? seed : 2463534242u;
    camera->marker_line_ms = line_ms(LARICS_MARKER, camera->limits.baud);
    camera->pose_line_ms = line_ms(LARICS_POSE, camera->limits.baud);
    camera->most_drain_ms = (uint16_t)((uint32_t)limits->buffer_bytes * 10000u / camera->limits.baud);
}

uint32_t larics_since_ms(uint32_t then_ms, uint32_t now_ms)
{
    uint32_t elapsed = now_ms - then_ms;
    return elapsed > 0xFFFFFFFFu - NEAR_FUTURE_MS ? 0 : elapsed;
}

static int is_old(uint32_t then_ms, uint32_t now_ms, uint32_t more_ms)
{
    return larics_since_ms(then_ms, now_ms) > LARICS_OLDEST_MS + more_ms;
}

/* Forgets what is older than a minute, so that a clock that comes round cannot make it young again. */
static void forget_old(larics_supervisor *camera, uint32_t now_ms)
{
    if (camera->choice.has_target && is_old(camera->choice.target_ms, now_ms, 0))
        larics_choice_forget(&camera->choice);
    if (is_old(camera->pose_ms, now_ms, 0)) camera->has_pose = 0;
    if (is_old(camera->seen_ms, now_ms, 0)) camera->has_seen = 0;
    if (is_old(camera->frame_ms, now_ms, 0)) camera->frame_ms = now_ms - LARICS_OLDEST_MS;
    if (is_old(camera->heard_ms, now_ms, 0)) camera->heard_ms = now_ms - LARICS_OLDEST_MS;
    if (is_old(camera->told_ms, now_ms, 0)) {
        camera->told_ms = now_ms - LARICS_OLDEST_MS;
        camera->has_status = 0;
    }
    if (is_old(camera->picture_ms, now_ms, 0)) camera->picture_ms = now_ms - LARICS_OLDEST_MS;
    if (is_old(camera->asked_ms, now_ms, NEAR_FUTURE_MS)) camera->has_asked = camera->asked = 0;
    if (is_old(camera->proven_ms, now_ms, camera->limits.challenge_ms)) camera->has_proof = 0;
}

void larics_begin_drain(larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t gap_ms = larics_since_ms(camera->drained_ms, now_ms);
    forget_old(camera, now_ms);
    camera->is_late = camera->has_heard && camera->limits.buffer_bytes && gap_ms > camera->most_drain_ms;
    if (camera->is_late) {
        camera->is_overrun = 1;
        camera->noticed.overruns++;
    }
    camera->arrived_ms = camera->drained_ms;
    camera->drained_ms = now_ms;
    if (camera->has_heard && larics_since_ms(camera->heard_ms, now_ms) > camera->limits.silent_ms)
        camera->is_anchored = camera->has_proof = 0; /* who speaks after a silence has to prove itself */
}

int larics_is_contradictory(const larics_message *message)
{
    if (message->type == LARICS_MARKER) {
        const larics_marker *m = &message->as.marker;
        int is_none = (m->flags & LARICS_MARKER_NONE) != 0;
        int is_uncertain = (m->flags & LARICS_MARKER_ID_UNCERTAIN) != 0;
        if (is_none != (m->count == 0)) return 1;
        if (is_none) return m->id != LARICS_ID_NONE || m->index || m->x_mm10 || m->y_mm10;
        if (m->index >= m->count || is_uncertain != (m->id == LARICS_ID_NONE)) return 1;
        return (m->flags & LARICS_MARKER_NO_OFFSET) && (m->x_mm10 || m->y_mm10);
    }
    if (message->type == LARICS_POSE) {
        const larics_pose *p = &message->as.pose;
        return p->state == LARICS_TRACKING && p->id == LARICS_ID_NONE;
    }
    return 0;
}

/* Takes the number of the frame that a measurement is of. */
static void take_frame(larics_supervisor *camera, uint32_t frame)
{
    uint32_t step = (frame - camera->frame) & LARICS_COUNT_MAX;
    if (camera->has_frame && step == 0) return;
    if (camera->has_frame && step >= HALF_OF_COUNT) { /* in sequence, so the numbers began anew */
        camera->noticed.sensor_restarts++;
        larics_source_void(camera);
    }
    camera->frame = frame;
    camera->has_frame = 1;
    camera->frame_ms = camera->drained_ms;
    camera->faults &= ~LARICS_BIT(LARICS_FAULT_CAMERA_TIMEOUT); /* refuted */
    camera->is_restarted = 0;
}

/* Counts the frames whose first marker measures the same to the last digit, which a sensor's noise prevents.
 * The camera searches the whole frame now and then, with its own rounding: so there are two results. */
static void compare_picture(larics_supervisor *camera, const larics_marker *m)
{
    uint32_t picture = (uint32_t)m->x_mm10 * 31u + (uint32_t)m->y_mm10;
    picture = picture * 31u + (uint32_t)m->z_mm10;
    picture = picture * 31u + m->heading_cdeg;
    picture = picture * 31u + m->radius_q8;
    picture = picture * 31u + m->margin;
    if (camera->has_picture && (picture == camera->pictures[0] || picture == camera->pictures[1])) {
        if (camera->equal_frames < 0xFFFFu) camera->equal_frames++;
    } else {
        camera->equal_frames = 0;
    }
    if (picture != camera->pictures[0]) camera->pictures[1] = camera->pictures[0];
    camera->pictures[0] = picture;
    camera->picture_ms = camera->drained_ms;
    camera->has_picture = 1;
}

/* Frames without a marker for so long are no more of the picture that was compared. */
static void forget_picture(larics_supervisor *camera)
{
    if (larics_since_ms(camera->picture_ms, camera->drained_ms) <= camera->limits.stalled_ms) return;
    camera->has_picture = 0;
    camera->equal_frames = 0;
}

static void take_marker(larics_supervisor *camera, const larics_marker *marker)
{
    take_frame(camera, marker->frame);
    if (marker->count == 0) {
        forget_picture(camera);
        return;
    }
    if (marker->index == 0) compare_picture(camera, marker);
    if (marker->flags & UNUSABLE_FLAGS) {
        camera->seen_ms = camera->drained_ms;
        camera->has_seen = 1;
        return;
    }
    larics_choice_take(&camera->choice, marker, camera->arrived_ms);
}

static void take_pose(larics_supervisor *camera, const larics_pose *pose)
{
    take_frame(camera, pose->frame);
    camera->pose_state = pose->state;
    if (pose->state == LARICS_LOST) return;
    camera->pose = *pose;
    camera->pose_ms = camera->arrived_ms;
    camera->has_pose = 1;
}

static int take(larics_supervisor *camera, const larics_message *message)
{
    uint16_t sequence = message->sequence;
    switch (message->type) {
    case LARICS_INFO:
        return larics_source_info(camera, &message->as.info, sequence);
    case LARICS_STATUS:
        return larics_source_status(camera, &message->as.status, sequence);
    case LARICS_ACK:
        return larics_source_ack(camera, &message->as.ack, sequence);
    case LARICS_MARKER:
        if (!larics_source_measurement(camera, sequence)) return 0;
        take_marker(camera, &message->as.marker);
        return 1;
    case LARICS_POSE:
        if (!larics_source_measurement(camera, sequence)) return 0;
        take_pose(camera, &message->as.pose);
        return 1;
    default:
        return larics_source_is_in_order(camera, sequence);
    }
}

int larics_supervise(larics_supervisor *camera, const larics_message *message)
{
    int is_accepted;
    if (message->type >= LARICS_FIRST_COMMAND) { /* an echo of our own, or another vehicle */
        camera->noticed.foreign++;
        return 0;
    }
    if (larics_is_contradictory(message)) {
        camera->noticed.contradictory++;
        return 0;
    }
    if (!camera->has_heard) camera->told_ms = camera->drained_ms;
    is_accepted = take(camera, message);
    camera->heard_ms = camera->drained_ms;
    camera->has_heard = 1;
    if (!is_accepted) return 0;
    camera->noticed.accepted++;
    if (!camera->is_late) camera->is_overrun = 0;
    return 1;
}
