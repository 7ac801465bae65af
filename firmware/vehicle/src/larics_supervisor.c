#include "larics_supervisor.h"

#include <string.h>

#define NEAR_FUTURE_MS 60000u
#define OLDEST_MS 60000u
#define UNUSABLE_FLAGS (LARICS_MARKER_ID_UNCERTAIN | LARICS_MARKER_UNCONFIRMED | LARICS_MARKER_NO_OFFSET)
#define BIT(code) ((uint32_t)1 << (code))
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
    limits->faults = BIT(LARICS_FAULT_CAMERA_TIMEOUT) | BIT(LARICS_FAULT_SETTINGS_CORRUPT) |
                     BIT(LARICS_FAULT_DETECT) | BIT(LARICS_FAULT_MEMORY) | BIT(LARICS_FAULT_SAFE_MODE) |
                     BIT(LARICS_FAULT_CAMERA) | BIT(LARICS_FAULT_LOOP);
    limits->answer_ms = 150;
    larics_choice_init(&usual, NULL);
    limits->choice = usual.rule;
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

/* Milliseconds from `then` to `now`; what lies in the near future counts as now. */
static uint32_t since(uint32_t then_ms, uint32_t now_ms)
{
    uint32_t elapsed = now_ms - then_ms;
    return elapsed > 0xFFFFFFFFu - NEAR_FUTURE_MS ? 0 : elapsed;
}

/* Forgets what is older than a minute, so that a clock that comes round cannot make it young again. */
static void forget_old(larics_supervisor *camera, uint32_t now_ms)
{
    if (camera->choice.has_target && since(camera->choice.target_ms, now_ms) > OLDEST_MS)
        larics_choice_forget(&camera->choice);
    if (since(camera->pose_ms, now_ms) > OLDEST_MS) camera->has_pose = 0;
    if (since(camera->seen_ms, now_ms) > OLDEST_MS) camera->has_seen = 0;
    if (since(camera->frame_ms, now_ms) > OLDEST_MS) camera->frame_ms = now_ms - OLDEST_MS;
    if (since(camera->heard_ms, now_ms) > OLDEST_MS) camera->heard_ms = now_ms - OLDEST_MS;
    if (since(camera->asked_ms, now_ms) > OLDEST_MS + NEAR_FUTURE_MS) camera->has_asked = camera->asked = 0;
    if (since(camera->proven_ms, now_ms) > OLDEST_MS + camera->limits.challenge_ms) camera->has_proof = 0;
}

