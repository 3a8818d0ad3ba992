#include "functions.h"

namespace functions {

#ifndef __AVR__

namespace {

// What is below the smallest number of full length is zero: before an operation, and after.
float whole(float x) { return is_zero(x) ? signed_as(0.0f, x) : x; }

// A result in double precision, rounded once.
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

#endif

float sqrt(float x) { return ::sqrtf(x); }
float floor(float x) { return ::floorf(x); }
float ceil(float x) { return -functions::floor(-x); }
float trunc(float x) { return signed_as(functions::floor(magnitude(x)), x); }

float remainder(float a, float b) { return ::fmodf(a, b); }

float modulo(float a, float b) {
  const float rest = remainder(a, b);
  if (rest == 0.0f) return signed_as(0.0f, b);
  return (rest < 0.0f) != (b < 0.0f) ? rest + b : rest;
}

float floor_divide(float a, float b) {
  const float rest = remainder(a, b);
  float quotient = (a - rest) / b;
  if (rest != 0.0f && (rest < 0.0f) != (b < 0.0f)) quotient -= 1.0f;
  const float below = functions::floor(quotient);
  return quotient - below > 0.5f ? below + 1.0f : below;
}

float sin(float x) { return ::sinf(x); }
float cos(float x) { return ::cosf(x); }
float tan(float x) { return ::tanf(x); }
float asin(float x) { return ::asinf(x); }
float acos(float x) { return ::acosf(x); }
float atan(float x) { return ::atanf(x); }
float atan2(float y, float x) { return ::atan2f(y, x); }
float exp(float x) { return ::expf(x); }
float expm1(float x) { return exp(x) - 1.0f; }
float log(float x) { return ::logf(x); }
float log1p(float x) { return log(1.0f + x); }
float sinh(float x) { return ::sinhf(x); }
float cosh(float x) { return ::coshf(x); }
float tanh(float x) { return ::tanhf(x); }
float power(float x, float y) { return ::powf(x, y); }
float hypot(float x, float y) { return ::hypotf(x, y); }

}  // namespace functions
