#pragma GCC optimize("O2")  // also for what is included

#include "estimator.h"

namespace estimator {
namespace {

// Return value * half / 2^32, rounded, within two units where the value is 2^16 or more.
//
// In bytes v3 v2 v1 v0 and h3 h2 h1 h0: what lies below the result is left out but for v1 v0 * h3 h2. The
// compiler would take four times as long.
inline uint32_t share(uint32_t value, uint32_t half) {
#ifdef __AVR__
  uint32_t result;
  uint8_t below, zero;
  __asm__(
      "clr %2\n\t"
      "mul %A3, %C4\n\tmov %1, r1\n\t"
      "mul %B3, %D4\n\tmovw %A0, r0\n\tclr %C0\n\tclr %D0\n\t"
      "mul %A3, %D4\n\tadd %1, r0\n\tadc %A0, r1\n\tadc %B0, %2\n\t"
      "mul %B3, %C4\n\tadd %1, r0\n\tadc %A0, r1\n\tadc %B0, %2\n\t"
      "lsl %1\n\tadc %A0, %2\n\tadc %B0, %2\n\tadc %C0, %2\n\t"
      "mov r0, %C3\n\tor r0, %D3\n\tbreq 1f\n\t"
      "mul %C3, %C4\n\tadd %A0, r0\n\tadc %B0, r1\n\tadc %C0, %2\n\tadc %D0, %2\n\t"
      "mul %D3, %B4\n\tadd %A0, r0\n\tadc %B0, r1\n\tadc %C0, %2\n\tadc %D0, %2\n\t"
      "mul %C3, %B4\n\tadd %A0, r1\n\tadc %B0, %2\n\tadc %C0, %2\n\tadc %D0, %2\n\t"
      "mul %D3, %A4\n\tadd %A0, r1\n\tadc %B0, %2\n\tadc %C0, %2\n\tadc %D0, %2\n\t"
      "mul %C3, %D4\n\tadd %B0, r0\n\tadc %C0, r1\n\tadc %D0, %2\n\t"
      "mul %D3, %C4\n\tadd %B0, r0\n\tadc %C0, r1\n\tadc %D0, %2\n\t"
      "mul %D3, %D4\n\tadd %C0, r0\n\tadc %D0, r1\n"
      "1:\tclr __zero_reg__"
      : "=&r"(result), "=&r"(below), "=&r"(zero)
      : "r"(value), "r"(half));
  return result;
#else
  const uint32_t low = value & 0xffff, high = value >> 16, coarse = half >> 16, fine = half & 0xffff;
  const uint32_t part = low * coarse - ((low & 0xff) * (coarse & 0xff) & 0xff);
  const uint32_t whole = (part >> 16) + ((part >> 15) & 1);
  return whole + high * coarse + (high >> 8) * (fine >> 8) + ((high & 0xff) * (fine >> 8) >> 8) +
         ((high >> 8) * (fine & 0xff) >> 8);
#endif
}

// Sum and difference that wrap: coefficients that make a filter swing up are no reason for undefined steps.
inline int32_t sum(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}

inline int32_t difference(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b));
}

// Return value times twice a half coefficient, rounded alike on both sides of zero.
int32_t scaled(int32_t value, uint32_t half) {
  const bool negative = value < 0;
  const uint32_t twice = static_cast<uint32_t>(negative ? difference(0, value) : value) << 1;
  const int32_t result = static_cast<int32_t>(share(twice, half));
  return negative ? difference(0, result) : result;
}

}  // namespace

void Estimator::change(uint8_t quarters_before, uint8_t quarters) {
  for (; quarters_before < quarters; quarters_before <<= 1) speed_ = sum(speed_, speed_);
  for (; quarters_before > quarters; quarters_before >>= 1) speed_ /= 2;
  rest_ = 0;
}

bool Estimator::update(const Design& design, int32_t count, uint8_t periods) {
  int32_t moved = count - last_;
  last_ = count;
  if (periods > 1) moved /= periods;
  const int16_t steps = static_cast<int16_t>(moved);
  if (steps != moved || steps > kMostCounts || steps < -kMostCounts) {
    speed_ = rest_ = 0;
    return false;
  }
  int32_t speed = speed_;
  const int32_t surprise = difference(static_cast<int32_t>(static_cast<uint32_t>(steps) << 16), speed);
  if (design.method == protocol::kEstimatorDifference) {
    speed = sum(speed, surprise);
  } else if (design.method == protocol::kEstimatorIir) {
    speed = sum(speed, scaled(surprise, design.first));
  } else {
    const int32_t all = sum(surprise, rest_);
    rest_ = difference(all, scaled(all, design.first));
    speed = sum(speed, scaled(all, design.second));
  }
  speed_ = speed;
  const int16_t whole = static_cast<int16_t>(speed >> 16);
  return whole < design.fastest && whole >= -design.fastest;
}

}  // namespace estimator
