// Holds fast.h against double precision over dense sweeps; prints the largest errors.
#include "fast.h"

#include <cmath>
#include <cstdio>
#include <initializer_list>

namespace {

bool good = true;

// Sweep a function; the error is absolute, or relative where told, and more is allowed per |x|.
void hold(const char* name, float (*ours)(float), double (*theirs)(double), double low, double high,
          double bound, bool relative = false, double growing = 0.0) {
  constexpr int kSteps = 400000;
  double worst = 0.0, at = 0.0;
  for (int i = 0; i <= kSteps; i++) {
    const float x = static_cast<float>(low + (high - low) * i / kSteps);
    const double exact = theirs(static_cast<double>(x));
    double error = std::fabs(ours(x) - exact) / (relative ? std::fabs(exact) : 1.0);
    error = std::fmax(0.0, error - growing * std::fabs(x));
    if (!(error <= worst)) worst = error, at = x;
  }
  if (!(worst <= bound)) good = false;
  std::printf("%-14s %10g .. %-10g %.2e of %.2e at %g\n", name, low, high, worst, bound, at);
}

double sine_of_turns(double x) { return std::sin(2.0 * M_PI * x); }
double cosine_of_turns(double x) { return std::cos(2.0 * M_PI * x); }

// Of the board's own: their constants are known when they are compiled.
float bell(float x) { return fast::exp_of_square(-1.0f, x); }
float narrow_bell(float x) { return fast::exp_of_square(-18.0f, x); }
float wide_bell(float x) { return fast::exp_of_square(-0.003f, x); }

void same(const char* name, float found, float wanted) {
  const bool equal = found == wanted || (found != found && wanted != wanted);
  if (!equal) good = false, std::printf("%s: %g, not %g\n", name, found, wanted);
}

double python_modulo(double a, double b) {
  const double rest = std::fmod(a, b);
  return rest != 0.0 && (rest < 0.0) != (b < 0.0) ? rest + b : rest;
}

void whole_numbers() {
  for (int i = -4000; i <= 4000; i++) {
    const float x = static_cast<float>(i) / 16.0f;
    same("floor", fast::floor(x), std::floor(x));
    same("ceil", fast::ceil(x), std::ceil(x));
    same("trunc", fast::trunc(x), std::trunc(x));
    same("modulo", fast::modulo(x, -1.5f), python_modulo(x, -1.5));
    same("modulo", fast::modulo(x, 1.5f), python_modulo(x, 1.5));
    same("//", fast::floor_division(x, -1.5f), std::floor(x / -1.5));
    same("scaled", fast::scaled<7>(x), x * 128.0f);
    same("scaled", fast::scaled<-7>(x), x / 128.0f);
  }
  for (float x : {8388607.5f, -8388607.5f, 8388608.0f, -1e30f, INFINITY, -INFINITY, NAN})
    same("floor", fast::floor(x), std::floor(x));
}

void signs() {
  for (float x : {0.0f, -0.0f, 1.0f, -1.0f, 1e-40f, -1e-40f, INFINITY, -INFINITY, NAN, -NAN}) {
    same("above", fast::above_zero(x), x > 0.0f);
    same("below", fast::below_zero(x), x < 0.0f);
    same("to", fast::to_zero(x), x <= 0.0f);
    same("from", fast::from_zero(x), x >= 0.0f);
    same("zero", fast::is_zero(x), x == 0.0f);
    same("magnitude", fast::magnitude(x), std::fabs(x));
    same("signed_as", fast::signed_as(2.0f, x), std::copysign(2.0f, x));
  }
}

void ends() {
  same("exp", fast::exp(200.0f), INFINITY);
  same("exp", fast::exp(-200.0f), 0.0f);
  same("exp", fast::exp(NAN), NAN);
  same("exp of square", bell(INFINITY), 0.0f);
  same("exp of square", bell(NAN), NAN);
  same("exp of square", bell(1e-30f), 1.0f);
  same("exp of square", bell(1e30f), 0.0f);
  same("sin", fast::sin(INFINITY), NAN);
  same("cos", fast::cos(NAN), NAN);
  same("tanh", fast::tanh(INFINITY), 1.0f);
  same("tanh", fast::tanh(-INFINITY), -1.0f);
  same("tanh", fast::tanh(NAN), NAN);
  same("floor", fast::floor(-0.5f), -1.0f);
}

}  // namespace

int main() {
  hold("sin of turns", fast::sin_of_turns, sine_of_turns, -3.0, 3.0, 4e-6);
  hold("sin of turns", fast::sin_of_turns, sine_of_turns, -120.0, 120.0, 4e-6);
  hold("cos of turns", fast::cos_of_turns, cosine_of_turns, -3.0, 3.0, 4e-6);
  hold("sin", fast::sin, std::sin, -7.0, 7.0, 4.5e-6);
  hold("cos", fast::cos, std::cos, -7.0, 7.0, 4.5e-6);
  hold("sin", fast::sin, std::sin, -300.0, 300.0, 4e-6, false, 2e-7);
  hold("exp", fast::exp, std::exp, -8.0, 8.0, 1.5e-6, true);
  hold("exp", fast::exp, std::exp, -80.0, 80.0, 1.5e-6, true, 2e-7);
  hold("exp", fast::exp, std::exp, -0.01, 0.01, 1.5e-6, true);
  hold("exp of square", bell, [](double x) { return std::exp(-x * x); }, -12.0, 12.0, 3e-5);
  hold("exp of square", narrow_bell, [](double x) { return std::exp(-18.0 * x * x); }, -0.6, 0.6, 3e-5);
  hold("exp of square", wide_bell, [](double x) { return std::exp(-0.003 * x * x); }, -200.0, 200.0, 3e-5);
  hold("tanh", fast::tanh, std::tanh, -10.0, 10.0, 1e-6);
  hold("expm1", fast::expm1, std::expm1, -3.0, 3.0, 2e-5);
  hold("expm1", fast::expm1, std::expm1, 1e-6, 0.125, 1e-6, true);
  hold("log1p", fast::log1p, std::log1p, -0.9, 3.0, 1e-6);
  whole_numbers();
  signs();
  ends();
  return good ? 0 : 1;
}
