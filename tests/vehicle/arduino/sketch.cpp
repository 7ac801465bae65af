// Just enough of an Arduino to compile and run the example sketch on a PC: Serial1 is standard input,
// Serial is standard output, and time passes by 10 ms with each byte read.
#include <cstddef>
#include <cstdint>
#include <cstdio>

static uint32_t clock_ms;
static uint32_t millis() { return clock_ms; }

struct Port {
  void begin(uint32_t) {}
  int available() {
    int byte = std::getchar();
    if (byte == EOF) return 0;
    std::ungetc(byte, stdin);
    return 1;
  }
  int read() {
    clock_ms += 10;
    return std::getchar();
  }
  size_t write(const uint8_t *, size_t count) { return count; }
  void print(const char *text) { std::fputs(text, stdout); }
  void print(int number) { std::printf("%d", number); }
  void println(int number) { std::printf("%d\n", number); }
};
static Port Serial, Serial1;

#include SKETCH

int main() {
  setup();
  for (int turn = 0; turn < 20; turn++) {
    loop();
    clock_ms += 20;
  }
  return 0;
}
