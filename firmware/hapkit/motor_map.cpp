#include "motor_map.h"

#include "motor.h"
#include "profile.h"

namespace motor {

Map map = {};

namespace {

Factor factor_of(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof(bits));
  bits += 0x80;  // round to the nearest
  const int16_t exponent = bits >> 23;
  return {static_cast<uint16_t>(0x8000 | (bits >> 8)), static_cast<int16_t>(2 * 127 + 14 - exponent)};
}

// Duties that add no torque are skipped, so the lowest duty for a torque is used.
void add_piece(uint8_t low, uint8_t high) {
  const uint32_t slope = high == low ? 0 : (static_cast<uint32_t>(map.width) << 8) / static_cast<uint8_t>(high - low);
  map.pieces[map.piece_count++] = {high, static_cast<uint8_t>(slope >> 16), static_cast<uint16_t>(slope)};
}

void set_pieces(const protocol::Board& kit) {
  map.piece_count = 0;
  map.width = map.top << 8;
  if (kit.motor_map == protocol::kMotorMapLinear) return add_piece(0, 255);
  map.width /= sizeof(kit.table);
  uint8_t low = 0;
  for (const uint8_t high : kit.table) {
    add_piece(low, high);
    low = high;
  }
}

}  // namespace

void set(const protocol::Board& kit) {
  map.most = halves_of(kit.max_force);
  map.dead_band = kit.dead_band;
  map.top = profile::kPwmTop - kit.dead_band;
  map.straight = kit.motor_map != protocol::kMotorMapSquare;
  // torque = force * handle radius * pulley radius / sector radius, relative to the torque at full duty
  const float share = kit.handle_radius * kit.pulley_radius / kit.sector_radius / kit.motor_constant;
  const uint16_t steps = map.straight ? 255 : map.top * static_cast<uint16_t>(map.top);
  map.factor = factor_of(share * steps);
  set_pieces(kit);
  map.full = duty_of(kit.max_force).pwm;
}

}  // namespace motor
