// Kinematics and duty against the formulas, over the whole range.
#include <cmath>
#include <initializer_list>
#include <limits>

#include "check.h"
#include "motor.h"
#include "profile.h"
#include "protocol.h"
#include "settings.h"

namespace {

// Independent: handle force -> sector torque -> motor torque -> duty.
double exact_pwm(double force) {
  const double torque = std::fabs(force) * 0.090 * 0.005 / 0.074;
  return std::copysign(255.0 * std::fmin(std::sqrt(torque / 0.0183), 1.0), force);
}

double force_of(int pwm) {
  const double duty = pwm / 255.0;
  return std::copysign(0.0183 * duty * duty * 0.074 / (0.090 * 0.005), pwm);
}

}  // namespace

TEST(duty_is_the_nearest_step) {
  motor::set(settings::now());
  for (int i = -3000; i <= 3000; ++i) {
    const float force = static_cast<float>(i) * 0.001f;
    CHECK_NEAR(motor::pwm_of(force), exact_pwm(force), 0.75);
    CHECK(std::signbit(static_cast<float>(motor::pwm_of(force))) == (force < 0.0f && motor::pwm_of(force) != 0));
    const int pwm = motor::pwm_of(force);
    const int up = std::abs(pwm) < 255 ? std::abs(pwm) + 1 : 255;
    CHECK(std::fabs(force) <= force_of(up) && std::fabs(force_of(pwm) - force) <= force_of(up));
  }
}

TEST(duty_grows_with_the_force) {
  motor::set(settings::now());
  int last = 0;
  for (float force = 0.0f; force <= 3.0f; force += 1e-4f) {
    CHECK(motor::pwm_of(force) >= last);
    last = motor::pwm_of(force);
  }
  CHECK(last == 255);  // the limit is nearly all that the motor has
  CHECK(motor::pwm_of(0.0f) == 0);
  CHECK(motor::pwm_of(1e6f) == 255);
  CHECK(motor::pwm_of(-1e6f) == -255);
}

TEST(force_is_limited) {
  motor::set(settings::now());
  CHECK(motor::limit(2.999f).force == 2.999f && motor::limit(2.999f).flags == 0);
  CHECK(motor::limit(3.0f).flags == 0);
  CHECK(motor::limit(3.001f).force == 3.0f && motor::limit(3.001f).flags == protocol::kFlagClamped);
  CHECK(motor::limit(-7.0f).force == -3.0f && motor::limit(-7.0f).flags == protocol::kFlagClamped);
}

TEST(what_is_not_finite_is_refused) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (float force : {infinity, -infinity, std::nanf("")}) {
    CHECK(motor::limit(force).force == 0.0f && motor::limit(force).flags == protocol::kFlagRefused);
  }
}

TEST(quantum_follows_from_the_gear) {
  CHECK_NEAR(profile::kQuantum, M_PI * 0.005 / 0.074 * 0.090 / 921.0, 1e-11);
  CHECK_NEAR(profile::kQuantum, 20.7e-6, 0.1e-6);
}
