// Velocity from sensor counts in whole numbers: a third of the time that floats would take, and as exact.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace estimator {

// Everything that depends on rate, method and sensor. The main program makes it, the tick uses it.
struct Design {
  uint8_t method;    // protocol::kEstimator...
  uint8_t quarters;  // of a millisecond in one period
  uint32_t first;    // half of the coefficients, in 2^-32
  uint32_t second;
  int16_t fastest;  // limit of the speed, in counts per period
  float scale;      // m/s in 2^-16 counts per period
  float quantum;    // m in a count
  float period;     // s
};

constexpr int16_t kMostCounts = 4095;  // in one period; what jumps farther is no motion
constexpr float kOne = 65536.0f;       // a count

// Fill a design; return false, with nothing changed, for what no loop can have. quantum in m, fastest in m/s.
bool design(const protocol::Loop& loop, float quantum, float fastest, Design* made);

class Estimator {
 public:
  // Start as if the handle had rested at this count.
  void restart(int32_t count) {
    last_ = count;
    speed_ = rest_ = 0;
  }

  // Go on at the same velocity with another design.
  void change(uint8_t quarters_before, uint8_t quarters);

  // Take a count whose period is not the design's.
  void skip(int32_t count) { last_ = count; }

  // Take the count one period later, or several; return whether the handle is within its limit.
  bool update(const Design& design, int32_t count, uint8_t periods = 1);

  // Return the velocity in m/s.
  float velocity(const Design& design) const { return static_cast<float>(speed_) * design.scale; }

 private:
  int32_t last_ = 0;
  int32_t speed_ = 0;  // 2^-16 counts per period
  int32_t rest_ = 0;   // last count less the filter's own, 2^-16 counts
};

}  // namespace estimator
