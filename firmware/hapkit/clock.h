// The board's clock: what the timer and the periods before it have counted, in microseconds.
#pragma once

#include <stdint.h>

class Clock {
 public:
  // Return the time of a stamp, quarters of a millisecond in its upper half and half microseconds in its lower: less
  // than 8 s away from the last one.
  uint32_t us_of(uint32_t stamp) {
    const uint16_t quarters = stamp >> 16;
    us_ += static_cast<int16_t>(quarters - quarters_) * INT32_C(250);
    quarters_ = quarters;
    return us_ + static_cast<uint16_t>(stamp) / 2;
  }

 private:
  uint32_t us_ = 0;  // at the beginning of the period of the last stamp
  uint16_t quarters_ = 0;
};
