/* The tracker's promises: nothing stale, replayed, uncertain or from before a restart is ever fresh. */
#include <stdio.h>
#include <string.h>

#include "larics.h"

static int failures;

static void expect(int condition, const char *what, int line)
{
    if (!condition) {
        printf("line %d: %s\n", line, what);
        failures++;
    }
}
#define EXPECT(condition) expect((condition) != 0, #condition, __LINE__)

static larics_tracker t;
static larics_message m;

static void marker(uint32_t frame, uint32_t age_us, uint16_t flags, uint8_t margin, uint32_t now_ms)
{
    memset(&m, 0, sizeof m);
    m.type = LARICS_MARKER;
    m.as.marker.frame = frame;
    m.as.marker.age_us = age_us;
    m.as.marker.flags = flags;
    m.as.marker.count = flags & LARICS_MARKER_NONE ? 0 : 1;
    m.as.marker.margin = margin;
    larics_track(&t, &m, now_ms);
}

static void pose(uint32_t frame, uint32_t age_us, uint8_t state, uint32_t now_ms)
{
    memset(&m, 0, sizeof m);
    m.type = LARICS_POSE;
    m.as.pose.frame = frame;
    m.as.pose.age_us = age_us;
    m.as.pose.state = state;
    larics_track(&t, &m, now_ms);
}

static void boot(uint16_t number)
{
    memset(&m, 0, sizeof m);
    m.type = LARICS_STATUS;
    m.as.status.boot = number;
    larics_track(&t, &m, 0);
}

int main(void)
{
    larics_tracker_init(&t, 115200);
    EXPECT(larics_marker_age_ms(&t, 0) == LARICS_NEVER && !larics_marker_is_fresh(&t, 0, 0xFFFFFFFFu));
    EXPECT(larics_pose_age_ms(&t, 0) == LARICS_NEVER && !larics_pose_is_fresh(&t, 0, 0xFFFFFFFFu));

    marker(7, 20000, 0, 9, 1000); /* 20 ms, 1 for what is rounded off, 4 on the line */
    EXPECT(larics_marker_age_ms(&t, 1000) == 25 && larics_marker_age_ms(&t, 1075) == 100);
    EXPECT(larics_marker_is_fresh(&t, 1075, 100) && !larics_marker_is_fresh(&t, 1076, 100));

    marker(7, 0, 0, 9, 5000); /* the same frame again is not news */
    marker(6, 0, 0, 99, 5000); /* nor is an older one */
    EXPECT(larics_marker_age_ms(&t, 5000) == 4025);
    marker(7, 20000, 0, 50, 1001); /* a better marker of the same frame */
    EXPECT(t.marker.margin == 50 && larics_marker_age_ms(&t, 1001) == 26);
    marker(8, 0, LARICS_MARKER_NONE, 0, 1020); /* no marker leaves the last one, ageing */
    EXPECT(t.marker.frame == 7 && larics_marker_age_ms(&t, 1020) == 45);

    marker(9, 0, LARICS_MARKER_ID_UNCERTAIN, 0, 2000);
    EXPECT(larics_marker_age_ms(&t, 2000) == 5 && !larics_marker_is_fresh(&t, 2000, 100));
    marker(10, 0, LARICS_MARKER_UNCONFIRMED, 0, 2000);
    EXPECT(!larics_marker_is_fresh(&t, 2000, 100));
    marker(11, 0, LARICS_MARKER_NO_OFFSET, 0, 2000);
    EXPECT(!larics_marker_is_fresh(&t, 2000, 100));
    marker(12, 0, LARICS_MARKER_TRACKED | LARICS_MARKER_BORDER, 0, 2000);
    EXPECT(larics_marker_is_fresh(&t, 2000, 100));
    marker(13, 0x3FFFFFFF, 0, 0, 2000); /* an absurd age */
    EXPECT(!larics_marker_is_fresh(&t, 2000, 0xFFFFFFFEu));

    larics_tracker_init(&t, 115200); /* both clocks wrap */
    marker(LARICS_COUNT_MAX, 0, 0, 0, 0xFFFFFFF0u);
    marker(0, 0, 0, 0, 0xFFFFFFFAu);
    EXPECT(t.marker.frame == 0 && larics_marker_age_ms(&t, 4) == 15);
    EXPECT(!larics_marker_is_fresh(&t, 60100, 100)); /* forgotten for good, also when the clock comes round */
    EXPECT(!larics_marker_is_fresh(&t, 0xFFFFFFFBu, 100));

    larics_tracker_init(&t, 0);
    boot(1);
    marker(1000, 0, 0, 0, 100);
    pose(1000, 5000, LARICS_TRACKING, 100);
    EXPECT(larics_marker_is_fresh(&t, 100, 50) && larics_pose_is_fresh(&t, 100, 50));
    boot(1);
    EXPECT(larics_marker_is_fresh(&t, 100, 50) && larics_pose_is_fresh(&t, 100, 50));
    boot(2); /* restarted: the old is void, and frame numbers begin anew */
    EXPECT(!larics_marker_is_fresh(&t, 100, 50) && !larics_pose_is_fresh(&t, 100, 50));
    marker(0, 0, 0, 0, 120);
    EXPECT(larics_marker_is_fresh(&t, 120, 50));

    pose(1, 5000, LARICS_COASTING, 200);
    EXPECT(larics_pose_age_ms(&t, 200) == 10 && larics_pose_is_fresh(&t, 200, 50));
    pose(2, 9000, LARICS_LOST, 210);
    EXPECT(t.pose.frame == 1 && !larics_pose_is_fresh(&t, 210, 5000));
    pose(2, 0, LARICS_TRACKING, 210); /* the same frame */
    EXPECT(!larics_pose_is_fresh(&t, 210, 5000));
    pose(3, 0, LARICS_TRACKING, 220);
    EXPECT(larics_pose_is_fresh(&t, 220, 50) && !larics_pose_is_fresh(&t, 290, 50));
    return failures != 0;
}
