// Drives a robot with two wheels along a route of markers: 3, 4, 7 and back to 3.
//
// Wiring and voltage as in FollowMarker: the camera's pins take 3.3 V, a board of 5 V needs a level shifter. On an
// Uno the camera is on the only serial port, pins 0 and 1.
#include <larics_drive.h>
#include <larics_route.h>
#include <larics_supervisor.h>
#include <larics_wheels.h>

#if defined(HAVE_HWSERIAL1) || !defined(__AVR__)
#define CAMERA Serial1
#define SAY(text, number) (Serial.print(text), Serial.println(number))
#else
#define CAMERA Serial
#define SAY(text, number) ((void)(number))
#endif

static const uint32_t BAUD = 115200;
static const uint16_t TRACK_MM = 300;
static const uint16_t ROUTE[] = {3, 4, 7, 3};  // ends where it began: again and again
static const int16_t ROUTE_LENGTH = 4;

static larics_decoder decoder;
static larics_supervisor camera;
static larics_drive drive;
static larics_route route;
static larics_wheels wheels;
static uint16_t workspace[2 * ROUTE_LENGTH];
static uint16_t sequence;

static void turn_wheels(int32_t left_mm_s, int32_t right_mm_s) {
  // replace by the motors of your vehicle
  SAY("left ", (int)left_mm_s);
  SAY("right ", (int)right_mm_s);
}

static void read_encoders(int32_t *left_um, int32_t *right_um) {
  // replace by your encoders: the ways since the last call
  *left_um = *right_um = 0;
}

// Where the vehicle is on its route, from the marker that it is nearest to.
static void follow_route(uint32_t now) {
  if (larics_marker_is_fresh(&camera, now)) {
    larics_route_see(&route, camera.choice.target.id);
  } else if (larics_marker_state(&camera, now) == LARICS_NO_MARKER) {
    larics_route_lose_sight(&route);
  }
  drive.is_end = route.position >= 0 && larics_route_next(&route) < 0;
}

// Only the marker last reached and the next one are driven to; any of the route while its place on it is open.
static bool is_wanted(const larics_message *message) {
  const larics_marker *marker = &message->as.marker;
  int16_t next = larics_route_next(&route);
  if (message->type != LARICS_MARKER || marker->count == 0) return true;
  for (int16_t k = 0; k < ROUTE_LENGTH; k++) {
    bool is_near = route.position < 0 || k == route.position || k == next;
    if (is_near && ROUTE[k] == marker->id) return true;
  }
  return false;
}

void setup() {
  larics_limits limits;
  uint32_t seed = (uint32_t)analogRead(A0) * 65521u + micros();
#if defined(HAVE_HWSERIAL1) || !defined(__AVR__)
  Serial.begin(115200);
#endif
  CAMERA.begin(BAUD);
  larics_limits_usual(&limits, BAUD);
  limits.challenge_ms = 1000;
  larics_decoder_init(&decoder);
  larics_supervisor_init(&camera, &limits, millis(), seed);
  larics_drive_init(&drive, NULL);
  larics_route_init(&route, ROUTE, ROUTE_LENGTH, -1, workspace);
  larics_wheels_init(&wheels, seed);
}

void loop() {
  static uint32_t last_ms;
  uint8_t frame[LARICS_MAX_FRAME];
  uint32_t now = millis();
  int32_t left_um, right_um, side;
  size_t size;

  larics_begin_drain(&camera, now);
  while (CAMERA.available()) {
    if (larics_decode(&decoder, (uint8_t)CAMERA.read()) && larics_supervise(&camera, &decoder.message) &&
        larics_may_drive_by(&camera, &decoder.message, now) && is_wanted(&decoder.message)) {
      larics_drive_take(&drive, &decoder.message);
    }
  }
  size = larics_challenge(&camera, now, &sequence, frame);
  if (size) CAMERA.write(frame, size);

  if (now - last_ms < 20) return;
  follow_route(now);
  drive.is_held = !larics_may_search(&camera, now);
  larics_drive_step(&drive, now - last_ms);
  last_ms = now;
  side = drive.turn_cdeg_s * TRACK_MM / 11459;  // half the track times the turn in radians
  turn_wheels(drive.speed_mm_s - side, drive.speed_mm_s + side);

  read_encoders(&left_um, &right_um);
  if (!larics_wheels_roll(&wheels, left_um, right_um, TRACK_MM, micros())) {
    larics_wheels_reset(&wheels);  // no vehicle does that in 20 ms: what was driven is not known
  }
  size = larics_wheels_message(&wheels, micros(), &sequence, frame);
  if (size) CAMERA.write(frame, size);
}
