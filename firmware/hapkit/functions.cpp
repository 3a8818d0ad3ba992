#include "functions.h"

#include "flash.h"

namespace functions {

// Minimax polynomials of the functions for y from 0 to 1, times 2^31.
extern const uint32_t kSine[] PROGMEM = {  // sin(z pi/2) / z, y = z^2, within 7e-9
    0x0004f85f, 0x009929ad, 0x0a33478f, 0x52aef0c7, 0xc90fda94};
extern const uint32_t kPower[] PROGMEM = {  // 2^-y, within 2e-9
    0x0003961a, 0x0029cef5, 0x0139ed03, 0x071a5567, 0x1ebfac27, 0x58b90ae2, 0x80000000};
extern const uint32_t kLog[] PROGMEM = {  // log(1 + u) / u, u = y sqrt(1/2) - (1 - sqrt(1/2)), within 3e-8
    0x00b77f39, 0x040380d8, 0x0a94bafc, 0x126e6dab, 0x19d5ad83, 0x21e3bbf4, 0x2e344b96, 0x475d0e63, 0x9775986a};
extern const uint32_t kAtan[] PROGMEM = {  // atan(z) / z, y = z^2, within 2e-8
    0x005f247f, 0x02158ebe, 0x05824ecd, 0x09a4a14e, 0x0da35297, 0x122f64a2, 0x199752ed, 0x2aaa9696, 0x80000000};
extern const uint32_t kAsin[] PROGMEM = {  // asin(z) / z, y = 1 - 4 z^2, within 5e-9
    0x00015db8, 0x0009e142, 0x00312f2e, 0x00ff6b40, 0x06e1515d, 0x860a91b8};
extern const uint32_t kExpm1[] PROGMEM = {  // (e^x - 1) / x, y = 1/2 - x, within 4e-9
    0x00068d74, 0x0041868f, 0x019c4ca5, 0x07fa746f, 0x1f2e54be, 0x59ed6492, 0xa61298db};

namespace {

constexpr uint8_t kOne = 127;  // exponent of 1
constexpr uint32_t kQuarter = 0x40000000UL;  // a quarter of a turn, in 2^-32 turns

template <uint8_t terms>
uint32_t of(uint32_t y, const uint32_t (&table)[terms]) {
  return series(y, table, terms);
}

}  // namespace

#ifndef __AVR__

namespace {

// Flush numbers below the smallest normal float to zero; this is done before and after an operation.
float whole(float x) { return is_zero(x) ? signed_as(0.0f, x) : x; }

// Round a result in double precision once.
float rounded(double exact) {
  const float wide = static_cast<float>(exact * 0x1p64);
  return wide < 0x1p-62f && wide > -0x1p-62f ? signed_as(0.0f, wide) : static_cast<float>(exact);
}

}  // namespace

float sum(float a, float b) {
  const float total = whole(a) + whole(b);
  return total != 0.0f && is_zero(total) ? 0.0f : total;
}

float product(float a, float b) { return rounded(static_cast<double>(whole(a)) * whole(b)); }
float quotient(float a, float b) { return rounded(static_cast<double>(whole(a)) / whole(b)); }

uint32_t fraction(uint32_t a, uint32_t b) {
  uint64_t found = 0;
  for (int i = 0; i < 4; i++)
    for (int j = 3 - i; j < 4; j++) {
      const uint64_t part = (a >> 8 * i & 255) * (b >> 8 * j & 255);
      found += i + j == 3 ? part >> 8 : part << 8 * (i + j - 4);
    }
  return static_cast<uint32_t>(found);
}

uint32_t series(uint32_t y, const uint32_t* table, uint8_t terms) {
  uint32_t found = *table;
  while (--terms) found = *++table - fraction(found, y);
  return found;
}

uint32_t moved(uint32_t m, int16_t up) {
  if (up <= -32 || up >= 32) return 0;
  return up < 0 ? m >> -up : m << up;
}

uint32_t fixed(float x, int8_t up) {
  const uint32_t m = moved(mantissa(x), static_cast<int16_t>(exponent(x) - 127 - 31 + up));
  return is_negative(x) ? 0 - m : m;
}

float assembled(uint32_t m, int16_t e, uint8_t sign) {
  const uint32_t top = static_cast<uint32_t>(sign & 0x80) << 24;
  if (m == 0) return number(top);
  for (; m < kSign; e--) m <<= 1;
  if (e >= 255 || e <= 0) return number(top | (e > 0 ? 0x7f800000UL : 0));
  // rounding may carry into the exponent, which gives the correct result
  return number(top | ((static_cast<uint32_t>(e) << 23) + (((m & ~kSign) + 0x80) >> 8)));
}

float times(float x, uint32_t f) {
  return assembled(fraction(mantissa(x), f), static_cast<int16_t>(exponent(x) + 1), sign_of(x));
}

uint32_t phase_of(float x) {
  const uint32_t m = moved(fraction(mantissa(x), 0xa2f9836eUL), static_cast<int16_t>(exponent(x)) - kOne - 1);
  return is_negative(x) ? 0 - m : m;
}

float sine_of(uint32_t phase) {
  const uint32_t z = (phase & kQuarter ? ~phase : phase) << 2;
  return assembled(fraction(z, of(fraction(z, z), kSine)), kOne, static_cast<uint8_t>(phase >> 24));
}

float exp_times(float x, int8_t more) {
  if (is_nan(x)) return x;
  if (exponent(x) >= kOne + 7) return is_negative(x) ? 0.0f : INFINITY;
  // binary exponent in 2^-24, rounded; the series computes 2^-y
  const uint32_t places = moved(fraction(mantissa(x), 0xb8aa3b29UL), static_cast<int16_t>(exponent(x)) - kOne - 6);
  const uint32_t part = (places << 8) + 128;
  const int16_t whole = static_cast<uint8_t>(places >> 24);
  if (is_negative(x)) return assembled(of(part, kPower), kOne - whole + more, 0);
  return assembled(of(0 - part, kPower), kOne + 1 + whole + more, 0);
}

Division divided(float a, float b) {
  if (!is_finite(a) || is_nan(b)) return {0, NAN};
  const int16_t places = static_cast<int16_t>(exponent(a)) - exponent(b);
  if (places < 0 || is_zero(a)) return {0, a};
  if (places >= 24) return {kBeyond, signed_as(0.0f, a)};
  const uint32_t divisor = mantissa(b) >> 8;
  uint32_t rest = mantissa(a) >> 8, quotient = 0;
  for (int8_t n = static_cast<int8_t>(places);; n--) {
    quotient <<= 1;
    if (rest >= divisor) {
      rest -= divisor;
      quotient++;
    }
    if (n == 0) break;
    rest <<= 1;
  }
  return {quotient, assembled(rest << 8, exponent(b), sign_of(a))};
}

#endif

namespace {

constexpr float kHalfPi = 1.5707963267948966f;
constexpr float kPi = 3.1415926535897932f;
constexpr float kLog2 = 0.69314718055994531f;

// Below 2^-12, sin, tan, asin and atan equal x, except for the last bit.
bool is_small(float x) { return exponent(x) < kOne - 12; }

// Return log(1 + u) / u in 2^-31, for u 2^32 with u from sqrt(1/2) - 1 to sqrt(2) - 1.
uint32_t log_slope(uint32_t u) {
  const uint32_t above = u + 0x4afb0ccdUL;
  return of(above + fraction(above, 0x6a09e668UL), kLog);
}

// Return atan of a number from 0 to 1.
float small_atan(float z) {
  if (is_small(z)) return z;
  const uint32_t size = fixed(z, 32) - 1;
  return times(z, of(fraction(size, size), kAtan));
}

// Return acos of a number from 1/2 to 1.
float small_acos(float z) {
  const float rest = sum(1.0f, -z);  // this difference is exact
  if (rest == 0.0f) return rest;
  const float half = times(functions::sqrt(product(rest, 0.5f)), of(0 - fixed(rest, 33), kAsin));
  return sum(half, half);
}

// Return the fractional bits of a number from 1 to 2^23.
uint32_t behind_point(float x) {
  const uint8_t places = 150 - exponent(x);
  uint8_t top = 0xff;
  for (uint8_t n = places & 7; n; n--) top <<= 1;
  const uint32_t mask = static_cast<uint8_t>(~top);
  return places < 8 ? mask : places < 16 ? mask << 8 | 0xff : mask << 16 | 0xffff;
}

}  // namespace

float sqrt(float x) { return is_zero(x) ? signed_as(0.0f, x) : ::sqrtf(x); }

float floor(float x) {
  const uint8_t e = exponent(x);
  if (e < kOne) return is_negative(x) && !is_zero(x) ? -1.0f : signed_as(0.0f, x);
  if (e >= 150) return x;
  const uint32_t behind = behind_point(x);
  uint32_t b = bits(x);
  if (is_negative(x)) b += behind;
  return number(b & ~behind);
}

float ceil(float x) { return -functions::floor(-x); }

float trunc(float x) {
  const uint8_t e = exponent(x);
  if (e < kOne) return signed_as(0.0f, x);
  return e >= 150 ? x : number(bits(x) & ~behind_point(x));
}

float remainder(float a, float b) { return divided(a, b).rest; }

float modulo(float a, float b) {
  const float rest = divided(a, b).rest;
  if (is_zero(rest)) return signed_as(0.0f, b);
  return is_negative(rest) == is_negative(b) ? rest : sum(rest, b);
}

float floor_divide(float a, float b) {
  const Division division = divided(a, b);
  if (is_nan(division.rest)) return NAN;
  if (division.quotient == kBeyond) return quotient(a, b);
  const uint8_t sign = (sign_of(a) ^ sign_of(b)) & 0x80;
  const uint8_t more = sign && !is_zero(division.rest) ? 1 : 0;
  return assembled(division.quotient + more, kOne + 31, sign);
}

float sin(float x) {
  if (!is_finite(x)) return NAN;
  return is_small(x) ? x : sine_of(phase_of(x));
}

float cos(float x) { return is_finite(x) ? sine_of(phase_of(x) + kQuarter) : NAN; }

float tan(float x) {
  if (!is_finite(x)) return NAN;
  if (is_small(x)) return x;
  const uint32_t phase = phase_of(x);
  return quotient(sine_of(phase), sine_of(phase + kQuarter));
}

float asin(float x) {
  if (is_small(x)) return x;
  const float size = magnitude(x);
  if (exponent(x) >= kOne - 1) return size <= 1.0f ? signed_as(sum(kHalfPi, -small_acos(size)), x) : NAN;
  const uint32_t twice = fixed(size, 33);
  return times(x, of(~fraction(twice, twice), kAsin));
}

float acos(float x) {
  if (exponent(x) < kOne - 1) return sum(kHalfPi, -functions::asin(x));
  const float size = magnitude(x);
  if (!(size <= 1.0f)) return NAN;
  const float found = small_acos(size);
  return is_negative(x) ? sum(kPi, -found) : found;
}

float atan2(float y, float x) {
  if (is_nan(x) || is_nan(y)) return NAN;
  const float a = magnitude(y), b = magnitude(x);
  float found;
  if (is_zero(a)) {
    found = 0.0f;
  } else if (bits(a) == bits(b)) {
    found = kHalfPi / 2;
  } else if (bits(a) < bits(b)) {
    found = small_atan(quotient(a, b));
  } else {
    found = sum(kHalfPi, -small_atan(quotient(b, a)));
  }
  if (is_negative(x)) found = sum(kPi, -found);
  return signed_as(found, y);
}

float atan(float x) { return functions::atan2(x, 1.0f); }

float exp(float x) { return exp_times(x, 0); }

float expm1(float x) {
  if (exponent(x) >= kOne - 1) return sum(exp_times(x, 0), -1.0f);
  if (exponent(x) < kOne - 24) return x;
  return times(x, of(kSign - fixed(x, 32), kExpm1));
}

float log(float x) {
  if (is_zero(x)) return -INFINITY;
  if (is_negative(x) || !is_finite(x)) return bits(x) == 0x7f800000UL ? x : NAN;
  const uint32_t m = mantissa(x);
  const bool high = m > 0xb504f333UL;  // above sqrt(2), half of the number is closer to 1
  const int8_t whole = static_cast<int8_t>(exponent(x) - kOne + high);
  const uint32_t u = high ? m : m << 1;
  const float rest = assembled(high ? 0 - u : u, kOne - 1, high ? 0x80 : 0);
  const float found = is_zero(rest) ? rest : times(rest, log_slope(u));
  return whole ? sum(product(static_cast<float>(whole), kLog2), found) : found;
}

float log1p(float x) {
  if (exponent(x) < kOne - 24) return x;
  if (x > -0.29f && x < 0.41f) return times(x, log_slope(fixed(x, 32)));
  return functions::log(sum(1.0f, x));
}

float sinh(float x) {
  const float size = magnitude(x);
  float found;
  if (exponent(x) < kOne - 1) {
    const float up = functions::expm1(size);
    found = product(sum(up, quotient(up, sum(up, 1.0f))), 0.5f);
  } else {
    const float half = exp_times(size, -1);
    found = sum(half, -quotient(0.25f, half));
  }
  return signed_as(found, x);
}

float cosh(float x) {
  const float half = exp_times(magnitude(x), -1);
  return sum(half, quotient(0.25f, half));
}

float tanh(float x) {
  if (is_nan(x)) return x;
  if (is_small(x)) return x;
  const float twice = magnitude(sum(x, x));
  float found;
  if (exponent(x) < kOne - 2) {
    const float up = functions::expm1(twice);
    found = quotient(up, sum(up, 2.0f));
  } else {
    found = sum(1.0f, -quotient(2.0f, sum(exp_times(twice, 0), 1.0f)));
  }
  return signed_as(found, x);
}

float power(float x, float y) {
  if (is_zero(y) || x == 1.0f) return 1.0f;
  if (is_nan(x) || is_nan(y)) return NAN;
  const float size = magnitude(x);
  // the lowest bit of the integer part of y, above the fraction
  const uint32_t lowest = fixed(magnitude(y), 31);
  const bool whole = (lowest << 1) == 0;
  if (is_negative(x) && !whole && !is_zero(x) && is_finite(x)) return NAN;
  const float found = size == 1.0f ? size : exp_times(product(y, functions::log(size)), 0);
  return is_negative(x) && whole && lowest ? -found : found;
}

float hypot(float x, float y) {
  float a = magnitude(x), b = magnitude(y);
  if (bits(a) < bits(b)) {
    const float less = a;
    a = b;
    b = less;
  }
  if (!is_finite(a)) return bits(b) == 0x7f800000UL ? b : a;
  if (is_zero(b)) return a;
  // scale both numbers, so that their squares are floats, too
  if (exponent(a) > kOne + 60) return product(functions::hypot(product(a, 0x1p-64f), product(b, 0x1p-64f)), 0x1p64f);
  if (exponent(a) < kOne - 50) return product(functions::hypot(product(a, 0x1p64f), product(b, 0x1p64f)), 0x1p-64f);
  return functions::sqrt(sum(product(a, a), product(b, b)));
}

}  // namespace functions
