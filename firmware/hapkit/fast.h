// Single precision for a chip without floating point: what is cheaper by bits, by tables, or both.
// The same values come out on a PC, where the tests hold them against double precision.
#pragma once

#include "fast_bits.h"
#include "fast_tables.h"

namespace fast {

// The whole number below or at x.
inline float floor(float x) {
#ifdef __AVR__
  return detail::fast_floor(x);
#else
  uint32_t b = bits(x);
  const uint8_t e = exponent(b);
  if (e < 127) return (b << 1) == 0 ? x : (b & kSign) ? -1.0f : 0.0f;
  if (e > 149) return x;
  uint32_t behind = 0x7fffff;
  for (uint8_t n = e - 127; n; n--) behind >>= 1;
  if ((b & kSign) && (b & behind)) b += behind;
  return number(b & ~behind);
#endif
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

#ifndef __AVR__

namespace detail {

// A number of 24 bits in a table.
inline uint32_t read(const uint8_t* at) { return at[0] | at[1] << 8 | static_cast<uint32_t>(at[2]) << 16; }

// A table's value d / 2^16 of the way from one point to the next, on the straight line, in the lower 24 bits;
// the upper 8 say how far the curve lies beside it: d (1 - d) times the value.
inline uint32_t between(const uint8_t* table, uint16_t d) {
  const uint32_t a = read(table), step = read(table + 3) - a;
  const uint8_t d8 = static_cast<uint8_t>(d >> 8);
  const uint8_t hill = static_cast<uint8_t>(d8 * (255 - d8) >> 6);
  const uint32_t bent = static_cast<uint32_t>(hill) * (a >> 16) >> 8;
  return (a + static_cast<uint32_t>(static_cast<uint64_t>(step) * d >> 16)) | bent << 24;
}

}  // namespace detail

// The part of a number behind the point, in 2^-32; of a negative one the rest to the next whole number.
inline uint32_t phase_of(float turns) {
  const uint32_t b = bits(turns);
  const uint32_t phase = shifted(b, static_cast<int16_t>(exponent(b)) - 118);
  return (b & kSign) ? 0 - phase : phase;
}

// sin of a phase in 2^-32 turns, within 4e-6.
inline float sine_of(uint32_t phase) {
  const uint32_t sign = phase & kSign;
  if (phase & 0x40000000UL) phase = ~phase;
  const uint8_t place = static_cast<uint8_t>(phase >> 24) & 63;
  const uint16_t d = static_cast<uint16_t>(phase >> 8);
  const uint32_t found = detail::between(kSine + 3 * place, d);
  const uint32_t value = (found & 0xffffffUL) + static_cast<uint16_t>(static_cast<uint8_t>(found >> 24) * 5);
  if (value == 0) return 0.0f;
  return number((bits(static_cast<float>(static_cast<int32_t>(value))) - (23UL << 23)) | sign);
}

#endif

// The sine of turns and a number of 256ths of one more, within 4e-6.
inline float sine(float turns, uint8_t more) {
#ifdef __AVR__
  return detail::fast_sine(turns, kSine, more);
#else
  if (exponent(bits(turns)) == 255) return NAN;
  return sine_of(phase_of(turns) + (static_cast<uint32_t>(more) << 24));
#endif
}

FAST_ONCE float sin_of_turns(float turns) { return sine(turns, 0); }
FAST_ONCE float cos_of_turns(float turns) { return sine(turns, 64); }

constexpr float kTurns = 0.15915494309189535f;  // turns in a radian

FAST_ONCE float sin(float x) { return sin_of_turns(x * kTurns); }
FAST_ONCE float cos(float x) { return cos_of_turns(x * kTurns); }

#ifndef __AVR__

// 2^t for t < 128 in 2^-22, within 1.5e-6 of itself.
inline float power_of_two(uint32_t t) {
  const int16_t upper = static_cast<int16_t>(t >> 16);
  if (upper < -126 * 64) return 0.0f;
  const uint32_t found = detail::between(kPower + 3 * (upper & 63), static_cast<uint16_t>(t));
  const uint16_t power = static_cast<uint16_t>((upper >> 6) + 126) << 7;
  const uint32_t value = (found & 0xffffffUL) - static_cast<uint8_t>(found >> 24);
  return number((static_cast<uint32_t>(power) << 16) + value);
}

inline float power_of_two(float x) {
  const uint32_t b = bits(x);
  const uint8_t e = exponent(b);
  if (e >= 134) return (b << 1) > 0xff000000UL ? NAN : (b & kSign) ? 0.0f : INFINITY;
  const uint32_t t = shifted(b, static_cast<int16_t>(e) - 128);
  return power_of_two((b & kSign) ? ~t : t);
}

// 2^(-x^2 factor 2^places / 2^15) for a factor of 2^15 or more.
inline float power_of_square(float x, uint16_t factor, int8_t places) {
  const uint32_t b = bits(x) + 0x80;  // to the nearest of 16 bits
  const uint16_t m = static_cast<uint16_t>(b >> 8) | 0x8000;
  const uint16_t square = static_cast<uint16_t>((static_cast<uint32_t>(m) * m + 0x8000) >> 16);
  // in 2^-22 it lies so many places further down
  const int16_t down = 2 * 127 + 7 - 2 * static_cast<int16_t>(exponent(b)) - places;
  if (down < 1) return (b << 1) > 0xff000100UL ? NAN : 0.0f;
  if (down > 31) return 1.0f;
  return power_of_two(~(static_cast<uint32_t>(square) * factor >> down));
}

#endif

// e^x, within 1.5e-6 of itself for |x| <= 8, beyond that within 2e-7 |x| more.
FAST_ONCE float exp(float x) {
  const float power = x * 1.4426950408889634f;
#ifdef __AVR__
  return detail::fast_power(power, kPower);
#else
  return power_of_two(power);
#endif
}

// e^(k x^2) for a constant k < 0, within 3e-5, in less than half of what its parts would take.
inline float exp_of_square(float k, float x) {
  const uint32_t b = bits(k * 1.4426950408889634f) + 0x80;
  const uint16_t factor = static_cast<uint16_t>(b >> 8) | 0x8000;
  const int8_t places = static_cast<int8_t>(exponent(b) - 127);
#ifdef __AVR__
  return detail::fast_power_of_square(x, kPower, factor, places);
#else
  return power_of_square(x, factor, places);
#endif
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
