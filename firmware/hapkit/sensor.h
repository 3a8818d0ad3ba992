// From the readings of the motor's angle sensor, of any kind, to counts from the handle's zero.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace sensor {

// Forget everything: the next reading decides which repeat of the zero is the nearest. A quadrature encoder
// repeats every count: its zero is where the handle stands.
void start(const protocol::Board& kit);

// Take over other settings while running. The same sensor goes on, and the zero moves by as many counts as
// its number has changed; another sensor starts anew.
void change(const protocol::Board& kit);

// Take one reading, in the sample interrupt; failed: the sensor's own check says that it is wrong. Return
// counts from the zero, positive to the right; what cannot be right is bridged.
int32_t count(uint16_t raw, bool failed);

// What the three below tell: nothing, nearly always.
extern volatile uint8_t news;
constexpr uint8_t kMoved = 1, kDoubt = 2, kFaulty = protocol::kFlagSensor;

inline bool take(uint8_t what) {
  const uint8_t before = news;
  news = before & ~what;
  return before & what;
}

// Whether counts have another meaning since this was last asked: another zero, sense or sensor. What is seen
// between the two is no motion. In the sample interrupt only.
inline bool take_moved() { return take(kMoved); }

// Whether a reading was bridged since this was last asked; in the sample interrupt only.
inline bool take_doubt() { return take(kDoubt); }

// Whether so many readings could not be right that the position is not to be trusted: motor off. It takes
// 8 in a row, and ends after 32 good ones.
inline bool faulty() { return news & kFaulty; }

}  // namespace sensor
