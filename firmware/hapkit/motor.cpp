#include "motor.h"

#include <string.h>

#include "motor_map.h"

namespace motor {
namespace {

constexpr uint32_t kSign = 0x80000000;
constexpr uint32_t kInfinite = 0x7f800000;
constexpr uint16_t kSignHigh = kSign >> 16;
constexpr uint16_t kSmallest = 0x0080;  // upper half of the smallest float whose mantissa is whole

// The board's float operations take 100 to 500 cycles each; on the bits, a quarter of that is enough.
uint32_t bits_of(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof(bits));
  return bits;
}

float float_of(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof(value));
  return value;
}

// A float's bits, as the chip deals with them best.
struct Halves {
  uint16_t low, high;
};

// A force times the factor is value / 2^places.
struct Product {
  uint16_t value;
  int16_t places;
};

Product times_factor(Halves force) {
  const uint16_t mantissa = 0x8000 | static_cast<uint8_t>(force.high) << 8 | force.low >> 8;
  const uint32_t whole = static_cast<uint32_t>(mantissa) * map.factor.mantissa;
  const uint8_t exponent = (force.high & ~kSignHigh) >> 7;
  const int16_t places = map.factor.places - exponent;
  const uint16_t value = whole >> 16;
  if (value & 0x8000) return {value, places};
  const bool next_bit = static_cast<int16_t>(whole) < 0;
  return {static_cast<uint16_t>(value << 1 | next_bit), static_cast<int16_t>(places + 1)};
}

uint16_t shifted(uint16_t value, uint8_t places) {
  if (places > 15) return 0;
  if (places & 8) value >>= 8;
  for (places &= 7; places; --places) value >>= 1;
  return value;
}

// The whole number nearest to the root of what was given less a quarter: a step is nearest from half a step
// below, and (step - 1/2)^2 = step (step - 1) + 1/4.
uint8_t nearest_root(uint16_t square_less_quarter) {
  uint8_t root = 0;
  for (uint8_t bit = 0x80; bit; bit >>= 1) {
    const uint8_t larger = root | bit;
    if (static_cast<uint16_t>(larger * static_cast<uint8_t>(larger - 1)) <= square_less_quarter) root = larger;
  }
  return root;
}

uint8_t square_steps(Product steps_squared) {
  const int16_t places = steps_squared.places;
  if (places < 0) return map.top;
  if (places < 8) return nearest_root(shifted(steps_squared.value, places));  // a quarter is nothing here
  if (places > 24) return 0;
  const uint16_t fine = shifted(steps_squared.value, places - 8);
  return fine < 64 ? 0 : nearest_root((fine - 64) >> 8);
}

uint8_t straight_steps(Product torque) {
  if (torque.places < 8) return map.top;
  if (torque.places > 24) return 0;
  const uint16_t fine = shifted(torque.value, torque.places - 8);
  const uint8_t whole = fine >> 8;
  const Piece* piece = map.pieces;
  uint8_t from = 0;
  uint16_t begins = 0;
  while (whole >= piece->to) {
    from = piece->to;
    begins += map.width;
    if (++piece == map.pieces + map.piece_count) return map.top;
  }
  const uint16_t along = fine - static_cast<uint16_t>(from << 8);
  const uint16_t duty = begins + along * piece->slope + ((static_cast<uint32_t>(along) * piece->slope_rest) >> 16);
  return (duty + 128) >> 8;
}

}  // namespace


Limited limit(float force) {
  const uint32_t bits = bits_of(force);
  const uint32_t size = bits & ~kSign;
  if (size >= kInfinite) return {0.0f, protocol::kFlagRefused};
  if (size > map.most) return {float_of(map.most | (bits & kSign)), protocol::kFlagClamped};
  return {force, 0};
}

int16_t pwm_of(float force) {
  Halves bits;
  memcpy(&bits, &force, sizeof(bits));
  if ((bits.high & ~kSignHigh) < kSmallest) return 0;
  const Product product = times_factor(bits);
  const uint8_t wanted = map.straight ? straight_steps(product) : square_steps(product);
  if (!wanted) return 0;
  const int16_t pwm = (wanted < map.top ? wanted : map.top) + map.dead_band;
  return bits.high & kSignHigh ? -pwm : pwm;
}

}  // namespace motor
