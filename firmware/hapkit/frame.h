// Frames on the wire: COBS(body, CRC-16 high byte first), then the delimiter 0x00. A body is id and payload.
#pragma once

#include <stdint.h>

#include "crc.h"
#include "protocol.h"

namespace frame {

constexpr uint8_t kLargestBody = 1 + protocol::kLargestFromBoard;
constexpr uint8_t kOverhead = 4;  // CRC, one COBS code (a body stays below 252 bytes), delimiter
static_assert(kLargestBody + kOverhead < 256, "a frame needs more than one COBS block");

// Writes one frame to a sink, any callable that takes bytes and their number. The first blocks go out while the
// rest is still being coded.
template <class Sink>
class Writer {
 public:
  explicit Writer(Sink sink) : sink_(sink) {}

  void put(uint8_t byte) { put(&byte, 1); }

  void put(const void* bytes, uint8_t size) {
    crc_ = stuff(static_cast<const uint8_t*>(bytes), size, crc_);
  }

  void finish() {
    const uint8_t check[] = {crc_.high, crc_.low};
    stuff(check, sizeof(check), crc_);
    *code_ = static_cast<uint8_t>(end_ - code_);
    *end_++ = 0;
    sink_(unsent_, static_cast<uint8_t>(end_ - unsent_));
  }

 private:
  static constexpr uint8_t kWorthIt = 8;  // bytes for a call of the sink

  // COBS: a zero becomes the distance to the next one, written before the bytes between them. Return the CRC
  // after these bytes.
  crc::Crc stuff(const uint8_t* bytes, uint8_t size, crc::Crc crc) {
    uint8_t* end = end_;
    uint8_t* code = code_;
    for (; size; --size) {
      const uint8_t byte = *bytes++;
      crc.add(byte);
      if (byte) {
        *end++ = byte;
        continue;
      }
      *code = static_cast<uint8_t>(end - code);
      code = end++;
      if (static_cast<uint8_t>(code - unsent_) >= kWorthIt) {
        sink_(unsent_, static_cast<uint8_t>(code - unsent_));
        unsent_ = code;
      }
    }
    end_ = end;
    code_ = code;
    return crc;
  }

  Sink sink_;
  crc::Crc crc_;
  uint8_t* unsent_ = coded_;
  uint8_t* code_ = coded_;     // of the block that is being filled
  uint8_t* end_ = coded_ + 1;  // behind its last byte
  uint8_t coded_[kLargestBody + kOverhead];
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
