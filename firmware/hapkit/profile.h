// The constants of the board, and the default kit, which is used until settings are stored.
#pragma once

#include <stdint.h>

namespace profile {

constexpr uint8_t kNumber = 1;  // Hapkit board (PWM D5, DIR D8) with magnetoresistive sensor on A2

constexpr float kHandleRadius = 0.090f;  // [m]
constexpr float kPulleyRadius = 0.005f;
constexpr float kSectorRadius = 0.074f;

constexpr float kMass = 0.044f;    // [kg] mass of the paddle at the handle
constexpr float kViscous = 0.5f;   // [N s/m] viscous friction
constexpr float kCoulomb = 0.10f;  // [N] dry friction

constexpr float kMotorConstant = 0.0183f;  // [N m] torque at full duty, torque = constant * duty^2
constexpr float kMaxForce = 3.0f;          // [N] at the handle
constexpr uint8_t kPwmTop = 255;           // the value of full duty

constexpr uint16_t kCountsPerFlip = 921;  // the sensor spans 5..95 % of its supply in every half turn
constexpr uint16_t kSampleRate = 1000;    // [Hz]
constexpr uint32_t kPeriodUs = 1000000UL / kSampleRate;
constexpr uint8_t kWatchdogMs = 25;

// Handle travel per sensor count: half a motor turn, geared down to the sector, at the handle.
constexpr float kGear = kPulleyRadius / kSectorRadius;
constexpr float kQuantum = 3.14159265f * kGear * kHandleRadius / kCountsPerFlip;

}  // namespace profile
