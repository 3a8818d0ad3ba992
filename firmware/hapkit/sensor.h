// Converts the readings of any angle sensor on the motor to counts from the handle's zero.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace sensor {

// Reset. The same reading occurs at several positions of the handle: the zero is the position nearest to the
// handle that has the stored reading. A quadrature encoder starts with its zero at the handle.
void start(const protocol::Board& kit);

// Change settings while the board runs. The same sensor continues, with the zero moved by the difference of
// both settings. A different sensor restarts.
void change(const protocol::Board& kit);

// Process one reading, in the sample interrupt. failed: the sensor itself reports an error. Return counts
// from the zero, positive to the right; implausible readings are bridged.
int32_t count(uint16_t raw, bool failed);

// True if one of the three functions below has something to report, which is rarely the case.
extern volatile uint8_t news;
constexpr uint8_t kMoved = 1, kDoubt = 2, kFaulty = protocol::kFlagSensor;

inline bool take(uint8_t what) {
  const uint8_t before = news;
  news = before & ~what;
  return before & what;
}

// Return true if the meaning of counts (zero, sense or sensor) has changed since the last call. The
// difference is not a motion. Call it only in the sample interrupt.
inline bool take_moved() { return take(kMoved); }

// Return true if a reading was bridged since the last call. Call it only in the sample interrupt.
inline bool take_doubt() { return take(kDoubt); }

// Return true after so many implausible readings that the position is unreliable; the motor must then be off.
// This begins after 8 such readings in a row and ends after 32 good ones.
inline bool faulty() { return news & kFaulty; }

}  // namespace sensor
