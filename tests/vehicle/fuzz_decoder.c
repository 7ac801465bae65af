/* Coverage-guided fuzzing of the decoder with libFuzzer; `make fuzz` builds and runs it.
 *
 * The first byte chooses: the rest is a stream as it is; or contents, each with a length byte in front,
 * that are framed with a right CRC here, because no fuzzer guesses one.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "larics_supervisor.h"

static larics_decoder decoder;
static larics_supervisor camera;
static uint32_t zeros, now_ms;

static void check(int condition)
{
    if (!condition) abort();
}

static uint32_t ended(const larics_counters *c)
{
    return c->messages + c->crc + c->cobs + c->length + c->version + c->unknown + c->over_long + c->empty +
           c->out_of_range;
}

static void feed(uint8_t byte)
{
    uint8_t frame[LARICS_MAX_FRAME];
    larics_message copy;
    size_t size;

    zeros += byte == 0;
    now_ms += byte;
    if (byte & 3) larics_begin_drain(&camera, now_ms);
    if (larics_decode(&decoder, byte)) {
        copy = decoder.message;
        check(byte == 0);
        larics_supervise(&camera, &copy);
        size = larics_encode(&copy, copy.sequence, frame);
        check(size >= 12 && frame[size - 1] == 0 && memchr(frame, 0, size) == frame + size - 1);
    }
    check(ended(&decoder.counters) == zeros);
    check(!larics_marker_is_fresh(&camera, now_ms) || camera.choice.target.count);
    check(!larics_pose_is_fresh(&camera, now_ms) || camera.pose_state != LARICS_LOST);
}

static uint32_t crc32_of(const uint8_t *data, size_t count)
{
    uint32_t crc = 0xFFFFFFFFu;
    while (count--) {
        crc ^= *data++;
        for (int bit = 0; bit < 8; bit++) crc = crc & 1 ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
    }
    return ~crc;
}

static void feed_framed(const uint8_t *content, size_t count)
{
    uint8_t block[272] = {0};
    uint32_t crc = crc32_of(content, count);
    size_t code = 0, end = count + 5;

    memcpy(block + 1, content, count);
    for (int k = 0; k < 4; k++) block[1 + count + (size_t)k] = (uint8_t)(crc >> 8 * k);
    for (size_t k = 1; k < end; k++)
        if (block[k] == 0) {
            block[code] = (uint8_t)(k - code);
            code = k;
        }
    block[code] = (uint8_t)(end - code);
    for (size_t k = 0; k <= end; k++) feed(k < end ? block[k] : 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    larics_limits limits;
    larics_decoder_init(&decoder);
    zeros = now_ms = 0;
    if (size == 0) return 0;
    larics_limits_usual(&limits, 115200);
    limits.challenge_ms = (uint16_t)(data[0] & 2 ? 500 : 0);
    larics_supervisor_init(&camera, &limits, 0, 1);
    if (data[0] & 1) {
        for (size_t k = 1; k < size; k++) feed(data[k]);
        return 0;
    }
    for (size_t k = 1; k < size;) {
        size_t count = data[k] & 0x7F;
        k++;
        if (count > size - k) count = size - k;
        feed_framed(data + k, count);
        k += count;
    }
    return 0;
}
