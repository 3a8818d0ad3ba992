// Conversion of the motor's angle readings, for any sensor, to counts from the handle's zero.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace sensor {

// Reset: the next reading selects the nearest repeat of the zero. A quadrature encoder
// repeats every count: its zero is the handle's present position.
void start(const protocol::Board& kit);

// Change settings while running. The same sensor continues, with the zero moved by the difference of both
// settings; a different sensor restarts.
void change(const protocol::Board& kit);

// Process one reading, in the sample interrupt; failed: the sensor's own check reports an error. Return
// counts from the zero, positive to the right; implausible readings are bridged.
int32_t count(uint16_t raw, bool failed);

// True if one of the three functions below has something to report, which is rare.
extern volatile uint8_t news;
constexpr uint8_t kMoved = 1, kDoubt = 2, kFaulty = protocol::kFlagSensor;

inline bool take(uint8_t what) {
  const uint8_t before = news;
  news = before & ~what;
  return before & what;
}

// True if the meaning of counts has changed since the last call: zero, sense or sensor. The difference
// is not motion. In the sample interrupt only.
inline bool take_moved() { return take(kMoved); }

// True if a reading was bridged since the last call; in the sample interrupt only.
inline bool take_doubt() { return take(kDoubt); }

// True after so many implausible readings that the position is unreliable: motor off. After
// 8 in a row, until 32 good ones.
inline bool faulty() { return news & kFaulty; }

}  // namespace sensor
