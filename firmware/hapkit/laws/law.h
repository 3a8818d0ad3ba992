// What every translated law uses: several values at once, faults, inverses that are kept.
// For one translation unit; a law runs to its end before another begins.
#pragma once

#include <math.h>
#include <stdint.h>

#include "../fast.h"

namespace laws {

// What a function gives back that returns several numbers.
template <uint8_t n>
struct Several {
  float at[n];
};

// Whether the law divided by zero, indexed outside its state or turned too often since begin().
static bool fault = false;
static uint16_t turns_left = 0;

inline void begin(uint16_t turns = 0) {
  fault = false;
  turns_left = turns;
}

// Take one turn of a loop; true if there was none left, or the law has a fault anyway.
inline bool spent() {
  if (turns_left == 0) fault = true;
  else turns_left--;
  return fault;
}

// A law with a fault has no force: the board refuses what is not a number.
inline float checked(float force) { return fault ? NAN : force; }

inline float divisor(float b) {
  if (b == 0.0f) fault = true;
  return b;
}

inline uint8_t index(float i, uint8_t size) {
  if (i >= 0.0f && i < size) return static_cast<uint8_t>(i);
  fault = true;
  return 0;
}

// The inverse of what seldom changes: comparing is far cheaper than dividing.
struct Inverse {
  uint32_t key;
  float value;

  float of(float b) {
    const uint32_t bits = fast::bits(b);
    if (bits != key) {
      key = bits;
      value = 1.0f / b;
    }
    return value;
  }

  float watched(float b) {
    if (b == 0.0f) fault = true;
    return of(b);
  }
};

}  // namespace laws

// The bits of no finite number: the first inverse is always reckoned.
#define LAWS_NO_INVERSE {0xffffffffUL, 0.0f}
