#include "larics_wheels.h"

#include <string.h>

#include "larics_arith.h"

#define MOST_UM 200000
#define MOST_TURN_MDEG 90000
#define FURTHEST_MM10 1000000000 /* 100 km: the next epoch begins at 0 */
#define Q7_PER_MM10 12800        /* 1/128 um in 0.1 mm */

void larics_wheels_init(larics_wheels *wheels, uint32_t seed)
{
    memset(wheels, 0, sizeof *wheels);
    wheels->epoch = (uint8_t)(seed ^ seed >> 8 ^ seed >> 16 ^ seed >> 24);
    wheels->is_standing = 1;
}

void larics_wheels_jump(larics_wheels *wheels)
{
    wheels->epoch = (uint8_t)(wheels->epoch + 1u);
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

int larics_wheels_move(larics_wheels *wheels, int32_t forward_um, int32_t turn_mdeg, uint32_t now_us)
{
    int32_t middle_mdeg, turn16;
    if (larics_abs(forward_um) > MOST_UM || larics_abs(turn_mdeg) > MOST_TURN_MDEG) return 0;
    middle_mdeg = larics_floor_mod(wheels->heading_mdeg + larics_floor_div(turn_mdeg, 2), 360000);
    turn16 = (middle_mdeg / 10 * 2048 + middle_mdeg % 10 * 205 + 562) / 1125;
    add(&wheels->x_mm10, &wheels->rest_x_q7, forward_um, larics_cos_q14(turn16));
    add(&wheels->y_mm10, &wheels->rest_y_q7, forward_um, larics_sin_q14(turn16));
    wheels->heading_mdeg = larics_floor_mod(wheels->heading_mdeg + turn_mdeg, 360000);
    wheels->is_standing = forward_um == 0 && turn_mdeg == 0;
    wheels->sampled_us = now_us;
    if (larics_abs(wheels->x_mm10) > FURTHEST_MM10 || larics_abs(wheels->y_mm10) > FURTHEST_MM10) {
        wheels->x_mm10 = wheels->y_mm10 = 0;
        larics_wheels_jump(wheels);
    }
    return 1;
}

int larics_wheels_roll(larics_wheels *wheels, int32_t left_um, int32_t right_um, uint16_t track_mm,
                       uint32_t now_us)
{
    int32_t difference = right_um - left_um, unit = (int32_t)track_mm * 125, sum, turn_mdeg;
    int32_t both_um = left_um + right_um + wheels->rest_way, forward_um = larics_floor_div(both_um, 2);
    if (larics_abs(left_um) > MOST_UM || larics_abs(right_um) > MOST_UM) return 0;
    if (track_mm < 10 || track_mm > 5000 || larics_abs(difference) > MOST_UM) return 0;
    sum = difference * 7162 + wheels->rest_turn; /* 57.296 mdeg for each um on a track of 1 mm */
    turn_mdeg = larics_floor_div(sum, unit);
    if (!larics_wheels_move(wheels, forward_um, turn_mdeg, now_us)) return 0;
    wheels->rest_way = (uint8_t)(both_um - 2 * forward_um);
    wheels->rest_turn = sum - turn_mdeg * unit;
    wheels->is_standing = left_um == 0 && right_um == 0;
    return 1;
}

size_t larics_wheels_message(const larics_wheels *wheels, uint32_t now_us, uint16_t *sequence,
                             uint8_t frame[LARICS_MAX_FRAME])
{
    larics_message message;
    size_t size;
    larics_set_odometry(&message, wheels->sampled_us, now_us, wheels->x_mm10, wheels->y_mm10,
                        wheels->heading_mdeg / 10, wheels->epoch);
    if (wheels->is_slipping) message.as.odometry.flags |= LARICS_ODOMETRY_SLIP;
    if (wheels->is_standing) message.as.odometry.flags |= LARICS_ODOMETRY_STANDING;
    size = larics_encode(&message, *sequence, frame);
    *sequence = (uint16_t)(*sequence + 1u);
    return size;
}
