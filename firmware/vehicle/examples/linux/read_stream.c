/* Reads a LARICS camera on Linux: read_stream [PORT [BAUD]], or a recorded stream on standard input.
 *
 *     cd firmware/vehicle/src && cc -std=c99 -I. *.c ../examples/linux/read_stream.c -o ../read_stream
 *     ../read_stream /dev/ttyACM0 115200
 *
 * Prints one line for each message and, of a camera on a port, each change of what may be made of it; ends
 * with what the decoder counted.
 */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "larics_supervisor.h"

#define MOST_AGE_MS 200

static volatile sig_atomic_t stopped;

static void stop(int number)
{
    (void)number;
    stopped = 1;
}

static uint32_t now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint32_t)now.tv_sec * 1000u + (uint32_t)(now.tv_nsec / 1000000);
}

static int open_port(const char *name, long baud)
{
    static const struct {
        long baud;
        speed_t speed;
    } speeds[] = {{9600, B9600},     {19200, B19200},   {38400, B38400},   {57600, B57600},
                  {115200, B115200}, {230400, B230400}, {460800, B460800}, {500000, B500000},
                  {921600, B921600}, {1000000, B1000000}};
    struct termios settings;
    int port = open(name, O_RDWR | O_NOCTTY);
    if (port < 0 || tcgetattr(port, &settings)) {
        fprintf(stderr, "read_stream: cannot open %s: %s\n", name, strerror(errno));
        exit(2);
    }
    cfmakeraw(&settings);
    for (size_t k = 0; k < sizeof speeds / sizeof speeds[0]; k++)
        if (speeds[k].baud == baud) {
            cfsetspeed(&settings, speeds[k].speed);
            tcsetattr(port, TCSANOW, &settings);
            return port;
        }
    fprintf(stderr, "read_stream: no baud rate %ld\n", baud);
    exit(2);
}

static void show(const larics_message *message)
{
    if (message->type == LARICS_MARKER) {
        const larics_marker *m = &message->as.marker;
        if (m->count == 0)
            printf("frame %lu: no marker\n", (unsigned long)m->frame);
        else
            printf("frame %lu: marker %d (%d of %d) x %.1f y %.1f mm heading %.2f deg margin %d age %.1f ms\n",
                   (unsigned long)m->frame, m->id, m->index + 1, m->count, m->x_mm10 / 10.0,
                   m->y_mm10 / 10.0, m->heading_cdeg / 100.0, m->margin, m->age_us / 1000.0);
    } else if (message->type == LARICS_POSE) {
        static const char *const states[] = {"LOST", "COASTING", "TRACKING", "CARRIED"};
        const larics_pose *p = &message->as.pose;
        printf("frame %lu: pose x %.1f y %.1f mm heading %.2f deg %s\n", (unsigned long)p->frame,
               p->x_mm10 / 10.0, p->y_mm10 / 10.0, p->heading_cdeg / 100.0, states[p->state]);
    } else if (message->type == LARICS_STATUS) {
        const larics_status *s = &message->as.status;
        printf("status: %lu s, %lu frames, %lu markers, %.2f Hz, %lu drops, %lu faults\n",
               (unsigned long)s->uptime_s, (unsigned long)s->frames, (unsigned long)s->detections,
               s->rate_chz / 100.0, (unsigned long)s->drops, (unsigned long)s->faults);
    } else if (message->type == LARICS_INFO) {
        const larics_info *i = &message->as.info;
        printf("camera %.16s, version %d.%d.%d, frame %dx%d\n", (const char *)i->board, i->version_major,
               i->version_minor, i->version_patch, i->width, i->height);
    } else {
        printf("message of type %d\n", message->type);
    }
}

static const char *const states[] = {
    "nothing heard", "the camera is silent", "another camera is on the line", "the camera restarted",
    "the camera has not proven itself", "the camera reports a fault", "no new frames",
    "the same picture again and again", "too many messages are lost", "not read in time",
    "no marker in sight", "only markers that are uncertain or without offset", "carried for too long",
    "too imprecise", "good", "no STATUS: its faults are unknown"};

int main(int argc, char **argv)
{
    static larics_decoder decoder;
    static larics_supervisor camera;
    larics_limits limits;
    uint8_t frame[LARICS_MAX_FRAME];
    uint16_t sequence = 0;
    long baud = argc > 2 ? atol(argv[2]) : 115200;
    int port = argc > 1 ? open_port(argv[1], baud) : STDIN_FILENO;
    int last_state = -1;

    signal(SIGINT, stop);
    larics_decoder_init(&decoder);
    larics_limits_usual(&limits, (uint32_t)baud);
    limits.buffer_bytes = 4095; /* of the kernel's terminal */
    limits.max_age_ms = MOST_AGE_MS;
    if (argc > 1) limits.challenge_ms = 1000;
    larics_supervisor_init(&camera, &limits, now_ms(), (uint32_t)time(NULL) ^ (uint32_t)getpid() << 16);
    while (!stopped) {
        struct pollfd waiting = {port, POLLIN, 0};
        uint8_t bytes[4096];
        ssize_t count = 0;
        size_t size;
        int state;
        if (poll(&waiting, 1, 2) > 0) {
            count = read(port, bytes, sizeof bytes);
            if (count <= 0) break; /* the end of the file, or the port has gone */
        }
        larics_begin_drain(&camera, now_ms());
        for (ssize_t k = 0; k < count; k++)
            if (larics_decode(&decoder, bytes[k])) {
                larics_supervise(&camera, &decoder.message);
                show(&decoder.message);
            }
        size = larics_challenge(&camera, now_ms(), &sequence, frame);
        if (size && write(port, frame, size) != (ssize_t)size) perror("read_stream: write");
        state = larics_marker_state(&camera, now_ms());
        if (state != last_state && argc > 1) printf("%s\n", states[state]);
        last_state = state;
        fflush(stdout);
    }
    printf("%lu messages, %lu missing; refused: crc %lu cobs %lu length %lu version %lu unknown %lu "
           "over_long %lu out_of_range %lu\n",
           (unsigned long)decoder.counters.messages, (unsigned long)decoder.counters.gaps,
           (unsigned long)decoder.counters.crc, (unsigned long)decoder.counters.cobs,
           (unsigned long)decoder.counters.length, (unsigned long)decoder.counters.version,
           (unsigned long)decoder.counters.unknown, (unsigned long)decoder.counters.over_long,
           (unsigned long)decoder.counters.out_of_range);
    return 0;
}
