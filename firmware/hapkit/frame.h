// Frames on the wire: COBS(body, CRC-16 high byte first), then the delimiter 0x00. A body is id and payload.
#pragma once

#include <stdint.h>

#include "crc.h"
#include "protocol.h"

namespace frame {

constexpr uint8_t kLargestBody = 1 + protocol::kLargestFromBoard;
constexpr uint8_t kOverhead = 4;  // CRC, one COBS code (a body stays below 252 bytes), delimiter
static_assert(kLargestBody + kOverhead < 256, "a frame needs more than one COBS block");

// Writes one frame into memory that has room for its body and kOverhead more.
class Writer {
 public:
  Writer() = default;
  explicit Writer(uint8_t* to) : crc_{crc::kStart >> 8, crc::kStart & 0xff}, code_(to), end_(to + 1) {}

  void put(const void* bytes, uint8_t size) { put(this, bytes, size); }

  // Put the CRC and the delimiter; return the end.
  uint8_t* finish();

 private:
  // On the board in assembler, which knows the order of what is below.
  static void put(Writer* self, const void* bytes, uint8_t size) __asm__("frame_put");

  crc::Crc crc_ = {};
  uint8_t* code_ = nullptr;  // of the block that is being filled
  uint8_t* end_ = nullptr;   // behind its last byte
};

// Takes received bytes one by one and tells when a whole valid frame is there. What fits is far shorter than
// a full COBS block, which would have no zero behind it.
class Parser {
 public:
  // Take one byte; return the size of a body that is complete and whose CRC is right, otherwise 0.
  uint8_t push(uint8_t byte);

  // The last complete body: id and payload. Valid until the next push.
  const uint8_t* body() const { return body_; }

  // Frames with a wrong CRC, a wrong structure or too many bytes; wraps.
  uint8_t bad_frames() const { return bad_frames_; }

 private:
  static constexpr uint8_t kCapacity = 1 + protocol::kLargestToBoard + 2;

  void begin_block(uint8_t code);
  void store(uint8_t byte);
  uint8_t finish();
  void reset();

  uint8_t body_[kCapacity] = {};
  uint8_t size_ = 0;      // decoded bytes, CRC included; kCapacity + 1 when there were too many
  uint8_t left_ = 0;      // bytes left in the present COBS block
  bool started_ = false;  // a block has been read; before the next one comes a zero
  uint16_t crc_ = 0;
  uint8_t bad_frames_ = 0;
};

}  // namespace frame
