#include "motor.h"

#include <math.h>

#include "profile.h"

#if defined(__AVR__)
#pragma GCC optimize("O2")
#endif

namespace motor {
namespace {

constexpr uint8_t kPieces = sizeof(protocol::Board::table);

float max_force = 0.0f;
uint8_t dead_band = 0;
uint8_t top = 0;            // steps of duty above the dead band
bool square = true;
float per_newton = 0.0f;    // of the map's own unit: steps squared, or 255ths of the torque at full duty
uint8_t ends[kPieces];      // of the pieces, in 255ths of the torque
float slopes[kPieces];      // steps per 255th
float heights[kPieces];     // steps where a piece, made longer, meets no torque; half a step is in it
uint8_t pieces = 0;

// One straight piece of the map, from one duty to the next.
void add_piece(float from, float to, uint8_t low, uint8_t high) {
  if (high == low) return;  // the lowest duty for a torque is enough
  slopes[pieces] = (to - from) / (high - low);
  heights[pieces] = from - slopes[pieces] * low + 0.5f;
  ends[pieces] = high;
  ++pieces;
}

void set_pieces(const protocol::Board& kit) {
  pieces = 0;
  if (kit.motor_map == protocol::kMotorMapLinear) return add_piece(0.0f, top, 0, 255);
  const float eighth = static_cast<float>(top) / kPieces;
  uint8_t low = 0;
  for (uint8_t i = 0; i < kPieces; ++i) {
    add_piece(i * eighth, (i + 1) * eighth, low, kit.table[i]);
    low = kit.table[i];
  }
}

// The whole number nearest to the root of what was given less a quarter: a step is nearest from half a step
// below, and (step - 1/2)^2 = step (step - 1) + 1/4. A tenth of the time that sqrtf takes on the board.
uint8_t nearest_root(uint16_t square_less_quarter) {
  uint8_t root = 0;
  for (uint8_t bit = 0x80; bit; bit >>= 1) {
    const uint8_t larger = root | bit;
    if (static_cast<uint16_t>(larger * static_cast<uint8_t>(larger - 1)) <= square_less_quarter) root = larger;
  }
  return root;
}

uint8_t square_steps(float force) {
  const float squared = force * per_newton;
  if (squared < 0.25f) return 0;
  const float full = static_cast<float>(static_cast<uint16_t>(top) * top);
  return squared < full ? nearest_root(static_cast<uint16_t>(squared - 0.25f)) : top;
}

uint8_t straight_steps(float force) {
  const float torque = force * per_newton;
  if (!(torque < ends[pieces - 1])) return top;
  const uint8_t whole = static_cast<uint8_t>(torque);
  uint8_t piece = 0;
  while (ends[piece] <= whole) ++piece;
  const float steps = heights[piece] + slopes[piece] * torque;
  return steps < top ? static_cast<uint8_t>(steps) : top;
}

}  // namespace

void set(const protocol::Board& kit) {
  max_force = kit.max_force;
  dead_band = kit.dead_band;
  top = profile::kPwmTop - dead_band;
  square = kit.motor_map == protocol::kMotorMapSquare;
  // torque = force * handle radius * pulley radius / sector radius, as a share of that at full duty
  const float share = kit.handle_radius * kit.pulley_radius / kit.sector_radius / kit.motor_constant;
  per_newton = square ? share * top * top : share * 255.0f;
  set_pieces(kit);
}

Limited limit(float force) {
  if (!isfinite(force)) return {0.0f, protocol::kFlagRefused};
  if (force > max_force) return {max_force, protocol::kFlagClamped};
  if (force < -max_force) return {-max_force, protocol::kFlagClamped};
  return {force, 0};
}

int16_t pwm_of(float force) {
  const float size = fabsf(force);
  const uint8_t steps = square ? square_steps(size) : straight_steps(size);
  const int16_t pwm = steps ? steps + dead_band : 0;
  return force < 0.0f ? -pwm : pwm;
}

}  // namespace motor
