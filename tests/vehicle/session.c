/* A vehicle that does what the lines on standard input say, for the tests of supervision and choice.
 *
 *     set NAME VALUE    a limit, before `init`         init NOW SEED
 *     drain NOW         begins to read                 feed HEX        what was received
 *     idle NOW          turns of the loop that find nothing to read, 2 ms each, until NOW
 *     ask NOW           prints the challenge in hexadecimal, "-" for none
 *     marker NOW        prints state, age, and ID, x, y of the target (0 without one)
 *     pose NOW          prints state, age, and ID, x, y
 *     search NOW        prints larics_may_search       by NOW          whether to drive by the last message
 *     status NOW        prints the age of the faults told
 *     follow HERE NEXT  chooses by route               noticed         prints counters as name=value
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "larics_supervisor.h"

static larics_decoder decoder;
static larics_supervisor camera;
static larics_limits limits;
static uint16_t own_sequence;

static void set(const char *name, const char *value)
{
    unsigned long number = strtoul(value, NULL, 0);
#define LIMIT(member, kind) \
    if (!strcmp(name, #member)) { \
        limits.member = (kind)number; \
        return; \
    }
    LIMIT(baud, uint32_t)
    LIMIT(buffer_bytes, uint16_t)
    LIMIT(max_age_ms, uint16_t)
    LIMIT(silent_ms, uint16_t)
    LIMIT(stalled_ms, uint16_t)
    LIMIT(frozen_frames, uint16_t)
    LIMIT(most_gap, uint16_t)
    LIMIT(most_loss_percent, uint8_t)
    LIMIT(faults, uint32_t)
    LIMIT(most_sigma_mm10, uint16_t)
    LIMIT(most_sigma_cdeg, uint16_t)
    LIMIT(most_carried_ms, uint16_t)
    LIMIT(most_way_mm, uint16_t)
    LIMIT(challenge_ms, uint16_t)
    LIMIT(answer_ms, uint16_t)
    LIMIT(status_ms, uint16_t)
    LIMIT(choice.mode, uint8_t)
    LIMIT(choice.id, uint16_t)
    LIMIT(choice.next_id, uint16_t)
    LIMIT(choice.frames, uint8_t)
    LIMIT(choice.keep_ms, uint16_t)
    if (!strcmp(name, "unique_id")) {
        for (size_t k = 0; k < 12; k++) {
            char pair[3] = {value[2 * k], value[2 * k + 1], 0};
            limits.unique_id[k] = (uint8_t)strtoul(pair, NULL, 16);
        }
        limits.is_pinned = 1;
        return;
    }
    fprintf(stderr, "no limit %s\n", name);
    exit(2);
}

static void feed(const char *hex)
{
    for (; hex[0] && hex[1]; hex += 2) {
        char pair[3] = {hex[0], hex[1], 0};
        if (larics_decode(&decoder, (uint8_t)strtoul(pair, NULL, 16)))
            larics_supervise(&camera, &decoder.message);
    }
}

int main(void)
{
    static char line[200000], word[32], first[150000], second[64];
    uint8_t frame[LARICS_MAX_FRAME];
    larics_limits_usual(&limits, 115200);
    while (fgets(line, sizeof line, stdin)) {
        int words = sscanf(line, "%31s %149999s %63s", word, first, second);
        uint32_t now = words > 1 ? (uint32_t)strtoul(first, NULL, 0) : 0;
        if (!strcmp(word, "set")) {
            set(first, second);
        } else if (!strcmp(word, "init")) {
            larics_decoder_init(&decoder);
            larics_supervisor_init(&camera, &limits, now, (uint32_t)strtoul(second, NULL, 0));
        } else if (!strcmp(word, "drain")) {
            larics_begin_drain(&camera, now);
        } else if (!strcmp(word, "idle")) {
            while (now - camera.drained_ms > 2u && now - camera.drained_ms < 0x80000000u)
                larics_begin_drain(&camera, camera.drained_ms + 2u);
        } else if (!strcmp(word, "feed")) {
            if (words > 1) feed(first);
        } else if (!strcmp(word, "ask")) {
            size_t size = larics_challenge(&camera, now, &own_sequence, frame);
            for (size_t k = 0; k < size; k++) printf("%02x", frame[k]);
            printf(size ? "\n" : "-\n");
        } else if (!strcmp(word, "marker")) {
            const larics_marker *m = &camera.choice.target;
            uint8_t state = larics_marker_state(&camera, now);
            if (larics_marker_is_fresh(&camera, now) != (state == LARICS_GOOD)) abort();
            printf("%d %lu %d %ld %ld\n", state, (unsigned long)larics_marker_age_ms(&camera, now),
                   camera.choice.has_target ? m->id : 0, (long)m->x_mm10, (long)m->y_mm10);
        } else if (!strcmp(word, "pose")) {
            uint8_t state = larics_pose_state(&camera, now);
            if (larics_pose_is_fresh(&camera, now) != (state == LARICS_GOOD)) abort();
            printf("%d %lu %d %ld %ld\n", state, (unsigned long)larics_pose_age_ms(&camera, now),
                   camera.pose.id, (long)camera.pose.x_mm10, (long)camera.pose.y_mm10);
        } else if (!strcmp(word, "by")) {
            printf("%d\n", larics_may_drive_by(&camera, &decoder.message, now));
        } else if (!strcmp(word, "search")) {
            printf("%d\n", larics_may_search(&camera, now));
        } else if (!strcmp(word, "status")) {
            printf("%lu\n", (unsigned long)larics_status_age_ms(&camera, now));
        } else if (!strcmp(word, "follow")) {
            larics_choice_follow(&camera.choice, (uint16_t)now, (uint16_t)strtoul(second, NULL, 0));
        } else if (!strcmp(word, "noticed")) {
            const larics_noticed *n = &camera.noticed;
            printf("accepted=%" PRIu32 " contradictory=%" PRIu32 " repeated=%" PRIu32 " jumps=%" PRIu32
                   " foreign=%" PRIu32 " unproven=%" PRIu32 " late_answers=%" PRIu32 " overruns=%" PRIu32
                   " restarts=%" PRIu32 " sensor_restarts=%" PRIu32 " changes=%" PRIu32 " crc=%" PRIu32 "\n",
                   n->accepted, n->contradictory, n->repeated, n->jumps, n->foreign, n->unproven,
                   n->late_answers, n->overruns, n->restarts, n->sensor_restarts, camera.choice.changes,
                   decoder.counters.crc);
        } else {
            fprintf(stderr, "no command %s\n", word);
            return 2;
        }
        fflush(stdout);
    }
    return 0;
}
