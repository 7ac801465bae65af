// Just enough of an Arduino to run the example sketches on a PC: Serial1 is standard input and
// standard error, Serial is standard output, and a millisecond passes with each turn of the loop.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <unistd.h>

#define HAVE_HWSERIAL1
#define A0 14
static uint32_t clock_ms;
static uint32_t millis() { return clock_ms; }
static uint32_t micros() { return clock_ms * 1000; }
static int analogRead(int) { return 7; }

struct Port {
  int bytes;
  void begin(uint32_t) {}
  int available() {
    int byte = bytes < 8 ? std::getchar() : EOF;  // a line that brings eight bytes in a millisecond
    if (byte != EOF) std::ungetc(byte, stdin);
    return byte != EOF;
  }
  int read() {
    bytes++;
    return std::getchar();
  }
  size_t write(const uint8_t *data, size_t count) {
    return ::write(2, data, count) == (ssize_t)count ? count : 0;
  }
  void print(const char *text) { std::fputs(text, stdout); }
  void print(int number) { std::printf("%d", number); }
  void println(int number) { std::printf("%d\n", number); }
};
static Port Serial, Serial1;

#include SKETCH

int main() {
  setup();
  for (int turn = 0; turn < 1000; turn++) {
    loop();
    clock_ms++;
    Serial1.bytes = 0;
  }
  std::fflush(stdout);
  return 0;
}
