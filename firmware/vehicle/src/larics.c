#include "larics.h"

#include <string.h>

#include "larics_flash.h"
#include "larics_layout.h"

#define HEADER 4
#define CRC_SIZE 4
#define CRC_START 0xFFFFFFFFu
#define CRC_INTACT 0xDEBB20E3u /* over a message and its CRC, whatever the message */
#define LATE 8u /* a number that goes back by less is a message that was overtaken */

enum { START, INSIDE, TOO_LONG };

static const uint32_t crc_of_nibble[16] LARICS_IN_FLASH = {
    0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u, 0x4DB26158u, 0x5005713Cu,
    0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu, 0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu};

static uint32_t crc_with(uint32_t crc, uint8_t byte)
{
    crc ^= byte;
    crc = (crc >> 4) ^ larics_flash_u32(&crc_of_nibble[crc & 15u]);
    return (crc >> 4) ^ larics_flash_u32(&crc_of_nibble[crc & 15u]);
}

static uint32_t crc32(const uint8_t *data, size_t count)
{
    uint32_t crc = CRC_START;
    while (count--) crc = crc_with(crc, *data++);
    return crc ^ 0xFFFFFFFFu;
}

void larics_decoder_init(larics_decoder *decoder)
{
    memset(decoder, 0, sizeof *decoder);
}

static void count(uint32_t *counter, uint32_t more)
{
    *counter = (*counter + more) & LARICS_COUNT_MAX;
}

static void count_gap(larics_decoder *decoder, uint16_t sequence)
{
    larics_counters *counters = &decoder->counters;
    uint16_t last = decoder->sequence, step = (uint16_t)(sequence - last);
    decoder->sequence = sequence;
    if (!decoder->has_sequence) {
        decoder->has_sequence = 1;
    } else if (step == 0) {
        count(&counters->repeats, 1);
    } else if (step > 0x10000u - LATE) {
        decoder->sequence = last;
        if (counters->gaps) counters->gaps--; /* it was counted as missing */
    } else if (step > 0x7FFFu) {
        count(&counters->restarts, 1);
        decoder->doubtful = (uint16_t)(step - 1u);
        decoder->went_back = 1;
    } else {
        count(&counters->gaps, step - 1u);
        if (sequence < last) {
            decoder->doubtful = (uint16_t)(step - 1u);
            decoder->went_back = 0;
        }
    }
}

/* A message told the boot number of its sender: what was a restart, and what only looked like one. */
static void hear_boot(larics_decoder *decoder, uint16_t boot, uint16_t sequence)
{
    larics_counters *counters = &decoder->counters;
    if (decoder->has_boot && boot == decoder->boot) {
        if (decoder->went_back) {
            count(&counters->restarts, LARICS_COUNT_MAX); /* one less */
            count(&counters->gaps, decoder->doubtful);
        }
    } else if (decoder->has_boot) {
        decoder->sequence = sequence;
        if (!decoder->went_back) {
            count(&counters->restarts, 1);
            count(&counters->gaps, LARICS_COUNT_MAX + 1u - decoder->doubtful);
        }
    }
    decoder->boot = boot;
    decoder->has_boot = 1;
    decoder->doubtful = 0;
    decoder->went_back = 0;
}

