// The board's clock in microseconds, from the timer and the number of periods.
#pragma once

#include <stdint.h>

class Clock {
 public:
  // Return the time in us of a stamp in half microseconds. A stamp wraps at half the range of the time; it
  // must be less than 17 minutes from the last stamp.
  uint32_t us_of(uint32_t stamp) {
    const bool back = static_cast<int32_t>(stamp - last_) < 0;
    if (back != (stamp < last_)) upper_ = !upper_;
    last_ = stamp;
    return stamp >> 1 | (upper_ ? 0x80000000 : 0);
  }

 private:
  uint32_t last_ = 0;
  bool upper_ = false;  // the highest bit of the time
};
