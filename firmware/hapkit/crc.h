// CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xffff), byte by byte and without a table.
#pragma once

#include <stdint.h>

namespace crc {

constexpr uint16_t kStart = 0xffff;

// Return the CRC after one more byte. After a body and its CRC, high byte first, it is zero.
inline uint16_t update(uint16_t crc, uint8_t byte) {
  uint8_t mix = static_cast<uint8_t>(crc >> 8) ^ byte;
  mix ^= mix >> 4;
  const uint8_t high = static_cast<uint8_t>(crc) ^ static_cast<uint8_t>(mix << 4) ^ (mix >> 3);
  const uint8_t low = mix ^ static_cast<uint8_t>(mix << 5);
  return static_cast<uint16_t>(high << 8) | low;
}

}  // namespace crc
