#include "larics_layout.h"

#include <string.h>

#include "larics_flash.h"

/* How a field is on the wire. U30 and I30 take 32 bits and use 30; any larger number is that of bytes. */
enum { U8, U16, I16, U30, I30, RANGED = 0x80 };

typedef struct {
    uint8_t kind;   /* with RANGED when `ranges` has a line for it */
    uint8_t offset; /* in its structure */
} field;

/* Of fields that may hold less than their kind. */
typedef struct {
    uint8_t field; /* in `fields` */
    int32_t low;
    int32_t high;
} range;

/* generated: begin (tools/make_protocol.py) */
static const field fields[] LARICS_IN_FLASH = {
    {U16, offsetof(larics_info, token)},
    {U16, offsetof(larics_info, boot)},
    {U8, offsetof(larics_info, version_major)},
    {U8, offsetof(larics_info, version_minor)},
    {U8, offsetof(larics_info, version_patch)},
    {U16, offsetof(larics_info, width)},
    {U16, offsetof(larics_info, height)},
    {U8, offsetof(larics_info, settings)},
    {16, offsetof(larics_info, board)},
    {12, offsetof(larics_info, unique_id)},
    {U30, offsetof(larics_marker, frame)},
    {U30, offsetof(larics_marker, age_us)},
    {U16, offsetof(larics_marker, flags)},
    {U16, offsetof(larics_marker, id)},
    {U8 | RANGED, offsetof(larics_marker, index)},
    {U8, offsetof(larics_marker, count)},
    {I30 | RANGED, offsetof(larics_marker, x_mm10)},
    {I30 | RANGED, offsetof(larics_marker, y_mm10)},
    {I30 | RANGED, offsetof(larics_marker, z_mm10)},
    {U16 | RANGED, offsetof(larics_marker, heading_cdeg)},
    {U8, offsetof(larics_marker, margin)},
    {U16, offsetof(larics_marker, radius_q8)},
    {U16, offsetof(larics_marker, sigma_q12)},
    {U16, offsetof(larics_marker, sigma_mdeg)},
    {U30, offsetof(larics_pose, frame)},
    {U30, offsetof(larics_pose, age_us)},
    {U16, offsetof(larics_pose, marker_age_ms)},
    {U8 | RANGED, offsetof(larics_pose, state)},
    {U16, offsetof(larics_pose, id)},
    {I30, offsetof(larics_pose, x_mm10)},
    {I30, offsetof(larics_pose, y_mm10)},
    {U16 | RANGED, offsetof(larics_pose, heading_cdeg)},
    {U16, offsetof(larics_pose, sigma_x_mm10)},
    {U16, offsetof(larics_pose, sigma_y_mm10)},
    {I16 | RANGED, offsetof(larics_pose, correlation_q14)},
    {U16, offsetof(larics_pose, sigma_cdeg)},
    {U16, offsetof(larics_pose, way_mm)},
    {U16, offsetof(larics_pose, route_position)},
    {U16 | RANGED, offsetof(larics_pose, next_cdeg)},
    {U8, offsetof(larics_status, version_major)},
    {U8, offsetof(larics_status, version_minor)},
    {U8, offsetof(larics_status, version_patch)},
    {U16, offsetof(larics_status, boot)},
    {U30, offsetof(larics_status, uptime_s)},
    {U30, offsetof(larics_status, frames)},
    {U30, offsetof(larics_status, missed)},
    {U30, offsetof(larics_status, detections)},
    {U30, offsetof(larics_status, rejects)},
    {U30, offsetof(larics_status, drops)},
    {U30, offsetof(larics_status, crc_errors)},
    {U30, offsetof(larics_status, line_errors)},
    {U30, offsetof(larics_status, faults)},
    {U8, offsetof(larics_status, last_fault)},
    {U30, offsetof(larics_status, active_faults)},
    {U8 | RANGED, offsetof(larics_status, state)},
    {U30, offsetof(larics_status, exposure_us)},
    {U16, offsetof(larics_status, gain_cdb)},
    {U16, offsetof(larics_status, grey_mean)},
    {U16, offsetof(larics_status, rate_chz)},
    {U30, offsetof(larics_status, frame_us)},
    {U30, offsetof(larics_status, detect_us)},
    {U30, offsetof(larics_status, latency_us)},
    {U30, offsetof(larics_status, free_bytes)},
    {U30, offsetof(larics_status, unanswered)},
    {U30, offsetof(larics_status, clamped)},
    {U30, offsetof(larics_status, odometry_used)},
    {U30, offsetof(larics_status, odometry_refused)},
    {U30, offsetof(larics_status, odometry_stale)},
    {U30, offsetof(larics_status, odometry_jumps)},
    {U16, offsetof(larics_ack, token)},
    {U8, offsetof(larics_ack, command)},
    {U16, offsetof(larics_nack, token)},
    {U8, offsetof(larics_nack, command)},
    {U8, offsetof(larics_nack, reason)},
    {U8, offsetof(larics_nack, detail)},
    {U16, offsetof(larics_setting, token)},
    {U8, offsetof(larics_setting, key)},
    {U16, offsetof(larics_setting, first)},
    {U16, offsetof(larics_setting, count)},
    {I30, offsetof(larics_setting, value[0])},
    {I30, offsetof(larics_setting, value[1])},
    {I30, offsetof(larics_setting, value[2])},
    {I30, offsetof(larics_setting, value[3])},
    {I30, offsetof(larics_setting, value[4])},
    {I30, offsetof(larics_setting, value[5])},
    {I30, offsetof(larics_setting, value[6])},
    {I30, offsetof(larics_setting, value[7])},
    {U16, offsetof(larics_raw_header, token)},
    {U30, offsetof(larics_raw_header, frame)},
    {U16 | RANGED, offsetof(larics_raw_header, width)},
    {U16 | RANGED, offsetof(larics_raw_header, height)},
    {U16, offsetof(larics_raw_header, left)},
    {U16, offsetof(larics_raw_header, top)},
    {U16 | RANGED, offsetof(larics_raw_header, columns)},
    {U16 | RANGED, offsetof(larics_raw_header, rows)},
    {U16, offsetof(larics_raw_header, crc_low)},
    {U16, offsetof(larics_raw_header, crc_high)},
    {U16, offsetof(larics_raw_chunk, token)},
    {U30, offsetof(larics_raw_chunk, first)},
    {U16 | RANGED, offsetof(larics_raw_chunk, count)},
    {U8 | RANGED, offsetof(larics_raw_chunk, coding)},
    {64, offsetof(larics_raw_chunk, data)},
    {U30, offsetof(larics_motion, frame)},
    {U8 | RANGED, offsetof(larics_motion, state)},
    {U8, offsetof(larics_motion, epoch)},
    {I30 | RANGED, offsetof(larics_motion, x_mm10)},
    {I30 | RANGED, offsetof(larics_motion, y_mm10)},
    {U16 | RANGED, offsetof(larics_motion, heading_cdeg)},
    {U30, offsetof(larics_motion, way_mm10)},
    {U30, offsetof(larics_motion, turn_cdeg)},
    {U30, offsetof(larics_motion, odometry_age_us)},
    {U16, offsetof(larics_get_info, token)},
    {U16, offsetof(larics_ping, token)},
    {U16, offsetof(larics_get_setting, token)},
    {U8, offsetof(larics_get_setting, key)},
    {U16, offsetof(larics_set_setting, token)},
    {U8, offsetof(larics_set_setting, key)},
    {U16, offsetof(larics_set_setting, first)},
    {U16, offsetof(larics_set_setting, count)},
    {I30, offsetof(larics_set_setting, value[0])},
    {I30, offsetof(larics_set_setting, value[1])},
    {I30, offsetof(larics_set_setting, value[2])},
    {I30, offsetof(larics_set_setting, value[3])},
    {I30, offsetof(larics_set_setting, value[4])},
    {I30, offsetof(larics_set_setting, value[5])},
    {I30, offsetof(larics_set_setting, value[6])},
    {I30, offsetof(larics_set_setting, value[7])},
    {U16, offsetof(larics_save_settings, token)},
    {U16, offsetof(larics_get_raw, token)},
    {U8 | RANGED, offsetof(larics_get_raw, window)},
    {U16, offsetof(larics_get_raw_again, token)},
    {U16, offsetof(larics_get_raw_again, transfer)},
    {U30, offsetof(larics_get_raw_again, first)},
    {U30 | RANGED, offsetof(larics_get_raw_again, count)},
    {U16, offsetof(larics_restart, token)},
    {U16, offsetof(larics_restart, boot)},
    {U30, offsetof(larics_odometry, time_us)},
    {U30, offsetof(larics_odometry, age_us)},
    {I30 | RANGED, offsetof(larics_odometry, x_mm10)},
    {I30 | RANGED, offsetof(larics_odometry, y_mm10)},
    {U16 | RANGED, offsetof(larics_odometry, heading_cdeg)},
    {U8, offsetof(larics_odometry, epoch)},
    {U8, offsetof(larics_odometry, flags)},
};

