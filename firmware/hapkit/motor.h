// From the force on the handle to the duty of the motor, as the settings in force say.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace motor {

// What the motor gets, after the safety limits.
struct Duty {
  int16_t pwm;    // signed, 0..profile::kPwmTop in size
  uint8_t flags;  // protocol::kFlagClamped, protocol::kFlagRefused
};

// Prepare for a kit: limit, motor map, dead band. Only while no reading of the sensor is handled.
void set(const protocol::Board& kit);

// Return the duty that comes nearest to a force: that of the limit if it is larger, none if it is no number.
//
// The share of full duty that turns the motor is (pwm - dead band) / (pwm top - dead band); torque follows
// from this share by the motor map. Zero force is zero duty.
Duty duty_of(float force);

}  // namespace motor
