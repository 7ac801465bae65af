// Reads a LARICS camera on Serial1 and turns the vehicle until the nearest marker is straight ahead.
// Wiring: camera TX to this board's RX1, camera RX to TX1, common ground; both sides must be 3.3 V.
#include <larics.h>

static larics_decoder decoder;
static larics_tracker tracker;
static uint16_t sequence;
static uint16_t token;

static const uint32_t BAUD = 115200;
static const uint32_t MOST_AGE_MS = 100;  // older than this is not steered by

static void ask_for_info() {
  larics_message message;
  uint8_t frame[LARICS_MAX_FRAME];
  message.type = LARICS_GET_INFO;
  message.as.get_info.token = ++token;
  Serial1.write(frame, larics_encode(&message, sequence++, frame));
}

static void steer(int16_t turn, int16_t speed) {
  // replace by the motors of your vehicle
  Serial.print("turn ");
  Serial.print(turn);
  Serial.print(" speed ");
  Serial.println(speed);
}

void setup() {
  Serial.begin(115200);
  Serial1.begin(BAUD);
  larics_decoder_init(&decoder);
  larics_tracker_init(&tracker, BAUD);
  ask_for_info();
}

void loop() {
  static uint32_t last_ms;

  while (Serial1.available()) {
    if (larics_decode(&decoder, (uint8_t)Serial1.read())) {
      larics_track(&tracker, &decoder.message, millis());
    }
  }

  if (millis() - last_ms < 50) return;
  last_ms = millis();
  if (!larics_marker_is_fresh(&tracker, millis(), MOST_AGE_MS)) {
    steer(0, 0);  // nothing to trust: stop
  } else if (tracker.marker.y_mm10 > 200) {
    steer(1, 100);  // the marker is more than 20 mm to the left
  } else if (tracker.marker.y_mm10 < -200) {
    steer(-1, 100);
  } else {
    steer(0, 100);
  }
}
