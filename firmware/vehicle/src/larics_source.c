#include "larics_source.h"

#include <string.h>

void larics_source_void(larics_supervisor *camera)
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

/* A boot number that is not the last one: 1 when it is a restart, 0 when it lies in the past. The camera draws it at
 * random: one of the past that answers a challenge, at once when there are any, has been drawn again. */
static int restart(larics_supervisor *camera, uint16_t boot, int is_proof)
{
    if (camera->has_boot) {
        if (was_before(camera, boot) && !is_proof) {
            if (camera->limits.challenge_ms) camera->has_info = camera->has_proof = camera->is_anchored = 0;
            return 0;
        }
        camera->boots[camera->boot_count % LARICS_BOOTS] = camera->boot;
        camera->boot_count = (uint8_t)(camera->boot_count < 2 * LARICS_BOOTS - 1 ? camera->boot_count + 1
                                                                                   : LARICS_BOOTS);
        camera->noticed.restarts++;
        camera->is_restarted = 1;
        larics_source_void(camera);
    }
    camera->boot = boot;
    camera->has_boot = 1;
    camera->has_info = camera->has_proof = camera->is_anchored = 0;
    camera->uptime_s = 0;
    camera->faults = 0;
    camera->has_status = 0;
    camera->told_ms = camera->drained_ms;
    return 1;
}

/* Whether a source may be believed without an answer to a challenge. */
static int is_trusting(const larics_supervisor *camera)
{
    if (camera->limits.challenge_ms || camera->is_foreign) return 0;
    return camera->has_info || (!camera->limits.is_pinned && !camera->has_identity);
}

int larics_source_is_in_order(larics_supervisor *camera, uint16_t sequence)
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
    if (larics_since_ms(camera->asked_ms, camera->drained_ms) > camera->limits.answer_ms) {
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

int larics_source_info(larics_supervisor *camera, const larics_info *info, uint16_t sequence)
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
        if (!restart(camera, info->boot, is_proof)) {
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
    return larics_source_is_in_order(camera, sequence);
}

int larics_source_status(larics_supervisor *camera, const larics_status *status, uint16_t sequence)
{
    if (!camera->has_boot || camera->boot != status->boot) {
        if (!restart(camera, status->boot, 0)) {
            camera->noticed.foreign++;
            return 0;
        }
    } else if (status->uptime_s < camera->uptime_s) {
        camera->noticed.repeated++;
        return 0;
    }
    if (!camera->is_anchored && is_trusting(camera))
        anchor(camera, sequence);
    else if (!larics_source_is_in_order(camera, sequence))
        return 0;
    camera->uptime_s = status->uptime_s;
    camera->faults = status->active_faults;
    camera->told_ms = camera->drained_ms;
    camera->has_status = 1;
    return 1;
}

int larics_source_ack(larics_supervisor *camera, const larics_ack *ack, uint16_t sequence)
{
    if (ack->command == LARICS_PING && is_answer(camera, LARICS_PING, ack->token) && camera->has_info &&
        !camera->is_foreign) {
        prove(camera, sequence);
        return 1;
    }
    return larics_source_is_in_order(camera, sequence);
}

int larics_source_measurement(larics_supervisor *camera, uint16_t sequence)
{
    if (camera->is_anchored) return larics_source_is_in_order(camera, sequence);
    if (camera->has_heard || !is_trusting(camera)) {
        camera->noticed.unproven++;
        return 0;
    }
    anchor(camera, sequence);
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
    uint32_t waited_ms = larics_since_ms(camera->asked_ms, now_ms);
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

int larics_source_is_proven(const larics_supervisor *camera, uint32_t now_ms)
{
    const larics_limits *limits = &camera->limits;
    if (!camera->is_anchored) return 0;
    if (!limits->challenge_ms) return !limits->is_pinned || camera->has_info;
    return camera->has_proof &&
           larics_since_ms(camera->proven_ms, now_ms) <= (uint32_t)limits->challenge_ms + 3u * limits->answer_ms;
}
