// Kits for the tests, with explicit values.
#pragma once

#include <cstring>

#include "protocol.h"

namespace kits {

inline protocol::Board usual() {
  protocol::Board kit{};
  kit.profile = 1;
  kit.pins = protocol::kPinsD5D8;
  kit.sensor = protocol::kSensorMagnetoresistive;
  kit.motor_map = protocol::kMotorMapSquare;
  kit.direction = 1;
  kit.sense = 1;
  kit.counts_per_flip = 921;
  kit.quantum = 20.74e-6f;
  kit.max_force = 3.0f;
  kit.motor_constant = 0.0183f;
  kit.handle_radius = 0.090f;
  kit.pulley_radius = 0.005f;
  kit.sector_radius = 0.074f;
  kit.mass = 0.044f;
  kit.viscous = 0.5f;
  kit.coulomb = 0.1f;
  const uint8_t table[] = {32, 64, 96, 128, 159, 191, 223, 255};
  std::memcpy(kit.table, table, sizeof(table));
  std::strncpy(kit.label, "Test", sizeof(kit.label));
  return kit;
}

inline protocol::Board with_sensor(uint8_t sensor, uint16_t counts) {
  protocol::Board kit = usual();
  kit.sensor = sensor;
  kit.counts_per_flip = counts;
  return kit;
}

inline protocol::Board named(const char* label, float force) {
  protocol::Board kit = usual();
  std::memset(kit.label, 0, sizeof(kit.label));
  std::strncpy(kit.label, label, sizeof(kit.label));
  kit.max_force = force;
  return kit;
}

inline bool same(const protocol::Board& a, const protocol::Board& b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

}  // namespace kits
