// Sandpaper, written for the board: hapkit_studio.dynamics.grains.sandpaper in whole numbers.
// In floating point the cubes would take longer than the rest of the tick.
#pragma once

#include "law.h"

namespace laws {
namespace numbers {

// The arguments of sandpaper(), as its caller sets them.
static float with_u, with_amplitude, with_seed;

// n modulo 251: 256 leaves 5.
FAST_ONCE uint8_t wrapped(uint16_t n) {
  n = static_cast<uint8_t>(n >> 8) * 5 + static_cast<uint8_t>(n);
  n = static_cast<uint8_t>(n >> 8) * 5 + static_cast<uint8_t>(n);
  return n >= 251 ? n - 251 : n;
}

FAST_ONCE uint8_t cubed(uint8_t m) {
  return wrapped(static_cast<uint16_t>(wrapped(static_cast<uint16_t>(m) * m)) * m);
}

// Return the height, 0 to 250, of one of the 32 thousand grains on either side.
FAST_ONCE uint8_t height(uint16_t n, uint8_t seed) {
  n = wrapped(n + 130 * 251u);
  const uint8_t m = cubed(wrapped(n + static_cast<uint16_t>(seed) * 17));
  return cubed(wrapped(static_cast<uint16_t>(m) + seed + 1));
}

// The grains on both sides of a place last for many ticks, and from one place to the next one of them stays.
struct Grains {
  uint16_t n;
  uint32_t seed;  // its bits
  bool known;
  uint8_t before, after;
  int16_t down;  // from one to the other, 2^14 for all that there is

  FAST_APART int16_t drop(uint16_t place, uint32_t now) {
    const bool same = known && now == seed;
    if (!same || place != n) {
      const uint8_t whole = static_cast<uint8_t>(static_cast<int16_t>(fast::number(now)));
      const uint8_t left = same && place == static_cast<uint16_t>(n + 1) ? after : height(place, whole);
      after = same && place == static_cast<uint16_t>(n - 1) ? before : height(place + 1, whole);
      before = left;
      n = place;
      seed = now;
      known = true;
      down = (static_cast<int16_t>(before) - after) * 16777L >> 8;
    }
    return down;
  }
};

inline float sandpaper() {
  static Grains grains = {0, 0, false, 0, 0, 0};
  const uint32_t u_bits = fast::bits(with_u);
  const uint8_t e = fast::exponent(u_bits);
  if (e > 141 || fast::exponent(fast::bits(with_seed)) > 134) return NAN;
  uint32_t place = fast::shifted(u_bits, static_cast<int16_t>(e) - 134);  // in 2^-16
  if (u_bits & fast::kSign) place = ~place;
  const int16_t n = static_cast<int16_t>(place >> 16);
  if (n < -32000 || n >= 32000) return NAN;  // beyond every scene: no force is right there
  const uint16_t u = static_cast<uint16_t>(place);
  // 2 u (1 - u) in 2^-16, 4 of its squares in 2^-14
  const uint16_t bend = (static_cast<uint32_t>(u) * static_cast<uint16_t>(~u) >> 16) << 1;
  const uint16_t square = static_cast<uint32_t>(bend) * bend >> 16;
  const int32_t push = static_cast<int32_t>(square) * grains.drop(n, fast::bits(with_seed));
  if (push == 0) return 0.0f;
  return with_amplitude * fast::number(fast::bits(static_cast<float>(push)) - (28UL << 23));
}

}  // namespace numbers
}  // namespace laws
