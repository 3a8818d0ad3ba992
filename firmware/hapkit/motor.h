// From the force on the handle to the duty of the motor, as the settings in force say.
#pragma once

#include <stdint.h>
#include <string.h>

#include "motor_map.h"
#include "protocol.h"

namespace motor {

// A force command after the safety limits.
struct Limited {
  float force;    // [N]
  uint8_t flags;  // protocol::kFlagClamped, protocol::kFlagRefused
};

// Prepare for a kit: limit, motor map, dead band. Only while no reading of the sensor is handled.
void set(const protocol::Board& kit);

// Whether a force is within the limit as it is: the quick answer of the usual case. Floats of one sign are in the
// order of their bits; what is not finite comes last.
inline bool allows(float force) {
  uint32_t bits;
  memcpy(&bits, &force, sizeof(bits));
  return (bits & 0x7fffffff) <= map.most;
}

// Return the duty of a force that is not allowed: that of the largest one, or 0 for what is no number.
inline int16_t pwm_beyond(float force, bool* number) {
  uint32_t bits;
  memcpy(&bits, &force, sizeof(bits));
  *number = (bits & 0x7f800000) != 0x7f800000;
  if (!*number) return 0;
  return bits >> 31 ? -map.full : map.full;
}

// Cut a force to the limit; a force that is not finite becomes zero.
Limited limit(float force);

// Return the signed duty, 0..profile::kPwmTop in size, that comes nearest to a limited force.
//
// The share of full duty that turns the motor is (pwm - dead band) / (pwm top - dead band); torque follows
// from this share by the motor map. Zero force is zero duty.
int16_t pwm_of(float force);

}  // namespace motor
