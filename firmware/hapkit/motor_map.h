// A kit's conversion of force to duty, in the form that duty_of() needs.
#pragma once

#include <stdint.h>
#include <string.h>

#include "protocol.h"

namespace motor {

// The factor of a force: mantissa / 2^16, and a shift minus the force's exponent.
struct Factor {
  uint16_t mantissa;
  int16_t places;
};

// A linear piece of the map. Torques are in 255ths of the torque at full duty, duties in 256ths of a step.
struct Piece {
  uint8_t to;           // torque at the end of the piece
  uint8_t slope;        // whole steps of duty per 255th of torque
  uint16_t slope_rest;  // fraction of a step, in 65536ths
};

// The two halves of a float's bits. An operation on floats takes 100 to 500 cycles, an operation on the bits
// a quarter of this.
struct Halves {
  uint16_t low, high;
};

inline Halves halves_of(float value) {
  Halves bits;
  memcpy(&bits, &value, sizeof(bits));
  return bits;
}

struct Map {
  Halves most;    // the largest force
  int16_t full;   // duty at the largest force
  uint8_t dead_band;
  uint8_t top;  // number of duty steps above the dead band
  bool straight;  // true: linear pieces; false: square law
  Factor factor;  // converts newtons to steps squared, or to 255ths of the torque at full duty
  Piece pieces[sizeof(protocol::Board::table)];
  uint8_t piece_count;
  uint16_t width;  // width of each piece in duty
};

extern Map map;

}  // namespace motor
