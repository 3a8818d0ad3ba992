#include "frame.h"

namespace frame {
namespace {

// Writes bytes COBS coded: each zero becomes the distance to the next one.
class Stuffer {
 public:
  explicit Stuffer(uint8_t* out) : code_(out), next_(out + 1) {}

  void put(uint8_t byte) {
    if (byte == 0) {
      *code_ = static_cast<uint8_t>(next_ - code_);
      code_ = next_;
    } else {
      *next_ = byte;
    }
    ++next_;
  }

  uint8_t* finish() {
    *code_ = static_cast<uint8_t>(next_ - code_);
    *next_ = 0;
    return next_ + 1;
  }

 private:
  uint8_t* code_;
  uint8_t* next_;
};

}  // namespace

uint8_t encode(const uint8_t* body, uint8_t size, uint8_t* out) {
  Stuffer stuffer(out);
  uint16_t sum = crc::kStart;
  for (uint8_t i = 0; i < size; ++i) {
    sum = crc::update(sum, body[i]);
    stuffer.put(body[i]);
  }
  stuffer.put(static_cast<uint8_t>(sum >> 8));
  stuffer.put(static_cast<uint8_t>(sum));
  return static_cast<uint8_t>(stuffer.finish() - out);
}

uint8_t Parser::push(uint8_t byte) {
  if (byte == 0) return finish();
  if (left_ == 0) {
    if (zero_due_) store(0);
    left_ = byte - 1;
    zero_due_ = byte != 0xff;
    started_ = true;
  } else {
    --left_;
    store(byte);
  }
  return 0;
}

void Parser::store(uint8_t byte) {
  if (size_ < kCapacity) {
    body_[size_++] = byte;
    crc_ = crc::update(crc_, byte);
  } else {
    size_ = kCapacity + 1;
  }
}

uint8_t Parser::finish() {
  const bool valid = left_ == 0 && size_ >= 3 && size_ <= kCapacity && crc_ == 0;
  const uint8_t size = valid ? size_ - 2 : 0;
  if (started_ && !valid) ++bad_frames_;
  reset();
  return size;
}

void Parser::reset() {
  size_ = 0;
  left_ = 0;
  zero_due_ = false;
  started_ = false;
  crc_ = crc::kStart;
}

}  // namespace frame
