// From the force on the handle to the duty of the motor and back.
#pragma once

#include <stdint.h>

namespace motor {

// A force command after the safety limits.
struct Limited {
  float force;    // [N]
  uint8_t flags;  // protocol::kFlagClamped, protocol::kFlagRefused
};

// Cut a force to the limit; a force that is not finite becomes zero.
Limited limit(float force);

// Return the signed duty, 0..profile::kPwmTop in size, that gives a limited force.
int16_t pwm_of(float force);

}  // namespace motor
