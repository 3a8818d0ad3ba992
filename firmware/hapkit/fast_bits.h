// Floats by their bits: signs, comparisons with zero, powers of two.
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

// What is called from many places is there once: a chip of 32 KB holds all laws only so.
#ifdef __AVR__
#define FAST_APART __attribute__((noinline))
#else
#define FAST_APART
#endif
#define FAST_ONCE inline FAST_APART

namespace fast {

#ifdef __AVR__
namespace detail {
extern "C" {  // fast_avr.S
uint32_t fast_shifted(uint32_t bits, int8_t places);
float fast_floor(float x);
float fast_sine(float turns, const uint8_t* table, uint8_t quarter);
float fast_power(float x, const uint8_t* table);
float fast_power_of_square(float x, const uint8_t* table, uint16_t factor, int8_t places);
}
}  // namespace detail
#endif

inline uint32_t bits(float x) {
  uint32_t b;
  memcpy(&b, &x, sizeof b);
  return b;
}

inline float number(uint32_t b) {
  float x;
  memcpy(&x, &b, sizeof x);
  return x;
}

constexpr uint32_t kSign = 0x80000000UL;

inline float magnitude(float x) { return number(bits(x) & ~kSign); }

// |x| with the sign of another number.
inline float signed_as(float x, float other) {
  return number((bits(x) & ~kSign) | (bits(other) & kSign));
}

// x * sign for a sign of 1 or -1.
inline float flipped(float x, float sign) { return number(bits(x) ^ (bits(sign) & kSign)); }

inline float flipped_by(float x, int8_t sign) { return sign < 0 ? number(bits(x) ^ kSign) : x; }

// Whether x is a certain number other than zero: far fewer steps than ==.
inline bool is(float x, float other) { return bits(x) == bits(other); }

FAST_ONCE bool is_zero(float x) { return (bits(x) << 1) == 0; }

// x < 0, x > 0, x <= 0, x >= 0; never so for what is not a number.
FAST_ONCE bool above_zero(float x) {
  return bits(x) - 1 < 0x7f800000UL;
}
inline bool below_zero(float x) { return above_zero(-x); }
FAST_ONCE bool from_zero(float x) { return above_zero(x) || is_zero(x); }
inline bool to_zero(float x) { return from_zero(-x); }

// |x| > most for a most that is not negative: there numbers compare as their bits do.
FAST_ONCE bool larger(float x, float most) { return bits(magnitude(x)) > bits(most); }

inline uint8_t exponent(uint32_t b) {
  return static_cast<uint8_t>(static_cast<uint8_t>(b >> 24) << 1 | static_cast<uint8_t>(b >> 16) >> 7);
}

// x * 2^n for |n| <= 30; what is below 2^-94 is taken for 0, above 2^95 for infinite.
FAST_ONCE float scale(float x, int8_t n) {
  const uint32_t b = bits(x);
  const uint8_t e = exponent(b);
  if (e < 33) return 0.0f;
  if (e > 222) return e == 255 ? x : signed_as(INFINITY, x);
  // n * 2^23 touches the upper half only
  return number(b + (static_cast<uint32_t>(static_cast<uint16_t>(n) << 7) << 16));
}

// 2 x and x / 2 in half the time; what has no exponent beside it stays as it is.
FAST_ONCE float doubled(float x) {
  const uint32_t b = bits(x);
  return static_cast<uint8_t>(exponent(b) + 1) < 2 ? x : number(b + 0x800000UL);
}
FAST_ONCE float halved(float x) {
  const uint32_t b = bits(x);
  return static_cast<uint8_t>(exponent(b) + 1) < 2 ? x : number(b - 0x800000UL);
}

template <int8_t n>
inline float scaled(float x) {
  return n == 1 ? doubled(x) : n == -1 ? halved(x) : scale(x, n);
}

// As Python has them: the first where neither is less, or greater.
inline float least(float a, float b) { return b < a ? b : a; }
inline float most(float a, float b) { return b > a ? b : a; }

template <uint8_t n>
inline float power(float x) {
  return n == 2 ? x * x : n == 3 ? x * x * x : (x * x) * (x * x);
}

// The 24 bits of a number without its sign, so many places further up or, if negative, down.
inline uint32_t shifted(uint32_t b, int16_t places) {
  if (places >= 32 || places <= -24) return 0;
#ifdef __AVR__
  return detail::fast_shifted(b, static_cast<int8_t>(places));
#else
  uint32_t found = (b & 0x7fffffUL) | 0x800000UL;
  int8_t left = static_cast<int8_t>(places);
  for (; left >= 8; left -= 8) found <<= 8;
  for (; left <= -8; left += 8) found >>= 8;
  for (; left > 0; left--) found <<= 1;
  for (; left < 0; left++) found >>= 1;
  return found;
#endif
}

}  // namespace fast
