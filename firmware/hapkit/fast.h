// Single precision for a chip without floating point: what is cheaper by bits, by tables, or both.
// The same code runs on a PC, where the tests hold it against double precision.
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "fast_tables.h"

// What is called from many places is there once: a chip of 32 KB holds all laws only so.
#ifdef __AVR__
#define FAST_APART __attribute__((noinline))
#else
#define FAST_APART
#endif
#define FAST_ONCE inline FAST_APART

namespace fast {

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

// A number of 24 bits in a table, on a PC.
inline uint32_t read(const uint8_t* at) { return at[0] | at[1] << 8 | static_cast<uint32_t>(at[2]) << 16; }

inline int16_t read(const int16_t* table) {
#ifdef __AVR__
  return static_cast<int16_t>(pgm_read_word(table));
#else
  return *table;
#endif
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

template <int8_t n>
inline float scaled(float x) {
  return scale(x, n);
}

// As Python has them: the first where neither is less, or greater.
inline float least(float a, float b) { return b < a ? b : a; }
inline float most(float a, float b) { return b > a ? b : a; }

template <uint8_t n>
inline float power(float x) {
  return n == 2 ? x * x : n == 3 ? x * x * x : (x * x) * (x * x);
}

namespace detail {

// A table's value d / 2^16 of the way from one point to the next, on the straight line, in the lower 24 bits;
// the upper 8 say how far the curve lies beside it: d (1 - d) times the value.
FAST_ONCE uint32_t between(const uint8_t* table, uint16_t d) {
#ifdef __AVR__
  uint32_t found;
  uint8_t a0, a1, s0, s1, s2;
  // a: the value, of 24 bits; s: the step, of 18
  asm("lpm %[a0], Z+\n\t lpm %[a1], Z+\n\t lpm %C[r], Z+\n\t"
      "lpm %[s0], Z+\n\t lpm %[s1], Z+\n\t lpm %[s2], Z\n\t"
      "sub %[s0], %[a0]\n\t sbc %[s1], %[a1]\n\t sbc %[s2], %C[r]\n\t"
      // d (1 - d) in 8 bits, times the value's upper ones
      "mov %D[r], %B[d]\n\t com %D[r]\n\t mul %D[r], %B[d]\n\t"
      "lsl r0\n\t rol r1\n\t lsl r0\n\t rol r1\n\t mul r1, %C[r]\n\t mov %D[r], r1\n\t"
      "mul %[s0], %A[d]\n\t mov r30, r1\n\t clr r31\n\t"
      "mul %[s0], %B[d]\n\t add r30, r0\n\t adc r31, r1\n\t"
      "mul %[s1], %A[d]\n\t add r30, r0\n\t adc r31, r1\n\t clr %[s0]\n\t adc %[s0], %[s0]\n\t"
      "mul %[s1], %B[d]\n\t add r31, r0\n\t adc %[s0], r1\n\t"
      "mul %[s2], %A[d]\n\t add r31, r0\n\t adc %[s0], r1\n\t clr %[s1]\n\t adc %[s1], %[s1]\n\t"
      "mul %[s2], %B[d]\n\t add %[s0], r0\n\t adc %[s1], r1\n\t clr r1\n\t"
      "mov %A[r], %[a0]\n\t mov %B[r], %[a1]\n\t"
      "add %A[r], r31\n\t adc %B[r], %[s0]\n\t adc %C[r], %[s1]"
      : [r] "=&r"(found), [a0] "=&r"(a0), [a1] "=&r"(a1), [s0] "=&r"(s0), [s1] "=&r"(s1), [s2] "=&r"(s2),
        [z] "+&z"(table)
      : [d] "r"(d));
  return found;
#else
  const uint32_t a = read(table), step = read(table + 3) - a;
  const uint8_t d8 = static_cast<uint8_t>(d >> 8);
  const uint8_t hill = static_cast<uint8_t>(d8 * (255 - d8) >> 6);
  const uint32_t bent = static_cast<uint32_t>(hill) * (a >> 16) >> 8;
  return (a + static_cast<uint32_t>(static_cast<uint64_t>(step) * d >> 16)) | bent << 24;
#endif
}

}  // namespace detail

// The whole number below or at x.
FAST_ONCE float floor(float x) {
  uint32_t b = bits(x);
  const uint8_t e = exponent(b);
  if (e < 127) return (b << 1) == 0 ? x : (b & kSign) ? -1.0f : 0.0f;
  if (e > 149) return x;
  uint32_t behind = 0x7fffff;
  for (uint8_t n = e - 127; n; n--) behind >>= 1;
  if ((b & kSign) && (b & behind)) b += behind;
  return number(b & ~behind);
}

inline float ceil(float x) { return -floor(-x); }

FAST_ONCE float trunc(float x) { return (bits(x) & kSign) ? -floor(-x) : floor(x); }

inline float remainder(float a, float b) { return fmodf(a, b); }

// a % b and a // b as Python has them: towards minus infinity.
FAST_ONCE float modulo(float a, float b) {
  const float rest = fmodf(a, b);
  if (rest == 0.0f) return signed_as(0.0f, b);
  return (rest < 0.0f) != (b < 0.0f) ? rest + b : rest;
}

FAST_ONCE float floor_division(float a, float b) {
  const float rest = fmodf(a, b);
  float quotient = (a - rest) / b;
  if (rest != 0.0f && (rest < 0.0f) != (b < 0.0f)) quotient -= 1.0f;
  const float below = floor(quotient);
  return quotient - below > 0.5f ? below + 1.0f : below;
}

// The 24 bits of a number without its sign, so many places further up or, if negative, down.
FAST_ONCE uint32_t shifted(uint32_t b, int16_t places) {
  if (places >= 32 || places <= -24) return 0;
  uint32_t found = (b & 0x7fffffUL) | 0x800000UL;
  int8_t left = static_cast<int8_t>(places);
  for (; left >= 8; left -= 8) found <<= 8;
  for (; left <= -8; left += 8) found >>= 8;
  for (; left > 0; left--) found <<= 1;
  for (; left < 0; left++) found >>= 1;
  return found;
}

// The part of a number behind the point, in 2^-32; of a negative one the rest to the next whole number.
FAST_ONCE uint32_t phase_of(float turns) {
  const uint32_t b = bits(turns);
  const uint32_t phase = shifted(b, static_cast<int16_t>(exponent(b)) - 118);
  return (b & kSign) ? 0 - phase : phase;
}

// sin of a phase in 2^-32 turns, within 4e-6.
FAST_ONCE float sine_of(uint32_t phase) {
  const uint32_t sign = phase & kSign;
  if (phase & 0x40000000UL) phase = ~phase;
  const uint8_t place = static_cast<uint8_t>(phase >> 24) & 63;
  const uint16_t d = static_cast<uint16_t>(phase >> 8);
  const uint32_t found = detail::between(kSine + 3 * place, d);
  const uint32_t value = (found & 0xffffffUL) + static_cast<uint16_t>(static_cast<uint8_t>(found >> 24) * 5);
  if (value == 0) return 0.0f;
  return number((bits(static_cast<float>(static_cast<int32_t>(value))) - (23UL << 23)) | sign);
}

FAST_ONCE float sin_of_turns(float turns) {
  if (exponent(bits(turns)) == 255) return NAN;
  return sine_of(phase_of(turns));
}

FAST_ONCE float cos_of_turns(float turns) {
  if (exponent(bits(turns)) == 255) return NAN;
  return sine_of(phase_of(turns) + 0x40000000UL);
}

constexpr float kTurns = 0.15915494309189535f;  // turns in a radian

FAST_ONCE float sin(float x) { return sin_of_turns(x * kTurns); }
FAST_ONCE float cos(float x) { return cos_of_turns(x * kTurns); }

// e^x, within 1.5e-6 of itself for |x| <= 8, beyond that within 2e-7 |x| more.
FAST_ONCE float exp(float x) {
  const uint32_t b = bits(x * 1.4426950408889634f);
  const uint8_t e = exponent(b);
  if (e >= 134) return (b << 1) > 0xff000000UL ? NAN : (b & kSign) ? 0.0f : INFINITY;
  uint32_t t = shifted(b, static_cast<int16_t>(e) - 128);
  if (b & kSign) t = ~t;
  const int16_t upper = static_cast<int16_t>(t >> 16);
  if (upper < -126 * 64) return 0.0f;
  const uint32_t found = detail::between(kPower + 3 * (upper & 63), static_cast<uint16_t>(t));
  const uint16_t power = static_cast<uint16_t>((upper >> 6) + 126) << 7;
  const uint32_t value = (found & 0xffffffUL) - static_cast<uint8_t>(found >> 24);
  return number((static_cast<uint32_t>(power) << 16) + value);
}

// tanh within 1e-6.
FAST_ONCE float tanh(float x) {
  const float a = magnitude(x);
  if (!(a < 9.0f)) return a != a ? x : signed_as(1.0f, x);
  return signed_as(1.0f - 2.0f / (exp(scaled<1>(a)) + 1.0f), x);
}

FAST_ONCE float expm1(float x) {
  if (magnitude(x) > 0.125f) return exp(x) - 1.0f;
  return x * (1.0f + x * 0.5f * (1.0f + x * 0.33333333f * (1.0f + x * 0.25f * (1.0f + x * 0.2f))));
}

FAST_ONCE float log1p(float x) {
  const float up = 1.0f + x;
  return up == 1.0f ? x : isinf(up) ? up : logf(up) * (x / (up - 1.0f));
}

inline float sqrt(float x) { return sqrtf(x); }
inline float tan(float x) { return tanf(x); }
inline float asin(float x) { return asinf(x); }
inline float acos(float x) { return acosf(x); }
inline float atan(float x) { return atanf(x); }
inline float atan2(float y, float x) { return atan2f(y, x); }
inline float log(float x) { return logf(x); }
inline float sinh(float x) { return sinhf(x); }
inline float cosh(float x) { return coshf(x); }
inline float hypot(float x, float y) { return hypotf(x, y); }
inline float power_of(float x, float y) { return powf(x, y); }

}  // namespace fast
