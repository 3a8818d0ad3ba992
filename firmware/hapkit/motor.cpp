#include "motor.h"

#include "motor_map.h"

namespace motor {
namespace {

// Constants for the upper half of a float.
constexpr uint16_t kSign = 0x8000;
constexpr uint16_t kInfinite = 0x7f80;
constexpr uint16_t kSmallest = 0x0080;  // below this value the mantissa has no leading one

// A force times the factor equals value / 2^places.
struct Product {
  uint16_t value;
  int16_t places;
};

Product times_factor(Halves force) {
  const uint16_t mantissa = 0x8000 | static_cast<uint8_t>(force.high) << 8 | force.low >> 8;
  const uint32_t whole = static_cast<uint32_t>(mantissa) * map.factor.mantissa;
  const int16_t places = map.factor.places - (force.high >> 7);
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

// Return root with one more bit set, unless it would then exceed the rounded square root of a number q. An
// integer n does not exceed this square root if (n - 1/2)^2 = n (n - 1) + 1/4 is at most q. The last argument
// is q - 1/4.
__attribute__((always_inline)) inline uint8_t with_bit(uint8_t bit, uint8_t root, uint16_t square_less_quarter) {
  const uint8_t larger = root | bit;
  return static_cast<uint16_t>(larger * static_cast<uint8_t>(larger - 1)) <= square_less_quarter ? larger : root;
}

// The loop over the bits is unrolled, because it would take 50 % longer in every tick.
uint8_t nearest_root(uint16_t square_less_quarter) {
  uint8_t root = with_bit(0x80, 0, square_less_quarter);
  root = with_bit(0x40, root, square_less_quarter);
  root = with_bit(0x20, root, square_less_quarter);
  root = with_bit(0x10, root, square_less_quarter);
  root = with_bit(0x08, root, square_less_quarter);
  root = with_bit(0x04, root, square_less_quarter);
  root = with_bit(0x02, root, square_less_quarter);
  return with_bit(0x01, root, square_less_quarter);
}

uint8_t square_steps(Product steps_squared) {
  const int16_t places = steps_squared.places;
  if (places < 0) return map.top;
  if (places < 8) return nearest_root(shifted(steps_squared.value, places));  // here a quarter is negligible
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

uint8_t steps_of(Halves force) {
  if (force.high < kSmallest) return 0;
  const Product product = times_factor(force);
  const uint8_t wanted = map.straight ? straight_steps(product) : square_steps(product);
  return wanted < map.top ? wanted : map.top;
}

}  // namespace

// Floats of one sign are ordered like their bits; floats that are not finite come last.
Duty duty_of(float force) {
  Halves size = halves_of(force);
  const bool left = size.high & kSign;
  size.high &= ~kSign;
  if (size.high >= kInfinite) return {0, protocol::kFlagRefused};
  int16_t pwm = map.full;
  uint8_t flags = protocol::kFlagClamped;
  if (size.high < map.most.high || (size.high == map.most.high && size.low <= map.most.low)) {
    const uint8_t steps = steps_of(size);
    pwm = steps ? steps + map.dead_band : 0;
    flags = 0;
  }
  return {left ? static_cast<int16_t>(-pwm) : pwm, flags};
}

}  // namespace motor
