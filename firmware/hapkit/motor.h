// Conversion of the force on the handle to the duty of the motor, by the settings in force.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace motor {

// Motor command after the safety limits.
struct Duty {
  int16_t pwm;    // signed, 0..profile::kPwmTop in size
  uint8_t flags;  // protocol::kFlagClamped, protocol::kFlagRefused
};

// Prepare for a kit: limit, motor map, dead band. Only while no sensor reading is processed.
void set(const protocol::Board& kit);

// Return the duty nearest to a force: that of the limit for a larger force, 0 for NaN.
//
// The effective duty is (pwm - dead band) / (pwm top - dead band); torque follows
// from it by the motor map. Zero force is zero duty.
Duty duty_of(float force);

}  // namespace motor
