/* LARICS camera: drives a robot from marker to marker, in integers only. C99, no allocation.
 *
 *     SEARCH   no marker: a spiral whose turns lie 80 cm apart
 *     CENTER   drive until the marker is above the vehicle
 *     ALIGN    turn in place to the next direction: that of the route, or the marker's orientation line
 *     GO       drive on along that line, or where a camera with odometry says that the next marker is, until it
 *            comes into view
 *     ARRIVED  the last marker of the route
 *     HALT     nothing heard for too long, held by the supervision, or stopped by hand: brake and wait
 *
 *     larics_drive drive;
 *     larics_drive_init(&drive, NULL);
 *     each message that larics_supervise accepted and larics_may_drive_by allows:
 *         larics_drive_take(&drive, &message);
 *     every 20 ms or so:
 *         drive.is_held = !larics_may_search(&camera, now);
 *         larics_drive_step(&drive, elapsed_ms);
 *         give drive.speed_mm_s (forward) and drive.turn_cdeg_s (counterclockwise) to the wheels
 *
 * Between messages what was seen is carried along by the commanded motion, so a slow camera will do. Speed,
 * turn rate and both accelerations are limited. It does step by step what shared/larics_vehicle/approach.py does.
 */
#ifndef LARICS_DRIVE_H
#define LARICS_DRIVE_H

#include "larics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* larics_drive.state */
#define LARICS_HALT 0
#define LARICS_SEARCH 1
#define LARICS_CENTER 2
#define LARICS_ALIGN 3
#define LARICS_GO 4
#define LARICS_ARRIVED 5

typedef struct {
    int32_t speed_mm_s;         /* 1..20000 */
    int32_t turn_cdeg_s;        /* 1..100000 */
    int32_t accel_mm_s2;        /* 1..50000, also for braking */
    int32_t turn_accel_cdeg_s2; /* 1..1000000 */
    int32_t stale_ms;           /* 1..10000: a marker seen longer ago is not believed; silence of twice: HALT */
    int32_t center_mm10;        /* 1..100000: the vehicle is below the marker within this distance */
    int32_t align_cdeg;         /* 1..18000: and turned to the next direction within this angle */
    int32_t leg_mm;             /* 1..1000000: a leg longer than this without a marker ends in SEARCH */
} larics_drive_limits;

typedef struct {
    uint16_t id;
    int32_t x_mm10;
    int32_t y_mm10;
    int32_t heading_cdeg;
    int32_t age_ms;
} larics_sight; /* private: what is kept of a marker */

typedef struct {
    larics_drive_limits limits;
    uint8_t state;
    int32_t speed_mm_s;  /* the command: forward ... */
    int32_t turn_cdeg_s; /* ... and counterclockwise */
    uint16_t left_id;    /* GO came from this marker; LARICS_ID_NONE before the first one */
    uint8_t is_held;     /* set it: HALT for as long as it is 1 */
    uint8_t is_end;      /* the route ends at the marker reached: ARRIVED; the camera's POSE sets it, too */
    uint8_t is_carried;  /* odometry told the direction to go on in */
    uint8_t is_stopped;  /* private from here on */
    larics_sight target;
    larics_sight behind;
    int32_t next_cdeg;
    int32_t next_ms;
    int32_t silent_ms;
    int32_t way_um;
    int32_t leg_cdeg;
    int32_t frame_ms;
} larics_drive;

/* Careful limits for a vehicle of 0.2 m/s. */
void larics_drive_limits_usual(larics_drive_limits *limits);

/* `limits` NULL: the usual ones. 0 when a limit is outside its range: the drive then stays in HALT. */
int larics_drive_init(larics_drive *drive, const larics_drive_limits *limits);

/* Takes an accepted message; others than MARKER and POSE only count as a sign of life. */
void larics_drive_take(larics_drive *drive, const larics_message *message);

/* Sets the commands for the time until the next call, 1 to 1000 ms; returns the state. */
uint8_t larics_drive_step(larics_drive *drive, uint32_t elapsed_ms);

/* Brakes, whatever comes, until larics_drive_start. */
void larics_drive_stop(larics_drive *drive);

/* Ends larics_drive_stop, and leaves ARRIVED. */
void larics_drive_start(larics_drive *drive);

#ifdef __cplusplus
}
#endif

#endif
