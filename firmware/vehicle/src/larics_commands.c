#include "larics_commands.h"

#include <string.h>

void larics_commands_init(larics_commands *commands, uint32_t seed)
{
    memset(commands, 0, sizeof *commands);
    commands->retry_ms = 500;
    commands->tries = 4;
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    commands->token = (uint16_t)(seed ^ seed >> 16);
}

static void next_token(larics_commands *commands)
{
    commands->token = (uint16_t)(commands->token + 1u);
    commands->tried = 0;
    commands->is_due = 1;
}

static int begin(larics_commands *commands, uint8_t type)
{
    if (commands->state == LARICS_COMMAND_WAITING) return 0;
    commands->type = type;
    commands->state = LARICS_COMMAND_WAITING;
    commands->reason = commands->detail = commands->key = commands->has_part = 0;
    commands->count = commands->first = commands->length = 0;
    commands->got = NULL;
    commands->given = NULL;
    commands->info = NULL;
    next_token(commands);
    return 1;
}

int larics_ping_camera(larics_commands *commands)
{
    return begin(commands, LARICS_PING);
}

int larics_get_info_of(larics_commands *commands, larics_info *info)
{
    if (!begin(commands, LARICS_GET_INFO)) return 0;
    commands->info = info;
    return 1;
}

int larics_get_setting_of(larics_commands *commands, uint8_t key, int32_t *values, uint16_t room)
{
    if (!begin(commands, LARICS_GET_SETTING)) return 0;
    commands->key = key;
    commands->got = values;
    commands->length = room;
    return 1;
}

int larics_set_setting_of(larics_commands *commands, uint8_t key, const int32_t *values, uint16_t count)
{
    if (!begin(commands, LARICS_SET_SETTING)) return 0;
    commands->key = key;
    commands->given = values;
    commands->length = count;
    return 1;
}

int larics_save_settings_of(larics_commands *commands)
{
    return begin(commands, LARICS_SAVE_SETTINGS);
}

int larics_restart_camera(larics_commands *commands, uint16_t boot)
{
    if (!begin(commands, LARICS_RESTART)) return 0;
    commands->argument = boot;
    return 1;
}

void larics_commands_cancel(larics_commands *commands)
{
    if (commands->state == LARICS_COMMAND_WAITING) commands->state = LARICS_COMMAND_TIMED_OUT;
}

static uint16_t smaller(uint16_t a, uint16_t b)
{
    return a < b ? a : b;
}

/* A part of the setting asked for; parts come in order, and a repetition begins anew. */
static void take_part(larics_commands *commands, const larics_setting *part)
{
    uint16_t values = (uint16_t)(part->count - part->first);
    if (part->first == 0) commands->first = 0;
    if (part->key != commands->key || part->first != commands->first || part->first > part->count) return;
    values = smaller(values, LARICS_SETTING_VALUES);
    for (uint16_t k = 0; k < values; k++)
        if (part->first + (uint32_t)k < commands->length) commands->got[part->first + k] = part->value[k];
    commands->count = part->count;
    commands->has_part = 1;
    commands->first = (uint16_t)(part->first + values);
}

static void acknowledge(larics_commands *commands)
{
    if (commands->type == LARICS_SET_SETTING) {
        commands->first = (uint16_t)(commands->first + smaller((uint16_t)(commands->length - commands->first),
                                                               LARICS_SETTING_VALUES));
        if (commands->first < commands->length) {
            next_token(commands); /* the next part */
            return;
        }
    }
    if (commands->type == LARICS_GET_SETTING && (!commands->has_part || commands->first < commands->count)) {
        commands->is_due = 1; /* a part got lost */
        return;
    }
    commands->state = LARICS_COMMAND_DONE;
}

void larics_commands_take(larics_commands *commands, const larics_message *message)
{
    if (commands->state != LARICS_COMMAND_WAITING || commands->tried == 0) return;
    if (message->type == LARICS_SETTING && commands->type == LARICS_GET_SETTING &&
        message->as.setting.token == commands->token) {
        take_part(commands, &message->as.setting);
    } else if (message->type == LARICS_INFO && commands->info && message->as.info.token == commands->token) {
        *commands->info = message->as.info;
        commands->has_part = 1;
    } else if (message->type == LARICS_ACK && message->as.ack.token == commands->token &&
               message->as.ack.command == commands->type) {
        if (commands->info && !commands->has_part)
            commands->is_due = 1; /* the INFO got lost */
        else
            acknowledge(commands);
    } else if (message->type == LARICS_NACK && message->as.nack.token == commands->token &&
               message->as.nack.command == commands->type && message->as.nack.reason != LARICS_NACK_BUSY) {
        commands->reason = message->as.nack.reason;
        commands->detail = message->as.nack.detail;
        commands->state = LARICS_COMMAND_REFUSED;
    }
}

static void fill_part(const larics_commands *commands, larics_set_setting *part)
{
    uint16_t values = smaller((uint16_t)(commands->length - commands->first), LARICS_SETTING_VALUES);
    part->key = commands->key;
    part->first = commands->first;
    part->count = commands->length;
    for (uint16_t k = 0; k < values; k++) part->value[k] = commands->given[commands->first + k];
}

size_t larics_commands_poll(larics_commands *commands, uint32_t now_ms, uint16_t *sequence,
                            uint8_t frame[LARICS_MAX_FRAME])
{
    larics_message message;
    size_t size;
    if (commands->state != LARICS_COMMAND_WAITING) return 0;
    if (commands->tried && !commands->is_due && now_ms - commands->sent_ms < commands->retry_ms) return 0;
    if (commands->tried >= commands->tries) {
        commands->state = LARICS_COMMAND_TIMED_OUT;
        return 0;
    }
    memset(&message, 0, sizeof message);
    message.type = commands->type;
    message.as.ping.token = commands->token; /* every command begins with it */
    if (commands->type == LARICS_GET_SETTING) {
        message.as.get_setting.key = commands->key;
        commands->first = 0;
        commands->has_part = 0;
    } else if (commands->type == LARICS_SET_SETTING) {
        fill_part(commands, &message.as.set_setting);
    } else if (commands->type == LARICS_RESTART) {
        message.as.restart.boot = commands->argument;
    }
    size = larics_encode(&message, *sequence, frame);
    if (!size) { /* a value that no setting can have */
        commands->reason = LARICS_NACK_RANGE;
        commands->detail = commands->key;
        commands->state = LARICS_COMMAND_REFUSED;
        return 0;
    }
    commands->sent_ms = now_ms;
    commands->tried++;
    commands->is_due = 0;
    *sequence = (uint16_t)(*sequence + 1u);
    return size;
}
