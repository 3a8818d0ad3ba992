// CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xffff), byte by byte and without a table.
#pragma once

#include <stdint.h>

namespace crc {

constexpr uint16_t kStart = 0xffff;

// The CRC as two bytes, which suits an 8-bit chip.
struct Crc {
  uint8_t high, low;

  void add(uint8_t byte) {
    uint8_t mix = high ^ byte;
    mix ^= mix >> 4;
    high = low ^ static_cast<uint8_t>(mix << 4) ^ (mix >> 3);
    low = mix ^ static_cast<uint8_t>(mix << 5);
  }
};

// Return the CRC after one more byte. It is zero after a body and its CRC, high byte first.
inline uint16_t update(uint16_t crc, uint8_t byte) {
  Crc next = {static_cast<uint8_t>(crc >> 8), static_cast<uint8_t>(crc)};
  next.add(byte);
  return static_cast<uint16_t>(next.high << 8) | next.low;
}

}  // namespace crc