static const larics_layout layouts[] LARICS_IN_FLASH = {
    {LARICS_INFO, 0, 10, 40},
    {LARICS_MARKER, 10, 14, 35},
    {LARICS_POSE, 24, 15, 37},
    {LARICS_STATUS, 39, 30, 97},
    {LARICS_ACK, 69, 2, 3},
    {LARICS_NACK, 71, 4, 5},
    {LARICS_SETTING, 75, 12, 39},
    {LARICS_RAW_HEADER, 87, 10, 22},
    {LARICS_RAW_CHUNK, 97, 5, 73},
    {LARICS_MOTION, 102, 9, 28},
    {LARICS_GET_INFO, 111, 1, 2},
    {LARICS_PING, 112, 1, 2},
    {LARICS_GET_SETTING, 113, 2, 3},
    {LARICS_SET_SETTING, 115, 12, 39},
    {LARICS_SAVE_SETTINGS, 127, 1, 2},
    {LARICS_GET_RAW, 128, 2, 3},
    {LARICS_GET_RAW_AGAIN, 130, 4, 12},
    {LARICS_RESTART, 134, 2, 4},
    {LARICS_ODOMETRY, 136, 7, 20},
};

static const range ranges[] LARICS_IN_FLASH = {
    {14, 0, 254}, /* MARKER.index */
    {16, -1000000, 1000000}, /* MARKER.x_mm10 */
    {17, -1000000, 1000000}, /* MARKER.y_mm10 */
    {18, -1000000, 1000000}, /* MARKER.z_mm10 */
    {19, 0, 35999}, /* MARKER.heading_cdeg */
    {27, 0, 3}, /* POSE.state */
    {31, 0, 36000}, /* POSE.heading_cdeg */
    {34, -16384, 16384}, /* POSE.correlation_q14 */
    {38, 0, 36000}, /* POSE.next_cdeg */
    {54, 0, 3}, /* STATUS.state */
    {89, 1, 65535}, /* RAW_HEADER.width */
    {90, 1, 65535}, /* RAW_HEADER.height */
    {93, 1, 65535}, /* RAW_HEADER.columns */
    {94, 1, 65535}, /* RAW_HEADER.rows */
    {99, 1, 505}, /* RAW_CHUNK.count */
    {100, 0, 8}, /* RAW_CHUNK.coding */
    {103, 0, 2}, /* MOTION.state */
    {105, -536870911, 536870911}, /* MOTION.x_mm10 */
    {106, -536870911, 536870911}, /* MOTION.y_mm10 */
    {107, 0, 35999}, /* MOTION.heading_cdeg */
    {129, 0, 1}, /* GET_RAW.window */
    {133, 1, 1073741823}, /* GET_RAW_AGAIN.count */
    {138, -536870911, 536870911}, /* ODOMETRY.x_mm10 */
    {139, -536870911, 536870911}, /* ODOMETRY.y_mm10 */
    {140, 0, 35999}, /* ODOMETRY.heading_cdeg */
};
/* generated: end */

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

