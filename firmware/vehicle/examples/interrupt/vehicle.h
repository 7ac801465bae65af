#ifndef VEHICLE_H
#define VEHICLE_H

#include <stddef.h>
#include <stdint.h>

/* What vehicle.c does. */
void vehicle_start(uint32_t now_ms, uint32_t seed);
void vehicle_received(uint8_t byte);   /* from the receive interrupt, and from nowhere else */
void vehicle_turn(uint32_t now_ms);    /* from the main loop, or from one task, as often as possible */
extern volatile uint32_t vehicle_lost; /* bytes for which the ring had no room */

/* What your board has to do. */
void board_send(const uint8_t *bytes, size_t count); /* to the camera; must not wait long */
void board_drive(int32_t speed_mm_s, int32_t turn_cdeg_s);

#endif
