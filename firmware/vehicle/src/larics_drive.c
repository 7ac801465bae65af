#include "larics_drive.h"

#include <string.h>

#include "larics_arith.h"

#define NEVER_MS 1000000
#define TURN_GAIN 3         /* 1/s: turn rate for an error in direction */
#define AHEAD_CDEG 3000     /* drives only when what it drives to is within this of straight ahead */
#define CROSS_CDEG_PER_MM 20 /* how sharply GO steers back to its line ... */
#define CROSS_MOST_CDEG 2500 /* ... and at most */
#define LEFT_BEHIND_MM 400   /* GO takes the marker it left for a new one only so far on its way */
#define SAME_PLACE_MM10 3000 /* two markers never hang so near to each other */
#define SPIRAL_START_MM 200
#define SPIRAL_PITCH_MM 254 /* per turn, divided by pi: 800 mm from one turn to the next */

static int32_t smaller(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t larger(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

void larics_drive_limits_usual(larics_drive_limits *limits)
{
    limits->speed_mm_s = 200;
    limits->turn_cdeg_s = 6000;
    limits->accel_mm_s2 = 400;
    limits->turn_accel_cdeg_s2 = 18000;
    limits->stale_ms = 500;
    limits->center_mm10 = 300;
    limits->align_cdeg = 150;
    limits->leg_mm = 6000;
}

static int is_within(int32_t value, int32_t high)
{
    return 1 <= value && value <= high;
}

static int are_possible(const larics_drive_limits *limits)
{
    return is_within(limits->speed_mm_s, 20000) && is_within(limits->turn_cdeg_s, 100000) &&
           is_within(limits->accel_mm_s2, 50000) && is_within(limits->turn_accel_cdeg_s2, 1000000) &&
           is_within(limits->stale_ms, 10000) && is_within(limits->center_mm10, 100000) &&
           is_within(limits->align_cdeg, 18000) && is_within(limits->leg_mm, 1000000);
}

static void forget(larics_sight *sight)
{
    memset(sight, 0, sizeof *sight);
    sight->id = LARICS_ID_NONE;
    sight->age_ms = NEVER_MS;
}

int larics_drive_init(larics_drive *drive, const larics_drive_limits *limits)
{
    memset(drive, 0, sizeof *drive);
    if (limits)
        drive->limits = *limits;
    else
        larics_drive_limits_usual(&drive->limits);
    drive->left_id = LARICS_ID_NONE;
    forget(&drive->target);
    forget(&drive->behind);
    drive->next_ms = drive->silent_ms = NEVER_MS;
    drive->state = LARICS_SEARCH;
    if (are_possible(&drive->limits)) return 1;
    larics_drive_limits_usual(&drive->limits);
    drive->is_stopped = 1;
    drive->state = LARICS_HALT;
    return 0;
}

/* Where a marker is after the commanded motion of that time. */
static void carry(const larics_drive *drive, larics_sight *sight, int32_t elapsed_ms)
{
    int32_t turned_cdeg = larics_floor_div(drive->turn_cdeg_s * elapsed_ms, 1000);
    int32_t turn16, sin, cos, x, y;
    sight->age_ms = smaller(NEVER_MS, sight->age_ms + elapsed_ms);
    if (sight->age_ms > 10000) return;
    turn16 = larics_turn16_from_cdeg(turned_cdeg);
    sin = larics_sin_q14(turn16);
    cos = larics_cos_q14(turn16);
    x = sight->x_mm10 - larics_floor_div(drive->speed_mm_s * elapsed_ms, 100);
    x = larics_floor_shift(larics_clamp(x, 120000), 2);
    y = larics_floor_shift(larics_clamp(sight->y_mm10, 120000), 2);
    sight->x_mm10 = larics_floor_shift(x * cos + y * sin, 12);
    sight->y_mm10 = larics_floor_shift(y * cos - x * sin, 12);
    sight->heading_cdeg = larics_floor_mod(sight->heading_cdeg - turned_cdeg, 36000);
}

/* Whether this is the marker that GO has just left: once out of view, it counts as any other. */
static int is_behind(const larics_drive *drive, uint16_t id)
{
    if (drive->state != LARICS_GO || id != drive->left_id) return 0;
    return drive->way_um < LEFT_BEHIND_MM * 1000L || drive->behind.age_ms <= drive->limits.stale_ms;
}

/* Whether this is the marker that GO has just left, read with another ID as the border cuts it. */
static int is_misread(const larics_drive *drive, const larics_marker *marker)
{
    const larics_sight *behind = &drive->behind;
    if (drive->state != LARICS_GO || marker->id == drive->left_id) return 0;
    if (behind->age_ms > 4 * drive->limits.stale_ms) return 0;
    return larger(larics_abs(marker->x_mm10 - behind->x_mm10), larics_abs(marker->y_mm10 - behind->y_mm10)) <
           SAME_PLACE_MM10;
}

/* Whether to turn to this marker: none yet, the same one, or a nearer one while none is reached. */
static int is_better(const larics_drive *drive, uint16_t id, int32_t distance)
{
    const larics_sight *target = &drive->target;
    if (target->age_ms > drive->limits.stale_ms || target->id == id) return 1;
    return drive->state != LARICS_ALIGN &&
           distance * 2 < larics_abs(target->x_mm10) + larics_abs(target->y_mm10);
}

static void take_marker(larics_drive *drive, const larics_marker *marker)
{
    int32_t age_ms = smaller((int32_t)(marker->age_us / 1000u), 10000);
    larics_sight *sight;
    drive->frame_ms = age_ms;
    if ((marker->flags & (LARICS_MARKER_NONE | LARICS_MARKER_NO_OFFSET)) || marker->id == LARICS_ID_NONE)
        return;
    if (is_misread(drive, marker)) return;
    if (is_behind(drive, marker->id))
        sight = &drive->behind;
    else if (is_better(drive, marker->id, larics_abs(marker->x_mm10) + larics_abs(marker->y_mm10)))
        sight = &drive->target;
    else
        return;
    sight->id = marker->id;
    sight->x_mm10 = larics_clamp(marker->x_mm10, 100000);
    sight->y_mm10 = larics_clamp(marker->y_mm10, 100000);
    sight->heading_cdeg = marker->heading_cdeg;
    sight->age_ms = 0;
    carry(drive, sight, age_ms);
}

static void take_pose(larics_drive *drive, const larics_pose *pose)
{
    drive->is_carried = pose->state == LARICS_CARRIED && pose->next_cdeg != LARICS_DIRECTION_NONE;
    if (pose->state == LARICS_TRACKING)
        drive->is_end = pose->route_position != LARICS_ROUTE_NONE && pose->next_cdeg == LARICS_DIRECTION_NONE;
    else if (!drive->is_carried)
        return; /* what is predicted without odometry is not steered by: the wheels know better */
    if (pose->next_cdeg != LARICS_DIRECTION_NONE) {
        int32_t turned_cdeg = larics_floor_div(drive->turn_cdeg_s * drive->frame_ms, 1000);
        drive->next_cdeg = larics_wrap_cdeg((int32_t)pose->next_cdeg - turned_cdeg);
        drive->next_ms = 0;
    }
}

void larics_drive_take(larics_drive *drive, const larics_message *message)
{
    drive->silent_ms = 0;
    if (message->type == LARICS_MARKER)
        take_marker(drive, &message->as.marker);
    else if (message->type == LARICS_POSE)
        take_pose(drive, &message->as.pose);
}

static void enter(larics_drive *drive, uint8_t state)
{
    if (state == drive->state) return;
    drive->state = state;
    drive->way_um = 0;
}

void larics_drive_stop(larics_drive *drive)
{
    drive->is_stopped = 1;
}

void larics_drive_start(larics_drive *drive)
{
    drive->is_stopped = 0;
    enter(drive, LARICS_SEARCH);
}

static void pass_time(larics_drive *drive, int32_t elapsed_ms)
{
    int32_t turned_cdeg = larics_floor_div(drive->turn_cdeg_s * elapsed_ms, 1000);
    drive->silent_ms = smaller(NEVER_MS, drive->silent_ms + elapsed_ms);
    drive->next_ms = smaller(NEVER_MS, drive->next_ms + elapsed_ms);
    drive->next_cdeg = larics_wrap_cdeg(drive->next_cdeg - turned_cdeg);
    drive->way_um = smaller(1000000000, drive->way_um + larics_abs(drive->speed_mm_s) * elapsed_ms);
    carry(drive, &drive->target, elapsed_ms);
    carry(drive, &drive->behind, elapsed_ms);
}

/* Moves the commands towards these values, within all limits. */
static void command(larics_drive *drive, int32_t speed_mm_s, int32_t turn_cdeg_s, int32_t elapsed_ms)
{
    const larics_drive_limits *limits = &drive->limits;
    int32_t most = larger(1, limits->accel_mm_s2 * elapsed_ms / 1000);
    speed_mm_s = larics_clamp(speed_mm_s, limits->speed_mm_s);
    turn_cdeg_s = larics_clamp(turn_cdeg_s, limits->turn_cdeg_s);
    drive->speed_mm_s += larics_clamp(speed_mm_s - drive->speed_mm_s, most);
    most = larger(1, limits->turn_accel_cdeg_s2 * elapsed_ms / 1000);
    drive->turn_cdeg_s += larics_clamp(turn_cdeg_s - drive->turn_cdeg_s, most);
}

static void search(larics_drive *drive, int32_t elapsed_ms)
{
    int32_t speed = drive->limits.speed_mm_s * 3 / 4, way_mm, radius_mm;
    enter(drive, LARICS_SEARCH);
    way_mm = smaller(drive->way_um / 1000, 1000000);
    radius_mm = (int32_t)larics_isqrt(
        (uint32_t)((int32_t)SPIRAL_START_MM * SPIRAL_START_MM + SPIRAL_PITCH_MM * way_mm));
    command(drive, speed, 5730 * speed / radius_mm, elapsed_ms);
}

static void turn(larics_drive *drive, int32_t elapsed_ms);

static void center(larics_drive *drive, int32_t elapsed_ms)
{
    const larics_drive_limits *limits = &drive->limits;
    int32_t x, y, distance_mm10, error, forward = 1, speed;
    enter(drive, LARICS_CENTER);
    x = larics_clamp(drive->target.x_mm10, 20000);
    y = larics_clamp(drive->target.y_mm10, 20000);
    distance_mm10 = (int32_t)larics_isqrt((uint32_t)(x * x + y * y));
    if (distance_mm10 <= limits->center_mm10) {
        enter(drive, LARICS_ALIGN);
        turn(drive, elapsed_ms);
        return;
    }
    error = larics_wrap_cdeg(larics_cdeg_from_turn16(larics_atan2_turn16(y, x)));
    if (larics_abs(error) > 10000) { /* it is behind: back up */
        forward = -1;
        error = larics_wrap_cdeg(error + 18000);
    }
    speed = (int32_t)larics_isqrt((uint32_t)(limits->accel_mm_s2 * distance_mm10 / 10));
    speed = smaller(limits->speed_mm_s, speed) * larger(0, AHEAD_CDEG - larics_abs(error)) / AHEAD_CDEG;
    command(drive, forward * speed, error * TURN_GAIN, elapsed_ms);
}

/* Where to go on from the marker, vehicle frame. */
static int32_t direction(const larics_drive *drive)
{
    if (drive->next_ms <= drive->limits.stale_ms) return larics_wrap_cdeg(drive->next_cdeg);
    return larics_wrap_cdeg(drive->target.heading_cdeg);
}

static void leave(larics_drive *drive)
{
    drive->behind = drive->target;
    drive->left_id = drive->target.id;
    drive->target.age_ms = NEVER_MS;
    drive->leg_cdeg = larics_wrap_cdeg(direction(drive) - drive->target.heading_cdeg);
    enter(drive, LARICS_GO);
}

/* Whether the camera knows by odometry where to go on, without a marker. */
static int is_guided(const larics_drive *drive)
{
    return drive->is_carried && drive->next_ms <= drive->limits.stale_ms;
}

/* GO while no marker is in sight but the one that was left. */
static void go_on(larics_drive *drive, int32_t elapsed_ms)
{
    const larics_sight *behind = &drive->behind;
    int32_t error = 0, speed;
    enter(drive, LARICS_GO);
    if (drive->way_um > drive->limits.leg_mm * 1000 && !is_guided(drive)) {
        search(drive, elapsed_ms);
        return;
    }
    if (behind->age_ms <= drive->limits.stale_ms) {
        int32_t turn16, x, y, aside_mm; /* the line is left of the vehicle */
        error = larics_wrap_cdeg(behind->heading_cdeg + drive->leg_cdeg);
        turn16 = larics_turn16_from_cdeg(error);
        x = larics_floor_shift(behind->x_mm10, 2);
        y = larics_floor_shift(behind->y_mm10, 2);
        aside_mm = larics_floor_div(y * larics_cos_q14(turn16) - x * larics_sin_q14(turn16), 40960);
        error += larics_clamp(aside_mm * CROSS_CDEG_PER_MM, CROSS_MOST_CDEG);
    } else if (drive->next_ms < NEVER_MS) { /* the last direction told, kept by the commanded turns */
        error = larics_wrap_cdeg(drive->next_cdeg);
    }
    speed = drive->limits.speed_mm_s * larger(0, AHEAD_CDEG - larics_abs(error)) / AHEAD_CDEG;
    command(drive, speed, error * TURN_GAIN, elapsed_ms);
}

/* ALIGN below the marker. */
static void turn(larics_drive *drive, int32_t elapsed_ms)
{
    int32_t error;
    if (drive->is_end) {
        enter(drive, LARICS_ARRIVED);
        command(drive, 0, 0, elapsed_ms);
        return;
    }
    error = direction(drive);
    if (larics_abs(error) <= drive->limits.align_cdeg &&
        larics_abs(drive->turn_cdeg_s) * 5 < 10 * drive->limits.align_cdeg &&
        larics_abs(drive->speed_mm_s) < 20) {
        leave(drive);
        go_on(drive, elapsed_ms);
        return;
    }
    command(drive, 0, error * TURN_GAIN, elapsed_ms);
}

static int is_far_off(const larics_drive *drive)
{
    return larics_abs(drive->target.x_mm10) + larics_abs(drive->target.y_mm10) > 4 * drive->limits.center_mm10;
}

uint8_t larics_drive_step(larics_drive *drive, uint32_t elapsed)
{
    int32_t elapsed_ms = elapsed > 1000u ? 1000 : larger(1, (int32_t)elapsed);
    int is_seen;
    pass_time(drive, elapsed_ms);
    if (drive->is_stopped || drive->is_held || drive->silent_ms > 2 * drive->limits.stale_ms)
        enter(drive, LARICS_HALT);
    else if (drive->state == LARICS_HALT)
        enter(drive, LARICS_SEARCH);
    is_seen = drive->target.age_ms <= drive->limits.stale_ms;
    if (drive->state == LARICS_HALT || drive->state == LARICS_ARRIVED)
        command(drive, 0, 0, elapsed_ms);
    else if (!is_seen && (drive->state == LARICS_GO || is_guided(drive)))
        go_on(drive, elapsed_ms);
    else if (!is_seen)
        search(drive, elapsed_ms);
    else if (drive->state == LARICS_ALIGN && !is_far_off(drive))
        turn(drive, elapsed_ms);
    else
        center(drive, elapsed_ms);
    return drive->state;
}
