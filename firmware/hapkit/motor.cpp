#include "motor.h"

#include <math.h>

#include "profile.h"
#include "protocol.h"

namespace motor {
namespace {

// torque = force * handle radius * gear; torque = motor constant * duty^2; pwm = top * duty.
constexpr float kTorquePerForce = profile::kHandleRadius * profile::kGear;
constexpr float kPwmSquaredPerForce =
    float(profile::kPwmTop) * float(profile::kPwmTop) * kTorquePerForce / profile::kMotorConstant;

}  // namespace

Limited limit(float force) {
  if (!isfinite(force)) return {0.0f, protocol::kFlagRefused};
  if (force > profile::kMaxForce) return {profile::kMaxForce, protocol::kFlagClamped};
  if (force < -profile::kMaxForce) return {-profile::kMaxForce, protocol::kFlagClamped};
  return {force, 0};
}

int16_t pwm_of(float force) {
  int16_t pwm = static_cast<int16_t>(sqrtf(fabsf(force) * kPwmSquaredPerForce) + 0.5f);
  if (pwm > profile::kPwmTop) pwm = profile::kPwmTop;
  return force < 0.0f ? static_cast<int16_t>(-pwm) : pwm;
}

}  // namespace motor
