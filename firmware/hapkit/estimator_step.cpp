#include "estimator.h"

namespace estimator {
namespace {

#ifndef __AVR__
// Sums wrap, as on the board: coefficients that make a filter swing up are no reason for undefined steps.
int32_t wrapped(int64_t value) { return static_cast<int32_t>(static_cast<uint32_t>(value)); }

// Return value times twice a half coefficient, rounded.
int64_t share(int64_t value, uint32_t half) { return (value * half + 0x40000000) >> 31; }
#endif

}  // namespace

void Estimator::change(uint8_t quarters_before, uint8_t quarters) {
  for (; quarters_before < quarters; quarters_before <<= 1) {
    speed_ = static_cast<int32_t>(static_cast<uint32_t>(speed_) << 1);
  }
  for (; quarters_before > quarters; quarters_before >>= 1) speed_ >>= 1;
  rest_ = 0;
}

// After a single one, a division would take so long that the next one might be missed for its sake.
void Estimator::miss(uint8_t periods, int32_t count) {
  const int32_t moved = count - last_;
  last_ = count - (periods == 1 ? moved >> 1 : moved / (periods + 1));
}

#ifndef __AVR__
bool Estimator::step(Estimator* self, const Design* design, int32_t count) {
  const int32_t steps = count - self->last_;
  self->last_ = count;
  if (steps > kMostCounts || steps < ~kMostCounts) {
    self->rest_ = self->speed_ = 0;
    return false;
  }
  const int32_t all = wrapped(steps * INT64_C(65536) - self->speed_ + self->rest_);
  self->rest_ = wrapped(all - share(all, design->first));
  self->speed_ = wrapped(self->speed_ + share(all, design->second));
  const int32_t whole = self->speed_ >> 16;
  return whole < design->fastest && whole >= -design->fastest;
}
#endif

}  // namespace estimator
