// Velocity from sensor counts. It is computed with integers, which takes a third of the time of floats and is
// equally accurate.
#pragma once

#include <stdint.h>

#include "board.h"
#include "times.h"

namespace estimator {

// The rate and the method of the velocity estimation, as the computer sends them.
struct Loop {
  uint16_t period;    // [ticks of the board's clock]
  uint8_t estimator;  // protocol::kEstimator...
  float first;        // first coefficient
  float second;       // second coefficient [1/s]
};

// Constants derived from rate, method and sensor. The main program computes them; the tick uses them.
struct Design {
  uint32_t second;   // half the coefficient of the speed, in 2^-32
  // half the coefficient of the position; an integer for filters that have no position state
  uint32_t first;
  int16_t fastest;   // limit of the speed, in counts per period
  uint16_t ticks;    // ticks of the board's clock in one period
  uint8_t shown;     // number of ticks per frame of telemetry; a frame covers at least a millisecond
  float scale;       // m/s per 2^-16 counts per period
  float quantum;     // travel per count [m]
};

constexpr int16_t kMostCounts = 4095;  // counts in one period; a larger jump is not a motion
constexpr float kOne = 65536.0f;       // fixed-point value of one count

// Fill a design; return false without changes if a value is invalid. quantum is in m, fastest in m/s.
bool design(const Loop& loop, float quantum, float fastest, Design* made);

// Return a value times a coefficient, of which half is given. The result is up to six units too low, because
// the product of the lower halves is ignored. The numbers are 32-bit two's complement. On the board this is
// written in assembler.
uint32_t share(uint32_t value, uint32_t half) __asm__("estimator_share");

class Estimator {
 public:
  // Start as if the handle had rested at this count.
  void restart(int32_t count) {
    last_ = count;
    rest_ = speed_ = 0;
  }

  // Restart with a different period. The speed may start at 0, because the force fades in.
  void change() { rest_ = speed_ = 0; }

  // Process a count after an irregular period.
  void skip(int32_t count) { last_ = count; }

  // Assume uniform motion over the missed periods up to this count, which update() processes next.
  void miss(uint8_t periods, int32_t count);

  // Process the count one period later; return true if the handle does not exceed its speed limit.
  bool update(const Design& design, int32_t count);

  // Return the velocity in m/s.
  float velocity(const Design& design) const { return times(speed(), design.scale); }

 private:
  int32_t speed() const { return static_cast<int32_t>(speed_); }

  // These sums wrap, because unstable coefficients must not cause undefined behaviour.
  int32_t last_ = 0;
  uint32_t rest_ = 0;   // last count minus the position of the filter, in 2^-16 counts
  uint32_t speed_ = 0;  // 2^-16 counts per period
};

}  // namespace estimator
