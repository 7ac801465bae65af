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
#else
#define CAMERA Serial
#endif

static const uint32_t BAUD = 115200;
static const uint16_t TRACK_MM = 300;
static const uint16_t ROUTE[] = {3, 4, 7, 3};

static larics_decoder decoder;
static larics_supervisor camera;
static larics_drive drive;
static larics_route route;
static larics_wheels wheels;
static uint16_t workspace[8];
static uint16_t sequence;

static void turn_wheels(int32_t left_mm_s, int32_t right_mm_s) {
  // replace by the motors of your vehicle
  (void)left_mm_s;
  (void)right_mm_s;
}

static void read_encoders(int32_t *left_um, int32_t *right_um) {
  // replace by your encoders: the ways since the last call
  *left_um = *right_um = 0;
}

void setup() {
  larics_limits limits;
  uint32_t seed = (uint32_t)analogRead(A0) * 65521u + micros();
  CAMERA.begin(BAUD);
  larics_limits_usual(&limits, BAUD);
  limits.challenge_ms = 1000;
  larics_decoder_init(&decoder);
  larics_supervisor_init(&camera, &limits, millis(), seed);
  larics_drive_init(&drive, NULL);
  larics_route_init(&route, ROUTE, 4, -1, workspace);
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
    if (larics_decode(&decoder, (uint8_t)CAMERA.read()) && larics_supervise(&camera, &decoder.message)) {
      larics_drive_take(&drive, &decoder.message);
    }
  }
  size = larics_challenge(&camera, now, &sequence, frame);
  if (size) CAMERA.write(frame, size);

  if (now - last_ms < 20) return;
  if (larics_marker_is_fresh(&camera, now)) larics_route_see(&route, camera.choice.target.id);
  drive.is_held = !larics_may_search(&camera, now);
  larics_drive_step(&drive, now - last_ms);
  last_ms = now;
  side = drive.turn_cdeg_s * TRACK_MM / 11459;  // half the track times the turn in radians
  turn_wheels(drive.speed_mm_s - side, drive.speed_mm_s + side);

  read_encoders(&left_um, &right_um);
  larics_wheels_roll(&wheels, left_um, right_um, TRACK_MM, micros());
  size = larics_wheels_message(&wheels, micros(), &sequence, frame);
  if (size) CAMERA.write(frame, size);
}
