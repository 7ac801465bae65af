#include "larics_source.h"

static uint32_t age_ms(uint32_t arrived_ms, uint32_t age_us, uint16_t on_line_ms, uint32_t now_ms)
{
    uint32_t age = larics_since_ms(arrived_ms, now_ms), before = age_us / 1000u + 1u + on_line_ms;
    return age > LARICS_OLDEST_MS || before > LARICS_OLDEST_MS ? LARICS_NEVER : age + before;
}

uint32_t larics_marker_age_ms(const larics_supervisor *camera, uint32_t now_ms)
{
    if (!camera->choice.has_target) return LARICS_NEVER;
    return age_ms(camera->choice.target_ms, camera->choice.target.age_us, camera->marker_line_ms, now_ms);
}

uint32_t larics_pose_age_ms(const larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t age_us = (uint32_t)camera->pose.marker_age_ms * 1000u;
    if (!camera->has_pose) return LARICS_NEVER;
    if (camera->pose.state == LARICS_CARRIED) age_us = camera->pose.age_us;
    return age_ms(camera->pose_ms, age_us, camera->pose_line_ms, now_ms);
}

uint32_t larics_status_age_ms(const larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t age = larics_since_ms(camera->told_ms, now_ms);
    return camera->has_status && age <= LARICS_OLDEST_MS ? age : LARICS_NEVER;
}

/* What forbids steering whatever is measured, or LARICS_GOOD. */
static uint8_t camera_state(const larics_supervisor *camera, uint32_t now_ms)
{
    const larics_limits *limits = &camera->limits;
    if (!camera->has_heard) return LARICS_WAITING;
    if (larics_since_ms(camera->heard_ms, now_ms) > limits->silent_ms) return LARICS_SILENT;
    if (camera->is_foreign) return LARICS_FOREIGN;
    if (camera->is_restarted) return LARICS_RESTARTED;
    if (!larics_source_is_proven(camera, now_ms)) return camera->is_overrun ? LARICS_OVERRUN : LARICS_UNPROVEN;
    if (limits->status_ms && larics_since_ms(camera->told_ms, now_ms) > limits->status_ms) return LARICS_NO_STATUS;
    if (camera->faults & limits->faults & ~LARICS_BIT(LARICS_FAULT_CAMERA_FROZEN)) return LARICS_FAULTY;
    if (!camera->has_frame || larics_since_ms(camera->frame_ms, now_ms) > limits->stalled_ms) return LARICS_STALLED;
    if (camera->faults & limits->faults) return LARICS_FROZEN;
    if (limits->frozen_frames && camera->equal_frames >= limits->frozen_frames) return LARICS_FROZEN;
    if (camera->loss_q16 > limits->most_loss_percent * 655u) return LARICS_DAMAGED;
    return LARICS_GOOD;
}

static uint8_t state_of(const larics_supervisor *camera, uint32_t age, int is_seen, uint32_t now_ms)
{
    uint8_t state = camera_state(camera, now_ms);
    if (state != LARICS_GOOD) return state;
    if (age <= camera->limits.max_age_ms) return LARICS_GOOD;
    if (camera->is_overrun) return LARICS_OVERRUN;
    return is_seen ? LARICS_UNUSABLE : LARICS_NO_MARKER;
}

uint8_t larics_marker_state(const larics_supervisor *camera, uint32_t now_ms)
{
    int is_seen = camera->has_seen && larics_since_ms(camera->seen_ms, now_ms) <= camera->limits.max_age_ms;
    return state_of(camera, larics_marker_age_ms(camera, now_ms), is_seen, now_ms);
}

/* Whether odometry has carried the pose for longer, or further, than the limits allow. */
static int has_strayed(const larics_supervisor *camera, uint32_t now_ms)
{
    const larics_limits *limits = &camera->limits;
    uint32_t carried_ms = camera->pose.marker_age_ms + larics_since_ms(camera->pose_ms, now_ms);
    if (camera->pose_state != LARICS_CARRIED) return 0;
    if (limits->most_carried_ms < LARICS_AGE_UNKNOWN && carried_ms > limits->most_carried_ms) return 1;
    return camera->pose.way_mm > limits->most_way_mm;
}

/* What is wrong with the pose by the limits that are its own, or LARICS_GOOD. */
static uint8_t quality(const larics_supervisor *camera, uint32_t now_ms)
{
    const larics_limits *limits = &camera->limits;
    const larics_pose *pose = &camera->pose;
    if (has_strayed(camera, now_ms)) return LARICS_STRAYED;
    if (pose->sigma_x_mm10 > limits->most_sigma_mm10 || pose->sigma_y_mm10 > limits->most_sigma_mm10 ||
        pose->sigma_cdeg > limits->most_sigma_cdeg)
        return LARICS_IMPRECISE;
    return LARICS_GOOD;
}

uint8_t larics_pose_state(const larics_supervisor *camera, uint32_t now_ms)
{
    uint32_t age = camera->pose_state == LARICS_LOST ? LARICS_NEVER : larics_pose_age_ms(camera, now_ms);
    uint8_t state = state_of(camera, age, 0, now_ms);
    return state == LARICS_GOOD ? quality(camera, now_ms) : state;
}

int larics_may_drive_by(const larics_supervisor *camera, const larics_message *message, uint32_t now_ms)
{
    if (message->type != LARICS_POSE || message->as.pose.state == LARICS_LOST) return 1;
    return quality(camera, now_ms) == LARICS_GOOD;
}

int larics_marker_is_fresh(const larics_supervisor *camera, uint32_t now_ms)
{
    return larics_marker_state(camera, now_ms) == LARICS_GOOD;
}

int larics_pose_is_fresh(const larics_supervisor *camera, uint32_t now_ms)
{
    return larics_pose_state(camera, now_ms) == LARICS_GOOD;
}

int larics_may_search(const larics_supervisor *camera, uint32_t now_ms)
{
    return camera_state(camera, now_ms) == LARICS_GOOD;
}