/* A 0 has come: judges what came before it. */
static int finish(larics_decoder *decoder)
{
    larics_counters *counters = &decoder->counters;
    const uint8_t *bytes = decoder->buffer;
    size_t end = (size_t)decoder->size - CRC_SIZE;
    uint16_t sequence;
    larics_layout type;

    if (decoder->state == START) {
        count(&counters->empty, 1);
    } else if (decoder->state == TOO_LONG) {
        count(&counters->over_long, 1);
    } else if (decoder->left) {
        count(&counters->cobs, 1);
    } else if (decoder->size < HEADER + CRC_SIZE) {
        count(&counters->length, 1);
    } else if (decoder->crc != CRC_INTACT) {
        count(&counters->crc, 1);
    } else if (bytes[0] != LARICS_VERSION) {
        count(&counters->version, 1);
    } else {
        sequence = (uint16_t)(bytes[2] | (uint16_t)bytes[3] << 8);
        count_gap(decoder, sequence);
        if (!larics_layout_find(bytes[1], &type)) {
            count(&counters->unknown, 1);
        } else if (end != (size_t)HEADER + type.size) {
            count(&counters->length, 1);
        } else if (!larics_unpack(&type, bytes + HEADER, (uint8_t *)&decoder->message.as)) {
            count(&counters->out_of_range, 1);
        } else {
            count(&counters->messages, 1);
            decoder->message.type = bytes[1];
            decoder->message.sequence = sequence;
            if (bytes[1] == LARICS_INFO) hear_boot(decoder, decoder->message.as.info.boot, sequence);
            if (bytes[1] == LARICS_STATUS) hear_boot(decoder, decoder->message.as.status.boot, sequence);
            return 1;
        }
    }
    return 0;
}

/* The CRC grows with each byte, so that the last one of a frame does not take much longer. */
static void keep(larics_decoder *decoder, uint8_t byte)
{
    decoder->buffer[decoder->size++] = byte;
    decoder->crc = crc_with(decoder->crc, byte);
}

int larics_decode(larics_decoder *decoder, uint8_t byte)
{
    int is_new = 0;
    if (byte == 0) {
        is_new = finish(decoder);
        decoder->state = START;
        decoder->left = 0;
    } else if (decoder->state == TOO_LONG) {
        /* skipped */
    } else if (decoder->left) {
        keep(decoder, byte);
        decoder->left--;
    } else { /* a COBS byte: how many bytes follow until a 0 */
        if (decoder->state == START) {
            decoder->size = 0;
            decoder->crc = CRC_START;
        } else {
            keep(decoder, 0);
        }
        decoder->state = INSIDE;
        decoder->left = (uint8_t)(byte - 1u);
        if ((unsigned)decoder->size + decoder->left > LARICS_LIMIT) decoder->state = TOO_LONG;
    }
    return is_new;
}

size_t larics_encode(const larics_message *message, uint16_t sequence, uint8_t frame[LARICS_MAX_FRAME])
{
    larics_layout type;
    size_t end, code = 0;

    if (!larics_layout_find(message->type, &type)) return 0;
    if (!larics_pack(&type, (const uint8_t *)&message->as, frame + 1 + HEADER)) return 0;
    frame[1] = LARICS_VERSION;
    frame[2] = message->type;
    frame[3] = (uint8_t)sequence;
    frame[4] = (uint8_t)(sequence >> 8);
    end = (size_t)HEADER + type.size;
    larics_put32(frame + 1 + end, crc32(frame + 1, end));
    end += 1 + CRC_SIZE;
    for (size_t k = 1; k < end; k++)
        if (frame[k] == 0) {
            frame[code] = (uint8_t)(k - code);
            code = k;
        }
    frame[code] = (uint8_t)(end - code);
    frame[end] = 0;
    return end + 1;
}

void larics_set_odometry(larics_message *message, uint32_t sampled_us, uint32_t now_us, int32_t x_mm10,
                         int32_t y_mm10, int32_t heading_cdeg, uint8_t epoch)
{
    larics_odometry *odometry = &message->as.odometry;
    int32_t heading = heading_cdeg % 36000;
    memset(message, 0, sizeof *message);
    message->type = LARICS_ODOMETRY;
    odometry->time_us = sampled_us & LARICS_COUNT_MAX;
    odometry->age_us = (now_us - sampled_us) & LARICS_COUNT_MAX;
    odometry->x_mm10 = x_mm10;
    odometry->y_mm10 = y_mm10;
    odometry->heading_cdeg = (uint16_t)(heading < 0 ? heading + 36000 : heading);
    odometry->epoch = epoch;
}

size_t larics_frame_size(uint8_t type)
{
    larics_layout found;
    return larics_layout_find(type, &found) ? (size_t)HEADER + found.size + CRC_SIZE + 2u : 0;
}
