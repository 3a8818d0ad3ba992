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

// The nearest whole number to the square root; a tenth of the time that sqrtf takes on the board.
uint8_t rounded_root(uint16_t square) {
  uint8_t root = 0;
  for (uint8_t bit = 0x80; bit; bit >>= 1) {
    const uint8_t larger = root | bit;
    if (static_cast<uint16_t>(larger) * larger <= square) root = larger;
  }
  const uint16_t rest = square - static_cast<uint16_t>(root) * root;
  return rest > root && root < 255 ? root + 1 : root;
}

}  // namespace

Limited limit(float force) {
  if (!isfinite(force)) return {0.0f, protocol::kFlagRefused};
  if (force > profile::kMaxForce) return {profile::kMaxForce, protocol::kFlagClamped};
  if (force < -profile::kMaxForce) return {-profile::kMaxForce, protocol::kFlagClamped};
  return {force, 0};
}

int16_t pwm_of(float force) {
  constexpr float kFull = float(profile::kPwmTop) * float(profile::kPwmTop);
  const float square = fabsf(force) * kPwmSquaredPerForce + 0.5f;
  const uint8_t pwm = square < kFull ? rounded_root(static_cast<uint16_t>(square)) : profile::kPwmTop;
  return force < 0.0f ? static_cast<int16_t>(-pwm) : pwm;
}

}  // namespace motor
