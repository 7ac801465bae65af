/* What the tests of commands and wheels call of the library through ctypes: no structures, only numbers. */
#include "larics_commands.h"
#include "larics_map.h"
#include "larics_wheels.h"

static larics_commands commands;
static larics_decoder decoder;
static larics_wheels wheels;
static larics_info info;
static int32_t numbers[600], asked[600];
static uint16_t sequence;

void parts_init(uint32_t seed)
{
    larics_commands_init(&commands, seed);
    larics_decoder_init(&decoder);
    larics_wheels_init(&wheels, seed);
}

int parts_begin(int type, int key, int count, const int32_t *values)
{
    for (int k = 0; k < count && values; k++) asked[k] = values[k];
    switch (type) {
    case LARICS_PING:
        return larics_ping_camera(&commands);
    case LARICS_GET_INFO:
        return larics_get_info_of(&commands, &info);
    case LARICS_GET_SETTING:
        return larics_get_setting_of(&commands, (uint8_t)key, numbers, (uint16_t)count);
    case LARICS_SET_SETTING:
        return larics_set_setting_of(&commands, (uint8_t)key, asked, (uint16_t)count);
    case LARICS_SAVE_SETTINGS:
        return larics_save_settings_of(&commands);
    default:
        return larics_restart_camera(&commands, (uint16_t)key);
    }
}

void parts_receive(const uint8_t *bytes, size_t count)
{
    while (count--)
        if (larics_decode(&decoder, *bytes++)) larics_commands_take(&commands, &decoder.message);
}

size_t parts_poll(uint32_t now_ms, uint8_t frame[LARICS_MAX_FRAME])
{
    return larics_commands_poll(&commands, now_ms, &sequence, frame);
}

void parts_cancel(void)
{
    larics_commands_cancel(&commands);
}

/* told: state, reason, detail, count, boot of the INFO */
void parts_told(int32_t told[5], int32_t values[600])
{
    told[0] = commands.state;
    told[1] = commands.reason;
    told[2] = commands.detail;
    told[3] = commands.count;
    told[4] = info.boot;
    for (int k = 0; k < 600; k++) values[k] = numbers[k];
}

int parts_roll(int32_t left_um, int32_t right_um, int track_mm, uint32_t now_us)
{
    return larics_wheels_roll(&wheels, left_um, right_um, (uint16_t)track_mm, now_us);
}

int parts_move(int32_t forward_um, int32_t turn_mcdeg, uint32_t now_us)
{
    return larics_wheels_move(&wheels, forward_um, turn_mcdeg, now_us);
}

void parts_place(int32_t x_mm10, int is_slipping)
{
    wheels.x_mm10 = x_mm10;
    wheels.is_slipping = (uint8_t)is_slipping;
}

/* told: x, y, heading in 1/1000 of 0.01 degree, epoch, whether it stands */
void parts_wheels(int32_t told[5])
{
    told[0] = wheels.x_mm10;
    told[1] = wheels.y_mm10;
    told[2] = wheels.heading_mcdeg;
    told[3] = wheels.epoch;
    told[4] = wheels.is_standing;
}

void parts_reset(void)
{
    larics_wheels_reset(&wheels);
}

size_t parts_odometry(uint32_t now_us, uint8_t frame[LARICS_MAX_FRAME])
{
    return larics_wheels_message(&wheels, now_us, &sequence, frame);
}

int parts_sequence(void)
{
    return sequence;
}

/* rows: ID, x, y of each marker of the map */
int parts_resolve(const int32_t *rows, int map_count, const uint16_t *ids, int id_count, uint16_t *entries)
{
    static larics_map_marker map[64];
    static uint32_t workspace[64];
    for (int k = 0; k < map_count; k++) {
        map[k].id = (uint16_t)rows[3 * k];
        map[k].x_mm = rows[3 * k + 1];
        map[k].y_mm = rows[3 * k + 2];
    }
    return larics_map_resolve(map, (uint16_t)map_count, ids, (uint16_t)id_count, entries, workspace);
}