void larics_begin_drain(larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t gap_ms = since(camera->drained_ms, now_ms);
    forget_old(camera, now_ms);
    camera->is_late = camera->has_heard && camera->limits.buffer_bytes && gap_ms > camera->most_drain_ms;
    if (camera->is_late) {
        camera->is_overrun = 1;
        camera->noticed.overruns++;
    }
    camera->arrived_ms = camera->drained_ms;
    camera->drained_ms = now_ms;
    if (camera->has_heard && since(camera->heard_ms, now_ms) > camera->limits.silent_ms)
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

static void void_measurements(larics_supervisor *camera)
{
    larics_choice_forget(&camera->choice);
    camera->has_pose = camera->has_seen = camera->has_frame = camera->has_picture = 0;
    camera->equal_frames = 0;
    camera->pose_state = LARICS_LOST;
}

static void anchor(larics_supervisor *camera, uint16_t sequence)
{
    camera->sequence = sequence;
    camera->is_anchored = 1;
    camera->loss_q16 = 0;
}

static int was_before(const larics_supervisor *camera, uint16_t boot)
{
    for (uint8_t k = 0; k < camera->boot_count && k < LARICS_BOOTS; k++)
        if (camera->boots[k] == boot) return 1;
    return 0;
}

/* A boot number that is not the last one: 1 when it is a restart, 0 when it lies in the past. */
static int restart(larics_supervisor *camera, uint16_t boot)
{
    if (camera->has_boot) {
        if (was_before(camera, boot)) return 0;
        camera->boots[camera->boot_count % LARICS_BOOTS] = camera->boot;
        camera->boot_count = (uint8_t)(camera->boot_count < 2 * LARICS_BOOTS - 1 ? camera->boot_count + 1
                                                                                   : LARICS_BOOTS);
        camera->noticed.restarts++;
        camera->is_restarted = 1;
        void_measurements(camera);
    }
    camera->boot = boot;
    camera->has_boot = 1;
    camera->has_info = camera->has_proof = camera->is_anchored = 0;
    camera->uptime_s = 0;
    camera->faults = 0;
    return 1;
}

/* Whether a source may be believed without an answer to a challenge. */
static int is_trusting(const larics_supervisor *camera)
{
    if (camera->limits.challenge_ms || camera->is_foreign) return 0;
    return camera->has_info || (!camera->limits.is_pinned && !camera->has_identity);
}

static int is_in_order(larics_supervisor *camera, uint16_t sequence)
{
    uint16_t ahead = (uint16_t)(sequence - camera->sequence), missing = (uint16_t)(ahead - 1u);
    uint16_t loss = camera->loss_q16;
    if (!camera->is_anchored) return 0;
    if (missing >= 0x7FFFu) {
        camera->noticed.repeated++;
        return 0;
    }
    if (missing > camera->limits.most_gap) {
        camera->noticed.jumps++;
        camera->is_anchored = camera->has_proof = 0;
        return 0;
    }
    loss = (uint16_t)(loss - (loss >> 6));
    for (uint16_t k = 0; k < missing && k < 64; k++) loss = (uint16_t)(loss + ((0xFFFFu - loss) >> 6));
    camera->loss_q16 = loss;
    camera->sequence = sequence;
    return 1;
}

static int is_answer(larics_supervisor *camera, uint8_t command, uint16_t token)
{
    if (camera->asked != command || camera->nonce != token) return 0;
    camera->asked = 0;
    if (since(camera->asked_ms, camera->drained_ms) > camera->limits.answer_ms) {
        camera->noticed.late_answers++;
        return 0;
    }
    return 1;
}

static void prove(larics_supervisor *camera, uint16_t sequence)
{
    anchor(camera, sequence);
    camera->has_proof = 1;
    camera->proven_ms = camera->drained_ms;
}

static int take_info(larics_supervisor *camera, const larics_info *info, uint16_t sequence)
{
    int is_proof = is_answer(camera, LARICS_GET_INFO, info->token);
    const uint8_t *expected = camera->limits.is_pinned ? camera->limits.unique_id : camera->unique_id;
    if ((camera->limits.is_pinned || camera->has_identity) && memcmp(expected, info->unique_id, 12)) {
        camera->noticed.foreign++;
        camera->is_foreign = 1;
        camera->is_anchored = camera->has_proof = 0;
        return 0;
    }
    if (!camera->has_boot || camera->boot != info->boot) {
        if (!restart(camera, info->boot)) {
            camera->noticed.foreign++;
            return 0;
        }
    }
    if (is_proof || !camera->limits.challenge_ms) {
        memcpy(camera->unique_id, info->unique_id, 12);
        camera->has_identity = camera->has_info = 1;
        camera->is_foreign = 0;
        if (is_proof) {
            prove(camera, sequence);
            return 1;
        }
        if (!camera->is_anchored) {
            anchor(camera, sequence);
            return 1;
        }
    }
    return is_in_order(camera, sequence);
}

static int take_status(larics_supervisor *camera, const larics_status *status, uint16_t sequence)
{
    if (!camera->has_boot || camera->boot != status->boot) {
        if (!restart(camera, status->boot)) {
            camera->noticed.foreign++;
            return 0;
        }
    } else if (status->uptime_s < camera->uptime_s) {
        camera->noticed.repeated++;
        return 0;
    }
    if (!camera->is_anchored && is_trusting(camera))
        anchor(camera, sequence);
    else if (!is_in_order(camera, sequence))
        return 0;
    camera->uptime_s = status->uptime_s;
    camera->faults = status->active_faults;
    return 1;
}

/* Takes the number of the frame that a measurement is of. */
static void take_frame(larics_supervisor *camera, uint32_t frame)
{
    uint32_t step = (frame - camera->frame) & LARICS_COUNT_MAX;
    if (camera->has_frame && step == 0) return;
    if (camera->has_frame && step >= HALF_OF_COUNT) { /* in sequence, so the numbers began anew */
        camera->noticed.sensor_restarts++;
        void_measurements(camera);
    }
    camera->frame = frame;
    camera->has_frame = 1;
    camera->frame_ms = camera->drained_ms;
    camera->faults &= ~BIT(LARICS_FAULT_CAMERA_TIMEOUT); /* refuted */
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
    camera->has_picture = 1;
}

static void take_marker(larics_supervisor *camera, const larics_marker *marker)
{
    take_frame(camera, marker->frame);
    if (marker->count == 0) return;
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
        return take_info(camera, &message->as.info, sequence);
    case LARICS_STATUS:
        return take_status(camera, &message->as.status, sequence);
    case LARICS_ACK:
        if (message->as.ack.command == LARICS_PING && is_answer(camera, LARICS_PING, message->as.ack.token) &&
            camera->has_info && !camera->is_foreign) {
            prove(camera, sequence);
            return 1;
        }
        return is_in_order(camera, sequence);
    case LARICS_MARKER:
    case LARICS_POSE:
        if (!camera->is_anchored && !camera->has_heard && is_trusting(camera))
            anchor(camera, sequence);
        else if (!camera->is_anchored) {
            camera->noticed.unproven++;
            return 0;
        } else if (!is_in_order(camera, sequence))
            return 0;
        if (message->type == LARICS_MARKER)
            take_marker(camera, &message->as.marker);
        else
            take_pose(camera, &message->as.pose);
        return 1;
    default:
        return is_in_order(camera, sequence);
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
    is_accepted = take(camera, message);
    camera->heard_ms = camera->drained_ms;
    camera->has_heard = 1;
    if (!is_accepted) return 0;
    camera->noticed.accepted++;
    if (!camera->is_late) camera->is_overrun = 0;
    return 1;
}

static uint16_t draw(larics_supervisor *camera)
{
    camera->random ^= camera->random << 13;
    camera->random ^= camera->random >> 17;
    camera->random ^= camera->random << 5;
    return (uint16_t)(camera->random >> 8);
}

size_t larics_challenge(larics_supervisor *camera, uint32_t now_ms, uint16_t *sequence,
                        uint8_t frame[LARICS_MAX_FRAME])
{
    larics_message message;
    uint32_t waited_ms = since(camera->asked_ms, now_ms);
    int is_doubted = !camera->has_info || !camera->is_anchored || camera->is_foreign;
    size_t size;
    if (!camera->limits.challenge_ms) return 0;
    if (camera->has_asked) {
        if (waited_ms < camera->limits.answer_ms && (camera->asked || is_doubted)) return 0;
        if (!camera->asked && !is_doubted && waited_ms < camera->limits.challenge_ms) return 0;
    }
    camera->nonce = draw(camera);
    camera->asked = is_doubted ? LARICS_GET_INFO : LARICS_PING;
    camera->asked_ms = now_ms;
    camera->has_asked = 1;
    memset(&message, 0, sizeof message);
    message.type = camera->asked;
    if (is_doubted)
        message.as.get_info.token = camera->nonce;
    else
        message.as.ping.token = camera->nonce;
    size = larics_encode(&message, *sequence, frame);
    *sequence = (uint16_t)(*sequence + 1u);
    return size;
}

static uint32_t age_ms(uint32_t arrived_ms, uint32_t age_us, uint16_t on_line_ms, uint32_t now_ms)
{
    uint32_t age = since(arrived_ms, now_ms), before = age_us / 1000u + 1u + on_line_ms;
    return age > OLDEST_MS || before > OLDEST_MS ? LARICS_NEVER : age + before;
}

uint32_t larics_marker_age_ms(const larics_supervisor *camera, uint32_t now_ms)
{
    if (!camera->choice.has_target) return LARICS_NEVER;
    return age_ms(camera->choice.target_ms, camera->choice.target.age_us, camera->marker_line_ms, now_ms);
}

uint32_t larics_pose_age_ms(const larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t age_us = (uint32_t)camera->pose.marker_age_ms * 1000u;
    if (!camera->has_pose) return LARICS_NEVER;
    if (camera->pose.state == LARICS_CARRIED) age_us = camera->pose.age_us;
    return age_ms(camera->pose_ms, age_us, camera->pose_line_ms, now_ms);
}

static int is_proven(const larics_supervisor *camera, uint32_t now_ms)
{
    const larics_limits *limits = &camera->limits;
    if (!camera->is_anchored) return 0;
    if (!limits->challenge_ms) return !limits->is_pinned || camera->has_info;
    return camera->has_proof &&
           since(camera->proven_ms, now_ms) <= (uint32_t)limits->challenge_ms + 3u * limits->answer_ms;
}

/* What forbids steering whatever is measured, or LARICS_GOOD. */
static uint8_t camera_state(const larics_supervisor *camera, uint32_t now_ms)
{
    const larics_limits *limits = &camera->limits;
    if (!camera->has_heard) return LARICS_WAITING;
    if (since(camera->heard_ms, now_ms) > limits->silent_ms) return LARICS_SILENT;
    if (camera->is_foreign) return LARICS_FOREIGN;
    if (camera->is_restarted) return LARICS_RESTARTED;
    if (!is_proven(camera, now_ms)) return camera->is_overrun ? LARICS_OVERRUN : LARICS_UNPROVEN;
    if (camera->faults & limits->faults) return LARICS_FAULTY;
    if (!camera->has_frame || since(camera->frame_ms, now_ms) > limits->stalled_ms) return LARICS_STALLED;
    if (limits->frozen_frames && camera->equal_frames >= limits->frozen_frames) return LARICS_FROZEN;
    if (camera->loss_q16 > limits->most_loss_percent * 655u) return LARICS_DAMAGED;
    return LARICS_GOOD;
}

static uint8_t state_of(const larics_supervisor *camera, uint32_t age, int is_seen, uint32_t now_ms)
{
    uint8_t state = camera_state(camera, now_ms);
    if (state != LARICS_GOOD) return state;
    if (age <= camera->limits.max_age_ms) return LARICS_GOOD;
    if (camera->is_overrun) return LARICS_OVERRUN;
    return is_seen ? LARICS_UNUSABLE : LARICS_NO_MARKER;
}

uint8_t larics_marker_state(const larics_supervisor *camera, uint32_t now_ms)
{
    int is_seen = camera->has_seen && since(camera->seen_ms, now_ms) <= camera->limits.max_age_ms;
    return state_of(camera, larics_marker_age_ms(camera, now_ms), is_seen, now_ms);
}

uint8_t larics_pose_state(const larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t age = camera->pose_state == LARICS_LOST ? LARICS_NEVER : larics_pose_age_ms(camera, now_ms);
    return state_of(camera, age, 0, now_ms);
}

int larics_marker_is_fresh(const larics_supervisor *camera, uint32_t now_ms)
{
    return larics_marker_state(camera, now_ms) == LARICS_GOOD;
}

int larics_pose_is_fresh(const larics_supervisor *camera, uint32_t now_ms)
{
    return larics_pose_state(camera, now_ms) == LARICS_GOOD;
}

int larics_may_search(const larics_supervisor *camera, uint32_t now_ms)
{
    return camera_state(camera, now_ms) == LARICS_GOOD;
}
