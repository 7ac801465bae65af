/* LARICS camera: whether what the camera says may be steered by, and if not, why. C99, no allocation.
 *
 *     larics_decoder decoder;
 *     larics_supervisor camera;
 *     larics_limits limits;
 *     larics_limits_usual(&limits, 115200);        then change what your vehicle needs
 *     larics_decoder_init(&decoder);
 *     larics_supervisor_init(&camera, &limits, millis(), random_number);
 *     in each turn of the loop:
 *         now = millis();
 *         larics_begin_drain(&camera, now);        then read until nothing is left
 *         while (Serial1.available())
 *             if (larics_decode(&decoder, Serial1.read())) larics_supervise(&camera, &decoder.message);
 *         size = larics_challenge(&camera, now, &sequence, frame);   sends when size is not 0
 *         if (larics_marker_is_fresh(&camera, now)) steer by camera.choice.target; else stop.
 *
 * Times are milliseconds of a clock of the caller that may wrap. `now` may be older than the last message by
 * up to a minute: such times count as now.
 */
#ifndef LARICS_SUPERVISOR_H
#define LARICS_SUPERVISOR_H

#include "larics.h"
#include "larics_choice.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LARICS_NEVER 0xFFFFFFFFu /* age of what was never measured, or more than a minute ago */
#define LARICS_BOOTS 4           /* earlier boot numbers that are remembered and refused */

/* State of the measurement, the weightiest first: what larics_marker_state and larics_pose_state return. */
#define LARICS_WAITING 0    /* nothing heard yet */
#define LARICS_SILENT 1     /* no message within silent_ms */
#define LARICS_FOREIGN 2    /* another camera than the pinned or the first one speaks on the line */
#define LARICS_RESTARTED 3  /* the camera restarted; no frame accepted since */
#define LARICS_UNPROVEN 4   /* a challenge is unanswered, or the sequence was left: it may be a recording */
#define LARICS_FAULTY 5     /* it reports a lasting fault that touches the measurement: `faults` */
#define LARICS_STALLED 6    /* it speaks, but no new frame within stalled_ms */
#define LARICS_FROZEN 7     /* the same picture again and again */
#define LARICS_DAMAGED 8    /* too many messages are missing by their sequence numbers */
#define LARICS_OVERRUN 9    /* not read for so long that bytes were lost, and nothing usable since */
#define LARICS_NO_MARKER 10 /* frames without a marker, or POSEs that are LOST; or the last one is too old */
#define LARICS_UNUSABLE 11  /* markers in sight, but uncertain, unconfirmed or of an uncalibrated camera */
#define LARICS_STRAYED 12   /* pose only: carried by odometry for longer or further than the limits */
#define LARICS_IMPRECISE 13 /* pose only: its sigma is unknown or above the limits */
#define LARICS_GOOD 14      /* fresh: may be steered by */
#define LARICS_NO_STATUS 15 /* no STATUS within status_ms: whether it is well is unknown. Weighs as _FAULTY */

typedef struct {
    uint32_t baud;
    uint16_t buffer_bytes;     /* of the receive buffer; 0 when nothing can be lost in it */
    uint16_t max_age_ms;       /* greatest age of what is steered by */
    uint16_t silent_ms;        /* longest time without any message; STATUS comes each second */
    uint16_t stalled_ms;       /* longest time without a new frame */
    uint16_t frozen_frames;    /* equal measurements one after the other; 0: not judged */
    uint16_t most_gap;         /* messages missing at once that are a loss and not another source */
    uint8_t most_loss_percent; /* of about the last 64 messages */
    uint32_t faults;           /* lasting faults that forbid steering: bit n stands for LARICS_FAULT code n */
    uint16_t most_sigma_mm10;  /* greatest standard deviation of the pose's x and y; 65535: not judged */
    uint16_t most_sigma_cdeg;  /* and of its heading; 65535: not judged */
    uint16_t most_carried_ms;  /* longest time since the last marker of a pose that odometry carries; 65535: any */
    uint16_t most_way_mm;      /* and longest way since then; 65535: any, also an unknown one */
    uint16_t challenge_ms;     /* from one challenge to the next; 0: none, the camera does not hear us */
    uint16_t answer_ms;        /* longest time for an answer */
    uint8_t is_pinned;         /* 1: only the camera with `unique_id`; 0: the first one seen */
    uint8_t unique_id[12];     /* as in INFO */
    larics_choice_rule choice;
    uint16_t status_ms; /* longest time without STATUS, 1 to 59999, else its faults are unknown; 0: not judged */
} larics_limits;

