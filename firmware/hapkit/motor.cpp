#include "motor.h"

#include <string.h>

#include "profile.h"

#ifdef __AVR__
#pragma GCC optimize("O2")
#endif

namespace motor {
namespace {

constexpr uint8_t kPieces = sizeof(protocol::Board::table);
constexpr uint32_t kSign = 0x80000000;
constexpr uint32_t kInfinite = 0x7f800000;

// What multiplies a force: mantissa / 2^16 * 2^exponent, the exponent as a float writes it.
struct Factor {
  uint16_t mantissa;
  int16_t exponent;
};

// A straight piece of the map. Torque is in 255ths of that at full duty, duty in 256ths of a step.
struct Piece {
  uint8_t from, to;     // torque
  uint16_t duty;        // where it begins
  uint8_t slope;        // whole steps a 255th
  uint16_t slope_rest;  // and 65536ths
};

uint32_t most = 0;      // the largest force, as bits
uint8_t dead_band = 0;
uint8_t top = 0;        // steps of duty above the dead band
bool square = true;
Factor factor = {0, 0};  // from newton to steps squared, or to 255ths of the torque at full duty
Piece pieces[kPieces];
uint8_t piece_count = 0;

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

Factor factor_of(float value) {
  const uint32_t bits = bits_of(value) + 0x80;  // to the nearest
  return {static_cast<uint16_t>(0x8000 | (bits >> 8)), static_cast<int16_t>(bits >> 23)};
}

void add_piece(float from, float to, uint8_t low, uint8_t high) {
  if (high == low) return;  // the lowest duty for a torque is enough
  const float slope = (to - from) / (high - low);
  const uint8_t whole = static_cast<uint8_t>(slope);
  const uint16_t rest = static_cast<uint16_t>((slope - whole) * 65536.0f);
  pieces[piece_count++] = {low, high, static_cast<uint16_t>(from * 256.0f), whole, rest};
}

void set_pieces(const protocol::Board& kit) {
  piece_count = 0;
  if (kit.motor_map == protocol::kMotorMapLinear) return add_piece(0.0f, top, 0, 255);
  const float eighth = static_cast<float>(top) / kPieces;
  uint8_t low = 0;
  for (uint8_t i = 0; i < kPieces; ++i) {
    add_piece(i * eighth, (i + 1) * eighth, low, kit.table[i]);
    low = kit.table[i];
  }
}

// A force times the factor is value / 2^places.
struct Product {
  uint16_t value;
  int16_t places;
};

Product times_factor(uint32_t force) {
  const uint16_t mantissa = static_cast<uint16_t>(0x8000 | (force >> 8));
  const uint32_t product = static_cast<uint32_t>(mantissa) * factor.mantissa;
  const int16_t exponent = static_cast<uint16_t>(force >> 16) >> 7;
  const int16_t places = 2 * 127 + 14 - exponent - factor.exponent;
  const uint16_t value = product >> 16;
  if (value & 0x8000) return {value, places};
  const bool next_bit = static_cast<int16_t>(product) < 0;
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
#ifdef __AVR__  // the compiler takes half as long again
  uint8_t bit = 0x80, larger, below;
  __asm__(
      "1:\tmov %2, %0\n\t"
      "or %2, %1\n\t"
      "mov %3, %2\n\t"
      "dec %3\n\t"
      "mul %2, %3\n\t"
      "cp %A4, r0\n\t"
      "cpc %B4, r1\n\t"
      "brlo 2f\n\t"
      "mov %0, %2\n"
      "2:\tlsr %1\n\t"
      "brne 1b\n\t"
      "clr __zero_reg__"
      : "+&r"(root), "+&r"(bit), "=&r"(larger), "=&r"(below)
      : "r"(square_less_quarter));
#else
  for (uint8_t bit = 0x80; bit; bit >>= 1) {
    const uint8_t larger = root | bit;
    if (static_cast<uint16_t>(larger * static_cast<uint8_t>(larger - 1)) <= square_less_quarter) root = larger;
  }
#endif
  return root;
}

uint8_t square_steps(Product steps_squared) {
  const int16_t places = steps_squared.places;
  if (places < 0) return top;
  if (places < 8) return nearest_root(shifted(steps_squared.value, places));  // a quarter is nothing here
  if (places > 24) return 0;
  const uint16_t fine = shifted(steps_squared.value, places - 8);
  return fine < 64 ? 0 : nearest_root((fine - 64) >> 8);
}

uint8_t straight_steps(Product torque) {
  if (torque.places < 8) return top;
  if (torque.places > 24) return 0;
  const uint16_t fine = shifted(torque.value, torque.places - 8);
  const uint8_t whole = fine >> 8;
  const Piece* piece = pieces;
  while (whole >= piece->to) {
    if (++piece == pieces + piece_count) return top;
  }
  const uint16_t along = fine - static_cast<uint16_t>(piece->from << 8);
  const uint16_t duty = piece->duty + along * piece->slope +
                        ((static_cast<uint32_t>(along) * piece->slope_rest) >> 16);
  return (duty + 128) >> 8;
}

}  // namespace

void set(const protocol::Board& kit) {
  most = bits_of(kit.max_force);
  dead_band = kit.dead_band;
  top = profile::kPwmTop - dead_band;
  square = kit.motor_map == protocol::kMotorMapSquare;
  // torque = force * handle radius * pulley radius / sector radius, as a share of that at full duty
  const float share = kit.handle_radius * kit.pulley_radius / kit.sector_radius / kit.motor_constant;
  factor = factor_of(square ? share * top * top : share * 255.0f);
  set_pieces(kit);
}

// Floats of one sign are in the order of their bits; what is not finite comes last.
bool allows(float force) { return (bits_of(force) & ~kSign) <= most; }

Limited limit(float force) {
  const uint32_t bits = bits_of(force);
  const uint32_t size = bits & ~kSign;
  if (size >= kInfinite) return {0.0f, protocol::kFlagRefused};
  if (size > most) return {float_of(most | (bits & kSign)), protocol::kFlagClamped};
  return {force, 0};
}

int16_t pwm_of(float force) {
  const uint32_t bits = bits_of(force);
  const Product product = times_factor(bits & ~kSign);
  const uint8_t wanted = square ? square_steps(product) : straight_steps(product);
  if (!wanted) return 0;
  const int16_t pwm = (wanted < top ? wanted : top) + dead_band;
  return bits & kSign ? -pwm : pwm;
}

}  // namespace motor
