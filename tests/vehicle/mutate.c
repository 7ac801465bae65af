/* Feeds the decoder with damaged streams: mutate CORPUS BYTES [SEED [supervise]].
 *
 * CORPUS holds frames whose sequence numbers are 0, 1, 2, ... Runs of them are cut, spliced, duplicated,
 * and hit by bit flips, losses, insertions and noise. Every message that is accepted is encoded again and
 * compared with the frame of its number: one that differs was never sent. Prints figures as name=value.
 *
 * With `supervise` what is accepted goes through the supervisor, in pieces, while a clock runs that jumps and
 * wraps. In CORPUS the frame number of each message is its sequence number then, so that the age of what is
 * called fresh can be told by a clock of 64 bits: one above the limit is `stale`, one that may not be
 * steered by `unfit`.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "larics_supervisor.h"

#define MOST_FRAMES 65536
#define PIECE 16384

static uint8_t *corpus;
static size_t starts[MOST_FRAMES + 1];
static size_t frames;
static uint64_t state;

static uint32_t draw(uint32_t below)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(((state >> 32) * below) >> 32);
}

static int load(const char *name)
{
    FILE *file = fopen(name, "rb");
    long size;
    if (!file || fseek(file, 0, SEEK_END) || (size = ftell(file)) <= 0) return 0;
    rewind(file);
    corpus = malloc((size_t)size);
    if (!corpus || fread(corpus, 1, (size_t)size, file) != (size_t)size) return 0;
    fclose(file);
    for (size_t k = 0; k < (size_t)size && frames < MOST_FRAMES; k++)
        if (corpus[k] == 0) starts[++frames] = k + 1;
    return frames > 0;
}

#define MOST_AGE_MS 100

static larics_supervisor camera;
static uint64_t clock_ms = 0xFFFF0000u; /* near the wrap of its low half */
static uint64_t fed_ms[MOST_FRAMES];
static uint64_t fresh, stale, unfit, challenges;

static void start_supervisor(void)
{
    larics_limits limits;
    larics_limits_usual(&limits, 115200);
    limits.max_age_ms = MOST_AGE_MS;
    if (draw(2)) limits.challenge_ms = (uint16_t)(1 + draw(2000));
    limits.choice.mode = (uint8_t)draw(3);
    limits.choice.id = (uint16_t)(3 + draw(3));
    limits.choice.next_id = (uint16_t)(3 + draw(3));
    limits.frozen_frames = (uint16_t)draw(3);
    limits.most_gap = (uint16_t)draw(65536);
    limits.most_carried_ms = (uint16_t)draw(2000);
    limits.most_way_mm = (uint16_t)draw(3000);
    limits.most_sigma_mm10 = (uint16_t)(draw(3) ? draw(1000) : 65535u);
    limits.most_sigma_cdeg = (uint16_t)draw(400);
    larics_supervisor_init(&camera, &limits, (uint32_t)clock_ms, draw(0xFFFFFFFFu));
}

static void judge(void)
{
    uint32_t now = (uint32_t)clock_ms - draw(3);
    const larics_limits *limits = &camera.limits;
    if (larics_marker_is_fresh(&camera, now)) {
        const larics_marker *m = &camera.choice.target;
        fresh++;
        if (m->frame >= frames || clock_ms - fed_ms[m->frame] > MOST_AGE_MS + 3) stale++;
        if (!m->count || (m->flags & ~(unsigned)LARICS_MARKER_TRACKED)) unfit++;
    }
    if (larics_pose_is_fresh(&camera, now)) {
        fresh++;
        if (camera.pose.frame >= frames || clock_ms - fed_ms[camera.pose.frame] > MOST_AGE_MS + 3) stale++;
        if (camera.pose_state == LARICS_LOST) unfit++;
        if (camera.pose.sigma_x_mm10 > limits->most_sigma_mm10 || camera.pose.sigma_cdeg > limits->most_sigma_cdeg)
            unfit++;
        if (camera.pose.state == LARICS_CARRIED && (camera.pose.marker_age_ms > limits->most_carried_ms ||
                                                    camera.pose.way_mm > limits->most_way_mm))
            unfit++;
    }
}

/* The next turn of the loop: mostly in time, now and then late, seldom after the clock has come round. */
static void turn(void)
{
    int rounds = draw(2000) ? 1 : 5;
    while (rounds--) {
        if (rounds)
            clock_ms += 0x33333333u;
        else
            clock_ms += draw(8) ? draw(6) : draw(40) ? draw(400) : draw(90000);
        judge();
        larics_begin_drain(&camera, (uint32_t)clock_ms - draw(2));
    }
}

/* Feeds a message, and now and then an answer to a challenge. */
static void supervise(const larics_message *message, uint16_t *sequence)
{
    uint8_t frame[LARICS_MAX_FRAME];
    if (message->sequence < frames) fed_ms[message->sequence] = clock_ms;
    larics_supervise(&camera, message);
    judge();
    if (draw(4) == 0 && larics_challenge(&camera, (uint32_t)clock_ms, sequence, frame)) {
        larics_message answer;
        memset(&answer, 0, sizeof answer);
        challenges++;
        answer.sequence = message->sequence;
        if (camera.asked == LARICS_PING) {
            answer.type = LARICS_ACK;
            answer.as.ack.command = LARICS_PING;
            answer.as.ack.token = camera.nonce;
        } else {
            answer.type = LARICS_INFO;
            answer.as.info.boot = 7;
            answer.as.info.token = camera.nonce;
            memcpy(answer.as.info.unique_id, "camera-one--", 12);
        }
        if (draw(4)) larics_supervise(&camera, &answer);
        judge();
    }
}

