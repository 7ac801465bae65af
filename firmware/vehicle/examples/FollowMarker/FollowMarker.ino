// Turns the vehicle until the marker is straight ahead, drives to it, and stops whenever the camera cannot be
// trusted.
//
// Mega, Due, Zero, ESP32, ...: camera TX to RX1, camera RX to TX1 of this board, common ground; what is going on
// is printed on USB. Uno, Nano: there is one serial port only, so the camera is on pins 0 and 1 (unplug it
// while you upload) and nothing is printed.
// The camera's pins take 3.3 V. A board of 5 V needs a level shifter, or two resistors, in the line from its TX
// to the camera's RX: 5 V destroy the camera.
#include <larics_supervisor.h>

#if defined(HAVE_HWSERIAL1) || !defined(__AVR__)
#define CAMERA Serial1
#define SAY(text, number) (Serial.print(text), Serial.println(number))
#else
#define CAMERA Serial
#define SAY(text, number) ((void)(number))
#endif

static larics_decoder decoder;
static larics_supervisor camera;
static uint16_t sequence;  // of all that this board sends

// setting `baud` of the camera; at 16 MHz an AVR makes 250000, 500000 and 1000000 exactly
static const uint32_t BAUD = 115200;

static void steer(int8_t turn, int16_t speed) {
  // replace by the motors of your vehicle
  SAY("turn ", turn);
  SAY("speed ", speed);
}

void setup() {
  larics_limits limits;
#if defined(HAVE_HWSERIAL1) || !defined(__AVR__)
  Serial.begin(115200);
#endif
  CAMERA.begin(BAUD);
  larics_limits_usual(&limits, BAUD);
  limits.max_age_ms = 100;     // at 0.5 m/s the vehicle moves 50 mm in that time
  limits.challenge_ms = 1000;  // the camera has to prove each second that it is there; 0 without a wire to it
  larics_decoder_init(&decoder);
  larics_supervisor_init(&camera, &limits, millis(), (uint32_t)analogRead(A0) * 65521u + micros());
}

void loop() {
  static uint32_t last_ms;
  static uint8_t last_state = 255;
  uint8_t frame[LARICS_MAX_FRAME];
  uint32_t now = millis();
  uint8_t state;
  size_t size;

  larics_begin_drain(&camera, now);
  while (CAMERA.available()) {
    if (larics_decode(&decoder, (uint8_t)CAMERA.read())) {
      larics_supervise(&camera, &decoder.message);
    }
  }
  size = larics_challenge(&camera, now, &sequence, frame);
  if (size) CAMERA.write(frame, size);

  if (now - last_ms < 50) return;
  last_ms = now;
  state = larics_marker_state(&camera, now);
  if (state != last_state) SAY("state ", state);
  last_state = state;
  if (state != LARICS_GOOD) {
    steer(0, 0);  // nothing to trust: stop
  } else if (camera.choice.target.y_mm10 > 200) {
    steer(1, 100);  // the marker is more than 20 mm to the left
  } else if (camera.choice.target.y_mm10 < -200) {
    steer(-1, 100);
  } else {
    steer(0, 100);
  }
}
