// Hobby servos that follow the lines of a pipe drive ("12 48 jaw=1500 lid=1820"; docs/formats.md). For an Arduino with
// the Servo library, which is part of its software. A count is a pulse in microseconds.
//
// It stops by itself: 100 ms after the last line, and at "off", the servos get no more pulses.
#include <Servo.h>

struct Axis {
  const char* name;  // of the axis in the rig
  int pin;
  int min_us, max_us;  // what this servo takes: nothing beyond is ever sent to it
  Servo servo;
};
Axis axes[] = {
    {"jaw", 9, 600, 2400, Servo()},
    {"lid", 10, 600, 2400, Servo()},
};

const unsigned long silence_ms = 100;
char line[160];
unsigned int length = 0;
bool is_too_long = false;
unsigned long heard_ms = 0;

void release() {
  for (Axis& axis : axes) axis.servo.detach();
}

void take(const char* name, long pulse_us) {
  for (Axis& axis : axes) {
    if (strcmp(axis.name, name) != 0) continue;
    if (pulse_us < axis.min_us || pulse_us > axis.max_us) continue;  // holds its place
    axis.servo.writeMicroseconds(pulse_us);
    if (!axis.servo.attached()) axis.servo.attach(axis.pin, axis.min_us, axis.max_us);
  }
}

void obey() {
  if (strcmp(line, "off") == 0) return release();
  strtok(line, " ");  // the number
  strtok(NULL, " ");  // the time
  while (char* word = strtok(NULL, " ")) {
    char* const equals = strchr(word, '=');
    if (equals == NULL) return;
    *equals = '\0';
    take(word, atol(equals + 1));
  }
  heard_ms = millis();
}

void setup() {
  Serial.begin(115200);
}

void loop() {
  while (Serial.available() > 0) {
    const char letter = Serial.read();
    if (letter != '\n') {
      if (length + 1 < sizeof line) {
        line[length++] = letter;
      } else {
        is_too_long = true;
      }
      continue;
    }
    line[length] = '\0';
    if (!is_too_long) obey();
    length = 0;
    is_too_long = false;
  }
  if (millis() - heard_ms > silence_ms) release();
}