/* Bytes a second of undamaged streams, without looking at the messages. */
static double throughput(uint64_t wanted)
{
    larics_decoder decoder;
    uint64_t fed = 0;
    clock_t start = clock();
    larics_decoder_init(&decoder);
    for (; fed < wanted; fed += starts[frames])
        for (size_t k = 0; k < starts[frames]; k++) larics_decode(&decoder, corpus[k]);
    return (double)fed / ((double)(clock() - start) / CLOCKS_PER_SEC);
}

/* A run of frames into piece; returns its length. */
static size_t run_of_frames(uint8_t *piece)
{
    size_t count = 0;
    size_t frame = draw((uint32_t)frames);
    size_t wanted = 1 + draw(60);
    while (wanted-- && frame < frames) {
        size_t size = starts[frame + 1] - starts[frame];
        if (count + size > PIECE / 2) break;
        memcpy(piece + count, corpus + starts[frame], size);
        count += size;
        frame += draw(20) ? 1 : 2;
    }
    return count;
}

static size_t damage(uint8_t *piece, size_t count)
{
    uint32_t wounds = draw(12);
    while (wounds-- && count > 1) {
        size_t place = draw((uint32_t)count);
        size_t length = 1 + draw(24);
        if (length > count - place) length = count - place;
        switch (draw(7)) {
        case 0: /* a bit */
            piece[place] ^= (uint8_t)(1u << draw(8));
            break;
        case 1: /* a burst */
            for (size_t k = 0; k < length; k++) piece[place + k] = (uint8_t)draw(256);
            break;
        case 2: /* a loss */
            memmove(piece + place, piece + place + length, count - place - length);
            count -= length;
            break;
        case 3: /* an insertion */
            if (count + length > PIECE) break;
            memmove(piece + place + length, piece + place, count - place);
            for (size_t k = 0; k < length; k++) piece[place + k] = (uint8_t)draw(256);
            count += length;
            break;
        case 4: /* a duplication */
            if (count + length > PIECE) break;
            memmove(piece + place + length, piece + place, count - place);
            count += length;
            break;
        case 5: /* the end is missing */
            if (!draw(4)) count = place;
            break;
        default: /* one byte, often a 0 */
            piece[place] = (uint8_t)(draw(2) ? 0 : draw(256));
        }
    }
    return count;
}

int main(int argc, char **argv)
{
    static uint8_t piece[PIECE + 64];
    larics_decoder decoder;
    uint64_t wanted, fed = 0, accepted = 0, forged = 0;
    double spent = 0;
    int is_supervised;
    uint16_t own_sequence = 0;

    if (argc < 3 || !load(argv[1])) {
        fprintf(stderr, "usage: mutate CORPUS BYTES [SEED]\n");
        return 2;
    }
    wanted = strtoull(argv[2], NULL, 10);
    state = 88172645463325252u + (argc > 3 ? strtoull(argv[3], NULL, 10) : 0) * 2685821657736338717u;
    is_supervised = argc > 4;
    larics_decoder_init(&decoder);
    start_supervisor();
    while (fed < wanted) {
        size_t count = run_of_frames(piece);
        clock_t start;
        if (draw(8)) count = damage(piece, count);
        start = clock();
        if (is_supervised && !draw(200)) start_supervisor();
        for (size_t k = 0; k < count; k++) {
            if (is_supervised && !draw(48)) {
                turn();
            }
            if (larics_decode(&decoder, piece[k])) {
                uint8_t frame[LARICS_MAX_FRAME];
                size_t number = decoder.message.sequence;
                size_t size = larics_encode(&decoder.message, decoder.message.sequence, frame);
                accepted++;
                if (number >= frames || size != starts[number + 1] - starts[number] ||
                    memcmp(frame, corpus + starts[number], size))
                    forged++;
                else if (is_supervised)
                    supervise(&decoder.message, &own_sequence);
            }
        }
        spent += (double)(clock() - start) / CLOCKS_PER_SEC;
        fed += count;
    }
    printf("bytes=%llu accepted=%llu forged=%llu seconds=%.3f undamaged_mb_per_s=%.1f\n",
           (unsigned long long)fed, (unsigned long long)accepted, (unsigned long long)forged, spent,
           throughput(wanted / 10) / 1e6);
    if (is_supervised)
        printf("fresh=%llu stale=%llu unfit=%llu challenges=%llu\n", (unsigned long long)fresh,
               (unsigned long long)stale, (unsigned long long)unfit, (unsigned long long)challenges);
    printf("messages=%lu crc=%lu cobs=%lu length=%lu version=%lu unknown=%lu over_long=%lu empty=%lu "
           "out_of_range=%lu gaps=%lu repeats=%lu restarts=%lu\n",
           (unsigned long)decoder.counters.messages, (unsigned long)decoder.counters.crc,
           (unsigned long)decoder.counters.cobs, (unsigned long)decoder.counters.length,
           (unsigned long)decoder.counters.version, (unsigned long)decoder.counters.unknown,
           (unsigned long)decoder.counters.over_long, (unsigned long)decoder.counters.empty,
           (unsigned long)decoder.counters.out_of_range, (unsigned long)decoder.counters.gaps,
           (unsigned long)decoder.counters.repeats, (unsigned long)decoder.counters.restarts);
    free(corpus);
    return 0;
}
