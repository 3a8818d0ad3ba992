// The machine's arithmetic: float32, with numbers below 2^-126 flushed to zero. Sums, products, quotients and
// roots are rounded to nearest. Other functions are accurate to a few units in the last place. They are
// computed in 32-bit integers, which takes a third of the time on a chip without floating point. The results
// have the same bits on the chip and on a PC.
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

namespace functions {

constexpr uint32_t kSign = 0x80000000UL;

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

inline uint8_t exponent(float x) {
  const uint16_t upper = static_cast<uint16_t>(bits(x) >> 16);
  return static_cast<uint8_t>(upper >> 7);
}

inline bool is_zero(float x) { return exponent(x) == 0; }
inline bool is_finite(float x) { return exponent(x) != 255; }
inline uint8_t sign_of(float x) { return static_cast<uint8_t>(bits(x) >> 24); }  // the sign is bit 7
inline bool is_nan(float x) { return (bits(x) & ~kSign) > 0x7f800000UL; }
inline bool is_negative(float x) { return sign_of(x) & 0x80; }
inline float negative(float x) { return number(bits(x) ^ kSign); }
inline float magnitude(float x) { return number(bits(x) & ~kSign); }
inline float signed_as(float x, float other) { return number((bits(x) & ~kSign) | (bits(other) & kSign)); }

#ifdef __AVR__
// On the chip, float_avr.S implements these.
inline float sum(float a, float b) { return a + b; }
inline float product(float a, float b) { return a * b; }
inline float quotient(float a, float b) { return a / b; }
#else
float sum(float a, float b);
float product(float a, float b);
float quotient(float a, float b);
#endif

// Return a b / 2^32; the result may be a few units too small.
uint32_t fraction(uint32_t a, uint32_t b);

// Return t0 - y (t1 - y (t2 - ...)), with y and the table in 2^-32. The table is in flash and begins with the
// last coefficient.
uint32_t series(uint32_t y, const uint32_t* table, uint8_t terms);

// |x| = mantissa / 2^31 * 2^(exponent - 127).
inline uint32_t mantissa(float x) { return bits(x) << 8 | kSign; }

// Return m 2^up, rounded.
uint32_t moved(uint32_t m, int16_t up);

// Return the lower 32 bits of x 2^up, truncated.
uint32_t fixed(float x, int8_t up);

// Return m / 2^31 * 2^(e - 127), rounded, with the sign in bit 7.
float assembled(uint32_t m, int16_t e, uint8_t sign);

// Return x f / 2^31; x must not be 0.
float times(float x, uint32_t f);

// phase_of returns an angle in 2^-32 turns, without whole turns; sine_of returns the sine of such a phase.
uint32_t phase_of(float x);
float sine_of(uint32_t phase);

// Return e^x 2^more.
float exp_times(float x, int8_t more);

struct Division {
  uint32_t quotient;  // truncated
  float rest;         // the remainder, with the sign of the dividend
};
constexpr uint32_t kBeyond = 0xffffffffUL;  // replaces a quotient of 2^24 or more; the remainder is then 0

Division divided(float a, float b);

float sqrt(float x);
float floor(float x);
float ceil(float x);
float trunc(float x);

// Return Python's a // b, a % b and math.fmod(a, b) for b other than 0. If a is more than 2^24 times as large
// as b, a float32 cannot represent the remainder, and the result is 0.
float floor_divide(float a, float b);
float modulo(float a, float b);
float remainder(float a, float b);

float sin(float x);
float cos(float x);
float tan(float x);
float asin(float x);
float acos(float x);
float atan(float x);
float atan2(float y, float x);
float exp(float x);
float expm1(float x);
float log(float x);
float log1p(float x);
float sinh(float x);
float cosh(float x);
float tanh(float x);
float power(float x, float y);
float hypot(float x, float y);

}  // namespace functions
