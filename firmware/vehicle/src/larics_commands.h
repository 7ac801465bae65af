/* LARICS camera: commands, one at a time: sent, repeated until answered, given up in time. C99, no allocation.
 *
 *     larics_commands commands;
 *     larics_commands_init(&commands, random_number);
 *     int32_t exposure_us;
 *     larics_get_setting_of(&commands, LARICS_KEY_EXPOSURE_US, &exposure_us, 1);
 *     in each turn of the loop:
 *         each decoded message:  larics_commands_take(&commands, &message);
 *         size = larics_commands_poll(&commands, now_ms, &sequence, frame);   sends when size is not 0
 *     until commands.state is no longer LARICS_COMMAND_WAITING
 *
 * A repetition carries the token of the first try, so that the camera carries nothing out twice.
 */
#ifndef LARICS_COMMANDS_H
#define LARICS_COMMANDS_H

#include "larics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* larics_commands.state */
#define LARICS_COMMAND_IDLE 0      /* none yet */
#define LARICS_COMMAND_WAITING 1   /* for the answer */
#define LARICS_COMMAND_DONE 2      /* carried out; what was asked for is there */
#define LARICS_COMMAND_REFUSED 3   /* `reason` is a LARICS_NACK code, `detail` the key in question */
#define LARICS_COMMAND_TIMED_OUT 4 /* not answered: it may have been carried out, or not */

typedef struct {
    uint16_t retry_ms; /* from one try to the next; 500 */
    uint8_t tries;     /* 4 */
    uint8_t state;
    uint8_t reason;
    uint8_t detail;
    uint16_t count; /* of numbers that the setting asked for has; those beyond the room are left out */
    uint8_t type;   /* private from here on */
    uint8_t key;
    uint8_t tried;
    uint8_t is_due;
    uint8_t has_part;
    uint16_t token;
    uint16_t argument;
    uint16_t first;
    uint16_t length;
    uint32_t sent_ms;
    int32_t *got;
    const int32_t *given;
    larics_info *info;
} larics_commands;

/* `seed`: as random as can be had; the first token comes from it, so that a restarted vehicle repeats none. */
void larics_commands_init(larics_commands *commands, uint32_t seed);

/* Each begins a command; 0 when one is still waiting. What pointers lead to must stay until the answer. */
int larics_ping_camera(larics_commands *commands);
int larics_get_info_of(larics_commands *commands, larics_info *info);
int larics_get_setting_of(larics_commands *commands, uint8_t key, int32_t *values, uint16_t room);
int larics_set_setting_of(larics_commands *commands, uint8_t key, const int32_t *values, uint16_t count);
int larics_save_settings_of(larics_commands *commands);
int larics_restart_camera(larics_commands *commands, uint16_t boot);

/* Gives up waiting; the camera may carry the command out all the same. */
void larics_commands_cancel(larics_commands *commands);

/* Takes every decoded message, also what the supervision refuses. */
void larics_commands_take(larics_commands *commands, const larics_message *message);

/* Bytes to send to the camera now in frame[0..result-1], else 0; ends a command that nobody answers.
 * `sequence` numbers all that the vehicle sends. */
size_t larics_commands_poll(larics_commands *commands, uint32_t now_ms, uint16_t *sequence,
                            uint8_t frame[LARICS_MAX_FRAME]);

#ifdef __cplusplus
}
#endif

#endif
