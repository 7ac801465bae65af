/* Angles, roots and floors in integers, private to the library: the same results as larics.arith.fixed.
 * An angle is in 1/65536 turn (turn16, 0..65535) or hundredths of a degree (cdeg), counterclockwise. */
#ifndef LARICS_ARITH_H
#define LARICS_ARITH_H

#include <stdint.h>

/* Division that rounds down; b > 0. */
int32_t larics_floor_div(int32_t a, int32_t b);

/* 0..b-1; b > 0 */
int32_t larics_floor_mod(int32_t a, int32_t b);

/* value / 2**bits, rounded down */
int32_t larics_floor_shift(int32_t value, uint8_t bits);

int32_t larics_abs(int32_t value);

/* value, or what is next to it within -limit..limit */
int32_t larics_clamp(int32_t value, int32_t limit);

/* Of any angle, times 2**14. */
int32_t larics_sin_q14(int32_t angle_turn16);
int32_t larics_cos_q14(int32_t angle_turn16);

/* 0..65535, 0 for the null vector; |x|, |y| < 2**22 */
int32_t larics_atan2_turn16(int32_t y, int32_t x);

/* Floor of the square root. */
uint32_t larics_isqrt(uint32_t value);

/* 0..35999, rounded */
int32_t larics_cdeg_from_turn16(int32_t angle_turn16);

/* 0..65535, rounded */
int32_t larics_turn16_from_cdeg(int32_t angle_cdeg);

/* -18000..17999 */
int32_t larics_wrap_cdeg(int32_t angle_cdeg);

#endif
