// Follows the sensor over many half turns of the motor.
#pragma once

#include <stdint.h>

#include "profile.h"

// The sensor repeats every half turn. A jump of more than half its range from one sample to the next is such
// a repeat, so up to half the range per sample may be travelled; its size is fixed, so errors do not add up.
class FlipTracker {
 public:
  // Return the reading plus all half turns so far; the first reading has none.
  int32_t update(uint16_t raw) {
    const int16_t jump = static_cast<int16_t>(raw - last_);
    if (started_ && jump > kThreshold) turns_ -= profile::kCountsPerFlip;
    if (started_ && jump < -kThreshold) turns_ += profile::kCountsPerFlip;
    started_ = true;
    last_ = raw;
    return turns_ + raw;
  }

 private:
  static constexpr int16_t kThreshold = profile::kCountsPerFlip / 2;

  int32_t turns_ = 0;
  uint16_t last_ = 0;
  bool started_ = false;
};
