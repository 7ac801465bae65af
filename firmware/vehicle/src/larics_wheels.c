#include "larics_wheels.h"

#include <string.h>

#include "larics_arith.h"

#define MOST_UM 200000
#define MOST_APART_UM 140000 /* of both wheels in one call: products stay within 30 bits */
#define MOST_TURN_MCDEG 9000000
#define CIRCLE_MCDEG 36000000
#define FURTHEST_MM10 500000000 /* 50 km: the wire carries little more */
#define Q7_PER_MM10 12800       /* 1/128 um in 0.1 mm */

void larics_wheels_init(larics_wheels *wheels, uint32_t seed)
{
    memset(wheels, 0, sizeof *wheels);
    wheels->epoch = (uint8_t)(seed ^ seed >> 8 ^ seed >> 16 ^ seed >> 24);
    wheels->is_standing = 1;
}

void larics_wheels_reset(larics_wheels *wheels)
{
    wheels->x_mm10 = wheels->y_mm10 = wheels->rest_x_q7 = wheels->rest_y_q7 = 0;
    wheels->heading_mcdeg = wheels->rest_turn = 0;
    wheels->rest_way = 0;
    wheels->epoch = (uint8_t)(wheels->epoch + 1u);
}

static int is_within(int32_t value, int32_t most)
{
    return -most <= value && value <= most;
}

/* Adds um * cosine / 2**14 to a coordinate, whose rest is kept in 1/128 um. */
static void add(int32_t *place_mm10, int32_t *rest_q7, int32_t um, int32_t cosine_q14)
{
    int32_t high = larics_floor_shift(um, 7), low = um - high * 128;
    int32_t sum = *rest_q7 + high * cosine_q14 + larics_floor_shift(low * cosine_q14 + 64, 7);
    int32_t whole = larics_floor_div(sum, Q7_PER_MM10);
    *place_mm10 += whole;
    *rest_q7 = sum - whole * Q7_PER_MM10;
}

int larics_wheels_move(larics_wheels *wheels, int32_t forward_um, int32_t turn_mcdeg, uint32_t now_us)
{
    int32_t middle_mdeg, turn16;
    if (!is_within(forward_um, MOST_UM) || !is_within(turn_mcdeg, MOST_TURN_MCDEG)) return 0;
    middle_mdeg = larics_floor_mod(wheels->heading_mcdeg + larics_floor_shift(turn_mcdeg, 1), CIRCLE_MCDEG) / 100;
    turn16 = (middle_mdeg / 10 * 2048 + middle_mdeg % 10 * 205 + 562) / 1125;
    add(&wheels->x_mm10, &wheels->rest_x_q7, forward_um, larics_cos_q14(turn16));
    add(&wheels->y_mm10, &wheels->rest_y_q7, forward_um, larics_sin_q14(turn16));
    wheels->heading_mcdeg = larics_floor_mod(wheels->heading_mcdeg + turn_mcdeg, CIRCLE_MCDEG);
    wheels->is_standing = forward_um == 0 && turn_mcdeg == 0;
    wheels->sampled_us = now_us;
    if (!is_within(wheels->x_mm10, FURTHEST_MM10) || !is_within(wheels->y_mm10, FURTHEST_MM10))
        larics_wheels_reset(wheels);
    return 1;
}

int larics_wheels_roll(larics_wheels *wheels, int32_t left_um, int32_t right_um, uint16_t track_mm,
                       uint32_t now_us)
{
    int32_t unit = (int32_t)track_mm * 125, apart_um, both_um, product, turn_mdeg, rest;
    if (!is_within(left_um, MOST_UM) || !is_within(right_um, MOST_UM)) return 0;
    apart_um = right_um - left_um;
    if (!is_within(apart_um, MOST_APART_UM) || track_mm < 10 || track_mm > 5000) return 0;
    both_um = left_um + right_um + wheels->rest_way;
    product = apart_um * 7162; /* 57.296 mdeg for each um on a track of 1 mm; then hundredths of that */
    turn_mdeg = larics_floor_div(product, unit);
    rest = (product - turn_mdeg * unit) * 100 + wheels->rest_turn;
    if (!larics_wheels_move(wheels, larics_floor_shift(both_um, 1), turn_mdeg * 100 + rest / unit, now_us)) return 0;
    wheels->rest_way = (uint8_t)((uint32_t)both_um & 1u);
    wheels->rest_turn = rest % unit;
    wheels->is_standing = left_um == 0 && right_um == 0;
    return 1;
}

size_t larics_wheels_message(const larics_wheels *wheels, uint32_t now_us, uint16_t *sequence,
                             uint8_t frame[LARICS_MAX_FRAME])
{
    larics_message message;
    size_t size;
    larics_set_odometry(&message, wheels->sampled_us, now_us, wheels->x_mm10, wheels->y_mm10,
                        wheels->heading_mcdeg / 1000, wheels->epoch);
    if (wheels->is_slipping) message.as.odometry.flags |= LARICS_ODOMETRY_SLIP;
    if (wheels->is_standing) message.as.odometry.flags |= LARICS_ODOMETRY_STANDING;
    size = larics_encode(&message, *sequence, frame);
    *sequence = (uint16_t)(*sequence + 1u);
    return size;
}
