#include "estimator.h"

#include "board.h"
#include "protocol.h"

namespace estimator {
namespace {

constexpr uint32_t kWhole = 0x80000000;
constexpr uint32_t kNone = 0xffffffff;

// Convert a coefficient for Design; return kNone unless 0 <= value < 2.
__attribute__((noinline)) uint32_t half(float value) {
  return value >= 0.0f && value < 2.0f ? static_cast<uint32_t>(value * 2147483648.0f) : kNone;
}

}  // namespace

#ifndef __AVR__
uint32_t share(uint32_t value, uint32_t half) {
  const uint16_t high = value >> 16, low = static_cast<uint16_t>(value);
  const uint16_t large = half >> 16, small = static_cast<uint16_t>(half);
  const auto product = [](uint16_t a, uint16_t b) { return static_cast<uint32_t>(a) * b; };
  uint32_t sum = product(high, large) + (product(low, large) >> 16) + (product(high, small) >> 16);
  if (high & 0x8000) sum -= half;  // a negative value
  return sum << 1;
}
#endif

bool design(const Loop& loop, float quantum, float fastest, Design* made) {
  const uint16_t ticks = loop.period;
  if (ticks < board::kShortest || ticks > board::kLongest) return false;
  if (loop.estimator > protocol::kEstimatorKalman) return false;
  const float period = ticks * (1e-6f * board::kTickUs);
  uint32_t first = kWhole, second = kWhole;
  if (loop.estimator != protocol::kEstimatorDifference) {
    first = second = half(loop.first);
    if (first > kWhole) return false;
    if (loop.estimator == protocol::kEstimatorKalman) second = half(loop.second * period);
    else first = kWhole;
    if (second == kNone) return false;
  }
  made->ticks = ticks;
  made->shown = 1;
  for (uint16_t passed = ticks; passed < board::kTicksPerMs; passed += ticks) ++made->shown;
  made->first = first;
  made->second = second;
  made->scale = quantum / (period * kOne);
  made->quantum = quantum;
  const float limit = fastest * period / quantum;
  made->fastest = limit < kMostCounts ? static_cast<int16_t>(limit) + 1 : kMostCounts;
  return true;
}

// After one missed period a shift replaces the division: a division takes so long that the next period might
// be missed.
void Estimator::miss(uint8_t periods, int32_t count) {
  const int32_t moved = count - last_;
  last_ = count - (periods == 1 ? moved >> 1 : moved / (periods + 1));
}

bool Estimator::update(const Design& design, int32_t count) {
  const int32_t steps = count - last_;
  last_ = count;
  if (steps > kMostCounts || steps < ~kMostCounts) {
    rest_ = speed_ = 0;
    return false;
  }
  const uint32_t all = (static_cast<uint32_t>(steps) << 16) - speed_ + rest_;
  rest_ = all - share(all, design.first);
  speed_ += share(all, design.second);
  const int16_t whole = static_cast<int16_t>(speed_ >> 16);
  return whole < design.fastest && whole >= -design.fastest;
}

}  // namespace estimator