/* What was refused or noticed since the start. */
typedef struct {
    uint32_t accepted;
    uint32_t contradictory;   /* fields that contradict each other */
    uint32_t repeated;        /* sequence number, or time since start, not above the last one */
    uint32_t jumps;           /* gaps above most_gap */
    uint32_t foreign;         /* of another camera, of an earlier boot, or commands */
    uint32_t unproven;        /* measurements while the source was in doubt */
    uint32_t late_answers;    /* answers to a challenge after answer_ms */
    uint32_t overruns;        /* times that the buffer was not emptied for longer than it lasts */
    uint32_t restarts;        /* of the camera */
    uint32_t sensor_restarts; /* frame numbers that began anew without a restart of the camera */
} larics_noticed;

typedef struct {
    larics_limits limits;
    larics_noticed noticed;
    larics_choice choice;  /* choice.target: the marker to steer by */
    larics_pose pose;      /* the last one that was not LOST */
    uint8_t pose_state;    /* LARICS_LOST, _COASTING, _TRACKING or _CARRIED as last told */
    uint32_t faults;       /* lasting faults as last told: larics_status_age_ms says when */
    uint8_t unique_id[12]; /* of the camera, when has_identity */
    uint8_t has_identity;
    uint16_t boot;  /* private from here on */
    uint16_t boots[LARICS_BOOTS];
    uint16_t sequence;
    uint16_t nonce;
    uint32_t random;
    uint32_t drained_ms;
    uint32_t arrived_ms;
    uint32_t heard_ms;
    uint32_t frame_ms;
    uint32_t seen_ms;
    uint32_t pose_ms;
    uint32_t asked_ms;
    uint32_t proven_ms;
    uint32_t frame;
    uint32_t uptime_s;
    uint32_t pictures[2];
    uint16_t marker_line_ms;
    uint16_t pose_line_ms;
    uint16_t most_drain_ms;
    uint16_t equal_frames;
    uint16_t loss_q16;
    uint8_t boot_count;
    uint8_t asked; /* type of the open challenge, 0 for none */
    uint8_t has_boot, has_info, has_heard, has_frame, has_seen, has_pose, has_proof, has_asked;
    uint8_t is_anchored, is_foreign, is_restarted, is_late, is_overrun, has_picture;
    uint32_t told_ms; /* last STATUS, or since when one is waited for */
    uint32_t picture_ms;
    uint8_t has_status;
} larics_supervisor;

/* Usual limits for a vehicle of up to 0.5 m/s; see the README for how to choose them. */
void larics_limits_usual(larics_limits *limits, uint32_t baud);

/* `seed`: as random as can be had, for the nonces of the challenges. */
void larics_supervisor_init(larics_supervisor *camera, const larics_limits *limits, uint32_t now_ms,
                            uint32_t seed);

/* Before the receive buffer is read, with a time read before that: what is read now may have waited since
 * the last call, and its age is bounded by that. Read until the buffer is empty. */
void larics_begin_drain(larics_supervisor *camera, uint32_t now_ms);

/* Takes a decoded message; 1 when it is accepted, 0 when it is refused and must not be used. */
int larics_supervise(larics_supervisor *camera, const larics_message *message);

/* The next challenge, when one is due: bytes to send to the camera in frame[0..result-1], else 0.
 * `sequence` numbers all that the vehicle sends. */
size_t larics_challenge(larics_supervisor *camera, uint32_t now_ms, uint16_t *sequence,
                        uint8_t frame[LARICS_MAX_FRAME]);

/* LARICS_WAITING .. LARICS_NO_STATUS */
uint8_t larics_marker_state(const larics_supervisor *camera, uint32_t now_ms);
uint8_t larics_pose_state(const larics_supervisor *camera, uint32_t now_ms);

/* Age in ms, since the exposure, of choice.target and of pose, or LARICS_NEVER. */
uint32_t larics_marker_age_ms(const larics_supervisor *camera, uint32_t now_ms);
uint32_t larics_pose_age_ms(const larics_supervisor *camera, uint32_t now_ms);

/* Time in ms since the STATUS that `faults` is from, or LARICS_NEVER: then they are unknown. */
uint32_t larics_status_age_ms(const larics_supervisor *camera, uint32_t now_ms);

/* 1 when choice.target, or pose, may be steered by: its state is LARICS_GOOD. */
int larics_marker_is_fresh(const larics_supervisor *camera, uint32_t now_ms);
int larics_pose_is_fresh(const larics_supervisor *camera, uint32_t now_ms);

/* 1 when the camera is well, also when no marker is in sight: a search may go on. */
int larics_may_search(const larics_supervisor *camera, uint32_t now_ms);

/* 1 when a message that was just accepted may be driven by: all but a POSE that is LARICS_STRAYED or _IMPRECISE. */
int larics_may_drive_by(const larics_supervisor *camera, const larics_message *message, uint32_t now_ms);

/* 1 when the fields of a message from the camera contradict each other. */
int larics_is_contradictory(const larics_message *message);

#ifdef __cplusplus
}
#endif

#endif
