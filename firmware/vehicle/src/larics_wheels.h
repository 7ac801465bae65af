/* LARICS camera: odometry for the camera, from the wheels of a vehicle, as ODOMETRY messages. C99, no allocation.
 *
 *     larics_wheels wheels;
 *     larics_wheels_init(&wheels, random_number);
 *     every 10 to 50 ms:
 *         larics_wheels_roll(&wheels, left_um, right_um, 300, micros());    since the last call, track 300 mm
 *         size = larics_wheels_message(&wheels, micros(), &sequence, frame);  bytes to send to the camera
 *
 * The camera carries its pose on by them between two markers. What it is told must come from encoders: the
 * commands that the wheels were given are not what they did. It adds up step by step as
 * shared/larics_vehicle/odometer.py does.
 */
#ifndef LARICS_WHEELS_H
#define LARICS_WHEELS_H

#include "larics.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int32_t x_mm10; /* since the start, odometry frame: x forward at the start, y to the left */
    int32_t y_mm10;
    int32_t heading_mcdeg; /* 1/1000 of 0.01 degree, 0..35999999, counterclockwise */
    uint8_t epoch;         /* another one after each jump */
    uint8_t is_slipping;   /* set it while slip is suspected */
    uint8_t is_standing;   /* nothing moved in the last call */
    int32_t rest_x_q7;     /* private from here on */
    int32_t rest_y_q7;
    int32_t rest_turn;
    uint8_t rest_way;
    uint32_t sampled_us;
} larics_wheels;

/* `seed`: as random as can be had, for the first epoch: a restarted vehicle is another one to the camera. */
void larics_wheels_init(larics_wheels *wheels, uint32_t seed);

/* The ways of both wheels since the last call, um, forward positive, 200 mm at most and 140 mm apart; the distance
 * between the wheels, 10 to 5000 mm; when they were read, us. 0 when that is out of range: nothing was added. */
int larics_wheels_roll(larics_wheels *wheels, int32_t left_um, int32_t right_um, uint16_t track_mm,
                       uint32_t now_us);

/* The same for other drives: way forward, um, and turn, 1/1000 of 0.01 degree, 90 degrees at most. */
int larics_wheels_move(larics_wheels *wheels, int32_t forward_um, int32_t turn_mcdeg, uint32_t now_us);

/* The vehicle was lifted: the pose begins anew at 0, in a new epoch. */
void larics_wheels_reset(larics_wheels *wheels);

/* An ODOMETRY message in frame[0..result-1]; `sequence` numbers all that the vehicle sends. */
size_t larics_wheels_message(const larics_wheels *wheels, uint32_t now_us, uint16_t *sequence,
                             uint8_t frame[LARICS_MAX_FRAME]);

#ifdef __cplusplus
}
#endif

#endif
