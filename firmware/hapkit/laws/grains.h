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

// The grains on both sides of a place last for many ticks.
struct Grains {
  uint16_t n;
  float seed;
  bool known;
  int16_t down;

  FAST_APART int16_t drop(uint16_t place, float now) {
    if (!known || place != n || now != seed) {
      n = place;
      seed = now;
      known = true;
      const uint8_t whole = static_cast<uint8_t>(static_cast<int16_t>(seed));
      down = static_cast<int16_t>(height(n, whole)) - height(n + 1, whole);
    }
    return down;
  }
};

inline float sandpaper() {
  static Grains grains = {0, 0.0f, false, 0};
  // beyond every scene: no force is right there
  if (!(fast::magnitude(with_u) < 32000.0f) || !(fast::magnitude(with_seed) < 256.0f)) return NAN;
  int32_t place = static_cast<int32_t>(with_u * 65536.0f);
  if (place < 0) place--;
  const uint16_t u = static_cast<uint16_t>(place);
  // 2 u (1 - u) in 2^-16, 4 of its squares in 2^-14
  const uint16_t bend = (static_cast<uint32_t>(u) * static_cast<uint16_t>(~u) >> 16) << 1;
  const uint16_t square = static_cast<uint32_t>(bend) * bend >> 16;
  const int16_t drop = grains.drop(static_cast<uint32_t>(place) >> 16, with_seed);
  return 2.4414062e-07f * with_amplitude * static_cast<float>(static_cast<int32_t>(square) * drop);
}

}  // namespace numbers
}  // namespace laws
