// The duty is compared with the formulas, for every map, over the whole range.
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>

#include "check.h"
#include "kits.h"
#include "motor.h"
#include "profile.h"

namespace {

int pwm_of(float force) { return motor::duty_of(force).pwm; }

// Return the torque as a fraction of the torque at full duty; duty is a fraction 0..1 of the duty above the
// dead band.
double torque_share(const protocol::Board& kit, double duty) {
  if (kit.motor_map == protocol::kMotorMapSquare) return duty * duty;
  if (kit.motor_map == protocol::kMotorMapLinear) return duty;
  const int piece = std::min(static_cast<int>(duty * 8.0), 7);
  const double low = piece ? kit.table[piece - 1] / 255.0 : 0.0;
  return low + (duty * 8.0 - piece) * (kit.table[piece] / 255.0 - low);
}

// Return the force on the handle at a duty in steps above the dead band.
double force_at(const protocol::Board& kit, double steps) {
  const double top = 255.0 - kit.dead_band;
  const double full = double(kit.motor_constant) * kit.sector_radius / kit.handle_radius / kit.pulley_radius;
  return full * torque_share(kit, std::fmin(std::fmax(steps / top, 0.0), 1.0));
}

// Check that the duty is the nearest step: the force must lie between the forces of half a step less and half
// a step more.
void check_nearest(const protocol::Board& kit, float force) {
  // half a step, and the rounding error of the bits
  constexpr double kHalf = 0.5 + 0.02;
  const double small = 1.5 * force_at(kit, 1000.0) / (255.0 * 256.0);  // torque is stored in 256ths of 255ths
  const int pwm = pwm_of(force);
  const int size = std::abs(pwm);
  CHECK(size == 0 || (size > kit.dead_band && size <= 255));
  CHECK(pwm == 0 || (pwm < 0) == (force < 0.0f));
  const int steps = size ? size - kit.dead_band : 0;
  const double wanted = std::fmin(std::fabs(force), force_at(kit, 1000.0));
  CHECK(force_at(kit, steps - kHalf) <= wanted + small);
  CHECK(wanted <= force_at(kit, steps + kHalf) + small);
}

void check_map(protocol::Board kit) {
  kit.max_force = 1e9f;
  motor::set(kit);
  for (int i = -5000; i <= 5000; ++i) check_nearest(kit, static_cast<float>(i) * 0.001f);
  for (double force = 1e-7; force < 8.0; force *= 1.01) check_nearest(kit, static_cast<float>(force));
}

}  // namespace

TEST(duty_is_the_nearest_step_of_every_map) {
  for (uint8_t map : {protocol::kMotorMapSquare, protocol::kMotorMapLinear, protocol::kMotorMapTable}) {
    for (uint8_t dead_band : {0, 1, 25, 140, 200}) {
      for (float constant : {0.0053f, 0.0183f, 0.04526f}) {
        protocol::Board kit = kits::usual();
        kit.motor_map = map;
        kit.dead_band = dead_band;
        kit.motor_constant = constant;
        check_map(kit);
      }
    }
  }
}

TEST(duty_is_the_nearest_step_of_every_table) {
  const uint8_t tables[][8] = {{0, 0, 0, 40, 90, 150, 200, 255},
                               {1, 2, 3, 4, 5, 6, 7, 255},
                               {4, 16, 36, 64, 100, 143, 195, 255},
                               {100, 100, 150, 150, 150, 200, 255, 255},
                               {255, 255, 255, 255, 255, 255, 255, 255},
                               {0, 0, 0, 0, 0, 0, 0, 255}};
  protocol::Board kit = kits::usual();
  kit.motor_map = protocol::kMotorMapTable;
  for (const auto& table : tables) {
    std::memcpy(kit.table, table, sizeof(kit.table));
    check_map(kit);
  }
}

TEST(duty_grows_with_the_force) {
  for (uint8_t map : {protocol::kMotorMapSquare, protocol::kMotorMapLinear, protocol::kMotorMapTable}) {
    protocol::Board kit = kits::usual();
    kit.motor_map = map;
    kit.max_force = 3.5f;
    motor::set(kit);
    int last = 0;
    for (float force = 0.0f; force <= 3.02f; force += 1e-4f) {
      CHECK(pwm_of(force) >= last);
      last = pwm_of(force);
    }
    CHECK(last == 255);
    CHECK(pwm_of(0.0f) == 0 && pwm_of(-0.0f) == 0);
    CHECK(pwm_of(1e6f) == 255 && pwm_of(3e38f) == 255);
    CHECK(pwm_of(-1e6f) == -255);
    CHECK(pwm_of(1e-30f) == 0 && pwm_of(std::numeric_limits<float>::denorm_min()) == 0);
  }
}

TEST(force_is_limited) {
  motor::set(kits::usual());
  const int most = pwm_of(3.0f);
  CHECK(pwm_of(2.9f) < most);
  CHECK(motor::duty_of(2.999f).flags == 0 && motor::duty_of(3.0f).flags == 0 && motor::duty_of(3.0f).pwm == most);
  for (float force : {3.001f, 7.0f, 1e30f}) {
    CHECK(motor::duty_of(force).pwm == most && motor::duty_of(force).flags == protocol::kFlagClamped);
    CHECK(motor::duty_of(-force).pwm == -most && motor::duty_of(-force).flags == protocol::kFlagClamped);
  }
  protocol::Board none = kits::usual();
  none.max_force = 0.0f;
  motor::set(none);
  CHECK(motor::duty_of(1e-6f).pwm == 0 && motor::duty_of(-1.0f).pwm == 0);
  CHECK(motor::duty_of(0.0f).flags == 0 && motor::duty_of(-0.0f).flags == 0);
}

TEST(a_non_finite_force_is_refused) {
  motor::set(kits::usual());
  const float infinity = std::numeric_limits<float>::infinity();
  for (float force : {infinity, -infinity, std::nanf(""), -std::nanf("")}) {
    CHECK(motor::duty_of(force).pwm == 0 && motor::duty_of(force).flags == protocol::kFlagRefused);
  }
}

TEST(quantum_follows_from_the_gear) {
  CHECK_NEAR(profile::kQuantum, M_PI * 0.005 / 0.074 * 0.090 / 921.0, 1e-11);
  CHECK_NEAR(profile::kQuantum, 20.7e-6, 0.1e-6);
}
