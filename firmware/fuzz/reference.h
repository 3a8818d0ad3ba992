// The simplest possible implementation of the frames: the reference for the firmware's parser.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace reference {

using Bytes = std::vector<uint8_t>;

inline uint16_t crc_of(const Bytes& bytes) {
  uint32_t crc = 0xffff;
  for (uint8_t byte : bytes) {
    crc ^= static_cast<uint32_t>(byte) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ (crc & 0x8000 ? 0x11021 : 0);
  }
  return static_cast<uint16_t>(crc);
}

// Return the frame of a body, with its delimiter.
inline Bytes frame_of(Bytes body) {
  const uint16_t crc = crc_of(body);
  body.push_back(crc >> 8);
  body.push_back(crc & 0xff);
  Bytes coded{0};
  std::size_t code = 0;
  for (uint8_t byte : body) {
    coded.push_back(byte);
    if (byte != 0) continue;
    coded[code] = static_cast<uint8_t>(coded.size() - 1 - code);
    code = coded.size() - 1;
  }
  coded[code] = static_cast<uint8_t>(coded.size() - code);
  coded.push_back(0);
  return coded;
}

// Decode a frame without its delimiter into body; return false if structure, length or CRC are wrong.
inline bool body_of(const Bytes& coded, std::size_t largest, Bytes* body) {
  body->clear();
  for (std::size_t at = 0; at < coded.size(); at += coded[at]) {
    if (at + coded[at] > coded.size()) return false;
    if (at) body->push_back(0);
    body->insert(body->end(), coded.begin() + at + 1, coded.begin() + at + coded[at]);
  }
  if (body->size() < 3 || body->size() > largest + 2 || crc_of(*body) != 0) return false;
  body->resize(body->size() - 2);
  return true;
}

}  // namespace reference
