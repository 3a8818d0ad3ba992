// The valid ranges of a kit's numbers. All Hapkits are inside; a value outside probably has a wrong unit.
#pragma once

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#endif

namespace limits {

struct Range {
  float low, high;

  // This is also false for NaN.
  constexpr bool holds(float value) const { return low <= value && value <= high; }
};

constexpr float kMostForce = 5.0f;  // [N] the board's hard limit for any force command

// Ranges of a kit's numbers from quantum to coulomb, in the order of the fields of protocol::Board.
static const Range kNumbers[] PROGMEM = {
    {1e-7f, 2e-3f},   // [m] quantum: from 14 bits per turn to an encoder of 48 steps with a thick pulley
    {0.0f, kMostForce},
    {1e-4f, 0.2f},    // [N m] motor constant
    {0.02f, 0.3f},    // [m] handle radius
    {0.001f, 0.02f},  // [m] pulley radius
    {0.02f, 0.3f},    // [m] sector radius
    {0.0f, 1.0f},     // [kg] mass
    {0.0f, 20.0f},    // [N s/m] viscous
    {0.0f, 5.0f},     // [N] Coulomb
};

// smallest number of counts after which the readings of a magnetoresistive sensor repeat
constexpr uint16_t kFewestCounts = 100;
constexpr uint16_t kMostCounts = 1007;    // there are 1008 counts from rail to rail
constexpr uint16_t kAs5048ACounts = 16384;
constexpr uint16_t kFewestSteps = 4;      // smallest number of counts per turn of an encoder
constexpr int32_t kLargestZero = 1000000;
constexpr uint8_t kLargestDeadBand = 200;

}  // namespace limits
