// Kinematics and duty against the formulas, over the whole range.
#include <cmath>
#include <initializer_list>
#include <limits>

#include "check.h"
#include "flip.h"
#include "motor.h"
#include "profile.h"
#include "protocol.h"

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

// What the sensor reads at a handle position [m]: 5..95 % of its supply, again every half motor turn.
uint16_t reading(double position) {
  const double turns = position / 0.090 * 0.074 / 0.005 / M_PI;  // half turns of the motor
  return static_cast<uint16_t>(51.0 + 921.0 * (turns - std::floor(turns)));
}

}  // namespace

TEST(duty_is_the_nearest_step) {
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

TEST(flips_are_followed_across_the_whole_range) {
  // 40 mm at 2 Hz is 0.5 m/s; the error must not grow with the number of flips
  FlipTracker flips;
  const int32_t start = flips.update(reading(0.0));
  for (int i = 1; i < 3000; ++i) {
    const double position = 0.040 * std::sin(2.0 * M_PI * 2.0 * i * 1e-3);
    const double expected = std::floor(position / profile::kQuantum);
    CHECK_NEAR(flips.update(reading(position)) - start, expected, 1.0);
  }
}

TEST(flips_are_followed_up_to_half_a_turn_per_sample) {
  for (double speed : {-9.0, -3.0, 3.0, 9.0}) {  // 460 counts per ms are 9.5 m/s
    FlipTracker flips;
    const int32_t start = flips.update(reading(0.0));
    for (int i = 1; i < 50; ++i) {
      const double position = speed * i * 1e-3;
      const int32_t count = flips.update(reading(position)) - start;
      CHECK_NEAR(count, std::floor(position / profile::kQuantum), 2.0);
    }
  }
}

TEST(first_reading_counts_no_flip) {
  FlipTracker flips;
  CHECK(flips.update(971) == 971);
  CHECK(flips.update(52) == 52 + 921);
  CHECK(flips.update(971) == 971);
}
