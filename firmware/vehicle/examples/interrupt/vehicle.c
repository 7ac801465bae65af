/* A vehicle on a bare processor (STM32, RP2040, nRF52, ...) or under an RTOS: the receive interrupt only puts bytes
 * into a ring, and one loop or task does everything else. On an STM32 with its HAL:
 *
 *     static uint8_t byte;                                      in main.c
 *     void HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart)
 *     {
 *         vehicle_received(byte);
 *         HAL_UART_Receive_IT(uart, &byte, 1);
 *     }
 *     ...
 *     vehicle_start(HAL_GetTick(), random_number);
 *     HAL_UART_Receive_IT(&huart1, &byte, 1);
 *     for (;;) vehicle_turn(HAL_GetTick());
 *
 * with board_send as HAL_UART_Transmit(&huart1, bytes, count, 5), and board_drive for your motors.
 */
#include "vehicle.h"

#include "larics_drive.h"
#include "larics_supervisor.h"

#define RING 256u /* at 115200 baud 22 ms; its indices wrap by themselves */

volatile uint32_t vehicle_lost;

static volatile uint8_t ring[RING];
static volatile uint8_t head; /* written by the interrupt only */
static volatile uint8_t tail; /* written by the loop only */
static larics_decoder decoder;
static larics_supervisor camera;
static larics_drive drive;
static uint16_t sequence;
static uint32_t stepped_ms;

void vehicle_received(uint8_t byte)
{
    uint8_t next = (uint8_t)(head + 1u);
    if (next == tail) {
        vehicle_lost = vehicle_lost + 1u;
        return;
    }
    ring[head] = byte;
    head = next; /* after the byte itself */
}

void vehicle_start(uint32_t now_ms, uint32_t seed)
{
    larics_limits limits;
    larics_limits_usual(&limits, 115200);
    limits.buffer_bytes = RING - 1u;
    limits.challenge_ms = 1000; /* 0 without a line to the camera */
    larics_decoder_init(&decoder);
    larics_supervisor_init(&camera, &limits, now_ms, seed);
    larics_drive_init(&drive, NULL);
    stepped_ms = now_ms;
}

void vehicle_turn(uint32_t now_ms)
{
    uint8_t frame[LARICS_MAX_FRAME];
    size_t size;

    larics_begin_drain(&camera, now_ms);
    while (tail != head) {
        uint8_t byte = ring[tail];
        tail = (uint8_t)(tail + 1u);
        if (larics_decode(&decoder, byte) && larics_supervise(&camera, &decoder.message) &&
            larics_may_drive_by(&camera, &decoder.message, now_ms))
            larics_drive_take(&drive, &decoder.message);
    }
    size = larics_challenge(&camera, now_ms, &sequence, frame);
    if (size) board_send(frame, size);

    if (now_ms - stepped_ms < 20u) return;
    drive.is_held = !larics_may_search(&camera, now_ms);
    larics_drive_step(&drive, now_ms - stepped_ms);
    stepped_ms = now_ms;
    board_drive(drive.speed_mm_s, drive.turn_cdeg_s);
}
