// Converts the force on the handle to the duty of the motor, by the present settings.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace motor {

// A motor command after the safety limits.
struct Duty {
  int16_t pwm;    // signed; its size is 0..profile::kPwmTop
  uint8_t flags;  // protocol::kFlagClamped, protocol::kFlagRefused
};

// Prepare for a kit: limit, motor map, dead band. Call it only while no sensor reading is processed.
void set(const protocol::Board& kit);

// Return the duty that is nearest to a force. A larger force than the limit gets the duty of the limit; NaN
// gets 0.
//
// The effective duty is (pwm - dead band) / (pwm top - dead band). The torque follows from it by the motor
// map. A force of zero gives a duty of zero.
Duty duty_of(float force);

}  // namespace motor
