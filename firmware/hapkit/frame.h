// Frames on the wire: COBS(body, CRC-16 high byte first), then the delimiter 0x00. A body consists of id and
// payload.
#pragma once

#include <stdint.h>

#include "crc.h"
#include "protocol.h"

namespace frame {

constexpr uint8_t kLargestBody = 1 + protocol::kLargestFromBoard;
constexpr uint8_t kOverhead = 4;  // CRC, one COBS code (a body stays below 252 bytes), delimiter
static_assert(kLargestBody + kOverhead < 256, "a frame needs more than one COBS block");

// Writes one frame into memory that has room for the body and kOverhead more bytes.
class Writer {
 public:
  Writer() = default;
  explicit Writer(uint8_t* to) : crc_{crc::kStart >> 8, crc::kStart & 0xff}, code_(to), end_(to + 1) {}

  void put(const void* bytes, uint8_t size) { put(this, bytes, size); }

  // Write the CRC and the delimiter; return the end of the frame.
  uint8_t* finish();

 private:
  // On the board this is written in assembler, which depends on the order of the members below.
  static void put(Writer* self, const void* bytes, uint8_t size) __asm__("frame_put");

  crc::Crc crc_ = {};
  uint8_t* code_ = nullptr;  // the code byte of the open block
  uint8_t* end_ = nullptr;   // the end of the open block
};

// Parses received bytes one by one. COBS adds no zero after a block of 254 bytes, but a valid frame is shorter
// than such a block. So the parser adds a zero between any two blocks.
class Parser {
 public:
  // Process one byte. Return the size of a complete body with the right CRC, otherwise 0.
  uint8_t push(uint8_t byte);

  // Return the last complete body, which consists of id and payload. It is valid until the next push.
  const uint8_t* body() const { return body_; }

  // Return the number of frames with a wrong CRC, a wrong structure or too many bytes; it wraps.
  uint8_t bad_frames() const { return bad_frames_; }

 private:
  static constexpr uint8_t kCapacity = 1 + protocol::kLargestToBoard + 2;

  void begin_block(uint8_t code);
  void store(uint8_t byte);
  uint8_t finish();
  void reset();

  uint8_t body_[kCapacity] = {};
  uint8_t size_ = 0;      // number of decoded bytes with the CRC; kCapacity + 1 if there were too many
  uint8_t left_ = 0;      // number of bytes left in the present COBS block
  bool started_ = false;  // true after a block has been read; a zero then comes before the next block
  uint16_t crc_ = 0;
  uint8_t bad_frames_ = 0;
};

}  // namespace frame
