// Frames on the wire: COBS(body, CRC-16 high byte first), then the delimiter 0x00. A body is id and payload.
#pragma once

#include <stdint.h>

#include "crc.h"
#include "protocol.h"

namespace frame {

constexpr uint8_t kLargestBody = 1 + protocol::kLargestFromBoard;
constexpr uint8_t kOverhead = 4;  // CRC, one COBS code (a body stays below 252 bytes), delimiter
static_assert(kLargestBody + kOverhead < 256, "a frame needs more than one COBS block");

// Writes one frame to a sink, any callable that takes bytes and their number. A block goes out as soon as it
// is known, so the first bytes are on their way while the rest is still being coded.
template <class Sink>
class Writer {
 public:
  explicit Writer(Sink sink) : sink_(sink) {}

  void put(uint8_t byte) {
    crc_ = crc::update(crc_, byte);
    stuff(byte);
  }

  void put(const void* bytes, uint8_t size) {
    const uint8_t* next = static_cast<const uint8_t*>(bytes);
    while (size--) put(*next++);
  }

  void finish() {
    const uint16_t crc = crc_;
    stuff(static_cast<uint8_t>(crc >> 8));
    stuff(static_cast<uint8_t>(crc));
    block_[0] = size_;
    block_[size_++] = 0;
    sink_(block_, size_);
  }

 private:
  // COBS: a zero becomes the distance to the next one, written before the bytes between them.
  void stuff(uint8_t byte) {
    if (byte != 0) {
      block_[size_++] = byte;
      return;
    }
    block_[0] = size_;
    sink_(block_, size_);
    size_ = 1;
  }

  Sink sink_;
  uint16_t crc_ = crc::kStart;
  uint8_t size_ = 1;  // of the block, its code included
  uint8_t block_[kLargestBody + kOverhead];
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

  void store(uint8_t byte);
  uint8_t finish();
  void reset();

  uint8_t body_[kCapacity];
  uint8_t size_ = 0;      // decoded bytes, CRC included; kCapacity + 1 when there were too many
  uint8_t left_ = 0;      // bytes left in the present COBS block
  bool started_ = false;  // a block has been read; before the next one comes a zero
  uint16_t crc_ = crc::kStart;
  uint8_t bad_frames_ = 0;
};

}  // namespace frame
