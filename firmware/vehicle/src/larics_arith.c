#include "larics_arith.h"

#include "larics_flash.h"
#include "larics_tables.h"

#define QUARTER 16384

int32_t larics_floor_div(int32_t a, int32_t b)
{
    int32_t quotient = a / b;
    return a % b < 0 ? quotient - 1 : quotient;
}

int32_t larics_floor_mod(int32_t a, int32_t b)
{
    int32_t rest = a % b;
    return rest < 0 ? rest + b : rest;
}

int32_t larics_floor_shift(int32_t value, uint8_t bits)
{
    return value < 0 ? ~(~value >> bits) : value >> bits;
}

int32_t larics_abs(int32_t value)
{
    return value < 0 ? -value : value;
}

int32_t larics_clamp(int32_t value, int32_t limit)
{
    if (value > limit) return limit;
    return value < -limit ? -limit : value;
}

static int32_t entry(const uint16_t *table, int32_t index)
{
    return (int32_t)larics_flash_u16(&table[index]);
}

int32_t larics_sin_q14(int32_t angle_turn16)
{
    int32_t angle = (int32_t)((uint32_t)angle_turn16 & 65535u), sign = 1, index, rest, value;
    if (angle >= 32768) {
        angle -= 32768;
        sign = -1;
    }
    if (angle > QUARTER) angle = 32768 - angle;
    index = angle >> 6;
    rest = angle & 63;
    value = entry(larics_quarter_sine_q14, index);
    if (rest)
        value += larics_floor_shift((entry(larics_quarter_sine_q14, index + 1) - value) * rest + 32, 6);
    return sign * value;
}

int32_t larics_cos_q14(int32_t angle_turn16)
{
    return larics_sin_q14(angle_turn16 + QUARTER);
}

int32_t larics_atan2_turn16(int32_t y, int32_t x)
{
    int32_t ax = larics_abs(x), ay = larics_abs(y);
    int32_t small = ay > ax ? ax : ay, large = ay > ax ? ay : ax, index, rest, angle;
    uint32_t quotient;
    if (large == 0) return 0;
    while (large >= 16384) {
        small >>= 1;
        large >>= 1;
    }
    quotient = (((uint32_t)small << 16) + ((uint32_t)large >> 1)) / (uint32_t)large;
    index = (int32_t)(quotient >> 8);
    rest = (int32_t)(quotient & 255u);
    angle = entry(larics_arctan, index);
    if (rest) angle += ((entry(larics_arctan, index + 1) - angle) * rest + 128) >> 8;
    angle = (angle + 2) >> 2;
    if (ay > ax) angle = QUARTER - angle;
    if (x < 0) angle = 32768 - angle;
    return (int32_t)((uint32_t)(y < 0 ? -angle : angle) & 65535u);
}

uint32_t larics_isqrt(uint32_t value)
{
    uint32_t root = 0, bit = (uint32_t)1 << 30;
    while (bit > value) bit >>= 2;
    for (; bit; bit >>= 2) {
        if (value >= root + bit) {
            value -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return root;
}

int32_t larics_cdeg_from_turn16(int32_t angle_turn16)
{
    return ((int32_t)((uint32_t)angle_turn16 & 65535u) * 1125 + 1024) / 2048 % 36000;
}

int32_t larics_turn16_from_cdeg(int32_t angle_cdeg)
{
    int32_t turn16 = (larics_floor_mod(angle_cdeg, 36000) * 2048 + 562) / 1125;
    return (int32_t)((uint32_t)turn16 & 65535u);
}

int32_t larics_wrap_cdeg(int32_t angle_cdeg)
{
    return larics_floor_mod(angle_cdeg + 18000, 36000) - 18000;
}
