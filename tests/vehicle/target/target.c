/* A stream through decoder, supervisor and drive on a target: what comes out as one CRC, and what it costs.
 * Compiled with one of the platforms beside it, and with stream.h made by tools/vehicle_targets.py. */
#include <string.h>

#include "larics_commands.h"
#include "larics_drive.h"
#include "larics_flash.h"
#include "larics_map.h"
#include "larics_route.h"
#include "larics_supervisor.h"
#include "larics_wheels.h"
#include "platform.h"
#include "stream.h"

static larics_decoder decoder;
static larics_supervisor camera;
static larics_drive drive;
static larics_wheels wheels;
static uint32_t crc = 0xFFFFFFFFu;

static void add(const void *data, size_t count)
{
    const uint8_t *bytes = data;
    while (count--) {
        crc ^= *bytes++;
        for (uint8_t bit = 0; bit < 8; bit++) crc = crc & 1u ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
    }
}

/* A number in the same order of bytes everywhere. */
static void add_number(int32_t value)
{
    uint32_t bits = (uint32_t)value;
    for (uint8_t k = 0; k < 4; k++) {
        uint8_t byte = (uint8_t)(bits >> (8 * k));
        add(&byte, 1);
    }
}

static void print_number(const char *name, uint32_t value)
{
    char digits[11], *place = digits + sizeof digits - 1;
    *place = 0;
    do {
        *--place = (char)('0' + value % 10u);
        value /= 10u;
    } while (value);
    platform_print(name);
    platform_print("=");
    platform_print(place);
    platform_print("\n");
}

/* Everything once, for the CRC of what comes out. */
static void check(void)
{
    static const uint16_t ids[] = {3, 4, 5, 4, 3};
    static const larics_map_marker map[] = {{4, -900000, 5}, {3, 0, 0}, {5, 4000, -9}, {4, 2000, 0}, {3, 1, 3000}};
    static uint16_t workspace[10];
    static uint32_t costs[5];
    larics_limits limits;
    larics_route route;
    uint8_t frame[LARICS_MAX_FRAME];
    uint16_t sequence = 0;
    uint32_t now = 0xFFFFF000u;
    larics_limits_usual(&limits, 115200);
    limits.challenge_ms = 300;
    larics_decoder_init(&decoder);
    larics_supervisor_init(&camera, &limits, now, 1234567u);
    larics_drive_init(&drive, NULL);
    larics_wheels_init(&wheels, 99u);
    add_number(larics_map_resolve(map, 5, ids, 5, workspace, costs));
    for (uint8_t k = 0; k < 5; k++) add_number(workspace[k]);
    larics_route_init(&route, ids, 5, -1, workspace);
    for (uint32_t k = 0; k < STREAM_BYTES; k++) {
        size_t size;
        if (!larics_decode(&decoder, larics_flash_u8(&stream[k]))) continue;
        now += 10;
        larics_begin_drain(&camera, now);
        size = larics_encode(&decoder.message, decoder.message.sequence, frame);
        add(frame, size);
        add_number(larics_supervise(&camera, &decoder.message));
        larics_drive_take(&drive, &decoder.message);
        larics_drive_step(&drive, 10);
        add_number(drive.state);
        add_number(drive.speed_mm_s);
        add_number(drive.turn_cdeg_s);
        add_number(larics_marker_state(&camera, now));
        add_number((int32_t)larics_marker_age_ms(&camera, now));
        add_number(larics_pose_state(&camera, now));
        add_number(camera.choice.has_target ? (int32_t)camera.choice.target.id : -1);
        if (decoder.message.type == LARICS_MARKER)
            add_number(larics_route_see(&route, decoder.message.as.marker.id));
        larics_wheels_roll(&wheels, drive.speed_mm_s * 10 - drive.turn_cdeg_s / 4,
                           drive.speed_mm_s * 10 + drive.turn_cdeg_s / 4, 300, now * 1000u);
        size = larics_wheels_message(&wheels, now * 1000u, &sequence, frame);
        add(frame, size);
        size = larics_challenge(&camera, now, &sequence, frame);
        add(frame, size);
    }
    print_number("crc", ~crc);
    print_number("messages", decoder.counters.messages);
}

/* The same without sums over it, timed call by call. */
static void measure(void)
{
    uint32_t decode = 0, decode_most = 0, take = 0, take_most = 0, step = 0, step_most = 0, state = 0;
    uint32_t start, spent, idle, messages = 0;
    larics_limits limits;
    idle = 0; /* what 256 readings of the clock take: one alone may fall between two ticks */
    for (uint16_t k = 0; k < 256; k++) {
        start = platform_cycles();
        idle += platform_cycles() - start;
    }
    larics_limits_usual(&limits, 115200);
    larics_decoder_init(&decoder);
    larics_supervisor_init(&camera, &limits, 0, 1);
    larics_drive_init(&drive, NULL);
    for (uint32_t k = 0; k < STREAM_BYTES; k++) {
        uint8_t byte = larics_flash_u8(&stream[k]);
        int is_new;
        start = platform_cycles();
        is_new = larics_decode(&decoder, byte);
        spent = platform_cycles() - start;
        decode += spent;
        if (spent > decode_most) decode_most = spent;
        if (!is_new) continue;
        messages++;
        larics_begin_drain(&camera, messages * 10u);
        start = platform_cycles();
        larics_supervise(&camera, &decoder.message);
        spent = platform_cycles() - start;
        take += spent;
        if (spent > take_most) take_most = spent;
        start = platform_cycles();
        drive.is_held = (uint8_t)!larics_may_search(&camera, messages * 10u);
        state += platform_cycles() - start;
        larics_drive_take(&drive, &decoder.message);
        start = platform_cycles();
        larics_drive_step(&drive, 10);
        spent = platform_cycles() - start;
        step += spent;
        if (spent > step_most) step_most = spent;
    }
    print_number("byte", decode / STREAM_BYTES - idle / 256u);
    print_number("last_byte_of_a_frame_most", decode_most - idle / 256u);
    print_number("supervise", take / messages - idle / 256u);
    print_number("supervise_most", take_most - idle / 256u);
    print_number("state", state / messages - idle / 256u);
    print_number("step", step / messages - idle / 256u);
    print_number("step_most", step_most - idle / 256u);
}

int main(void)
{
    platform_start();
    check();
    measure();
    print_number("ram_decoder", sizeof(larics_decoder));
    print_number("ram_supervisor", sizeof(larics_supervisor));
    print_number("ram_drive", sizeof(larics_drive));
    print_number("ram_wheels", sizeof(larics_wheels));
    print_number("ram_commands", sizeof(larics_commands));
    print_number("ram_route", sizeof(larics_route));
    print_number("stack", platform_stack());
    platform_end();
    return 0;
}