int larics_layout_find(uint8_t type, larics_layout *found)
{
    for (size_t k = 0; k < COUNT_OF(layouts); k++)
        if (larics_flash_u8(&layouts[k].type) == type) {
            found->type = type;
            found->first = larics_flash_u8(&layouts[k].first);
            found->count = larics_flash_u8(&layouts[k].count);
            found->size = larics_flash_u8(&layouts[k].size);
            return 1;
        }
    return 0;
}

static uint32_t get32(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

void larics_put32(uint8_t *bytes, uint32_t value)
{
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
    bytes[2] = (uint8_t)(value >> 16);
    bytes[3] = (uint8_t)(value >> 24);
}

static int is_in_range(size_t index, uint8_t kind, int32_t value)
{
    int32_t high = (int32_t)LARICS_COUNT_MAX;
    int32_t low = (kind & ~(unsigned)RANGED) == I30 ? -high : 0;
    if (kind & RANGED)
        for (size_t k = 0; k < COUNT_OF(ranges); k++)
            if (larics_flash_u8(&ranges[k].field) == index) {
                low = larics_flash_i32(&ranges[k].low);
                high = larics_flash_i32(&ranges[k].high);
                break;
            }
    return low <= value && value <= high;
}

int larics_unpack(const larics_layout *type, const uint8_t *wire, uint8_t *to)
{
    for (size_t k = type->first; k < (size_t)type->first + type->count; k++) {
        uint8_t *place = to + larics_flash_u8(&fields[k].offset);
        uint8_t marked = larics_flash_u8(&fields[k].kind);
        uint8_t kind = marked & (uint8_t)~RANGED;
        uint32_t bits = wire[0];
        int32_t value;
        if (kind > I30) {
            memcpy(place, wire, kind);
            wire += kind;
            continue;
        }
        if (kind == U16 || kind == I16) bits |= (uint32_t)wire[1] << 8;
        if (kind == I16 && bits & 0x8000u) bits |= 0xFFFF0000u;
        if (kind >= U30) bits = get32(wire);
        value = bits & 0x80000000u ? -(int32_t)(~bits) - 1 : (int32_t)bits;
        if (!is_in_range(k, marked, value)) return 0;
        if (kind == U8) {
            *place = (uint8_t)bits;
            wire += 1;
        } else if (kind == U16 || kind == I16) {
            uint16_t half = (uint16_t)bits;
            memcpy(place, &half, 2);
            wire += 2;
        } else {
            memcpy(place, &value, 4); /* int32_t and uint32_t alike: the value is within 30 bits */
            wire += 4;
        }
    }
    return 1;
}

int larics_pack(const larics_layout *type, const uint8_t *from, uint8_t *wire)
{
    for (size_t k = type->first; k < (size_t)type->first + type->count; k++) {
        const uint8_t *place = from + larics_flash_u8(&fields[k].offset);
        uint8_t marked = larics_flash_u8(&fields[k].kind);
        uint8_t kind = marked & (uint8_t)~RANGED;
        uint32_t bits;
        int32_t value;
        if (kind > I30) {
            memcpy(wire, place, kind);
            wire += kind;
            continue;
        }
        if (kind == U8) {
            value = *place;
        } else if (kind == U16 || kind == I16) {
            uint16_t half;
            memcpy(&half, place, 2);
            value = kind == I16 && half & 0x8000u ? (int32_t)half - 0x10000 : half;
        } else {
            memcpy(&value, place, 4);
        }
        if (!is_in_range(k, marked, value)) return 0;
        bits = (uint32_t)value;
        if (kind >= U30) {
            larics_put32(wire, bits);
            wire += 4;
        } else {
            *wire++ = (uint8_t)bits;
            if (kind != U8) *wire++ = (uint8_t)(bits >> 8);
        }
    }
    return 1;
}
