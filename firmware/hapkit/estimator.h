// Velocity from sensor counts in whole numbers: a third of the time that floats would take, and as exact.
#pragma once

#include <stdint.h>

#include "board.h"
#include "times.h"

namespace estimator {

// How often and how velocity is estimated, as the computer says it.
struct Loop {
  uint16_t period;    // [ticks of the board's clock]
  uint8_t estimator;  // protocol::kEstimator...
  float first;        // its coefficients
  float second;       // [1/s]
};

// Everything that depends on rate, method and sensor. The main program makes it, the tick uses it.
struct Design {
  uint32_t second;   // half of the coefficients, in 2^-32: of the speed
  uint32_t first;    // and of the place; whole where a filter follows no place
  int16_t fastest;   // limit of the speed, in counts per period
  uint16_t ticks;    // of the board's clock in one period
  uint8_t shown;     // periods to a frame of telemetry, so that none comes sooner than a millisecond
  float scale;       // m/s in 2^-16 counts per period
  float quantum;     // m in a count
};

constexpr int16_t kMostCounts = 4095;  // in one period; what jumps farther is no motion
constexpr float kOne = 65536.0f;       // a count

// Fill a design; return false, with nothing changed, for what no loop can have. quantum in m, fastest in m/s.
bool design(const Loop& loop, float quantum, float fastest, Design* made);

// Return a value times twice a half coefficient, up to six units too low: the product of the two lower halves counts
// for nothing. Both are numbers of 32 bits in two's complement, and so is the result. On the board in assembler.
uint32_t share(uint32_t value, uint32_t half) __asm__("estimator_share");

class Estimator {
 public:
  // Start as if the handle had rested at this count.
  void restart(int32_t count) {
    last_ = count;
    rest_ = speed_ = 0;
  }

  // Begin with another period: at rest, as the force fades in besides.
  void change() { rest_ = speed_ = 0; }

  // Take a count whose period is not the design's.
  void skip(int32_t count) { last_ = count; }

  // So many periods were missed: as if the handle had gone evenly to this count, which update() takes next.
  void miss(uint8_t periods, int32_t count);

  // Take the count one period later; return whether the handle is within its limit.
  bool update(const Design& design, int32_t count);

  // Return the velocity in m/s.
  float velocity(const Design& design) const { return times(speed(), design.scale); }

 private:
  int32_t speed() const { return static_cast<int32_t>(speed_); }

  // Sums wrap: coefficients that make a filter swing up are no reason for undefined steps.
  int32_t last_ = 0;
  uint32_t rest_ = 0;   // last count less the filter's own, 2^-16 counts
  uint32_t speed_ = 0;  // 2^-16 counts per period
};

}  // namespace estimator
