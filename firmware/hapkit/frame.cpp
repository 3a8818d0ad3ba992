#include "frame.h"

namespace frame {

// COBS: each zero is replaced by the distance to the next zero, which is written before the bytes in between.
#ifndef __AVR__
void Writer::put(Writer* self, const void* bytes, uint8_t size) {
  const uint8_t* from = static_cast<const uint8_t*>(bytes);
  crc::Crc crc = self->crc_;
  uint8_t* code = self->code_;
  uint8_t* end = self->end_;
  for (; size; --size) {
    const uint8_t byte = *from++;
    crc.add(byte);
    if (byte) {
      *end++ = byte;
    } else {
      *code = static_cast<uint8_t>(end - code);
      code = end++;
    }
  }
  self->crc_ = crc;
  self->code_ = code;
  self->end_ = end;
}
#endif

uint8_t* Writer::finish() {
  const uint8_t check[] = {crc_.high, crc_.low};
  put(check, sizeof(check));
  *code_ = static_cast<uint8_t>(end_ - code_);
  *end_++ = 0;
  return end_;
}

uint8_t Parser::push(uint8_t byte) {
  if (byte == 0) return finish();
  if (left_ == 0) {
    begin_block(byte);
  } else {
    --left_;
    store(byte);
  }
  return 0;
}

void Parser::begin_block(uint8_t code) {
  if (started_) {
    store(0);
  } else {
    crc_ = crc::kStart;
    started_ = true;
  }
  left_ = code - 1;
}

__attribute__((noinline)) void Parser::store(uint8_t byte) {
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
  started_ = false;
}

}  // namespace frame
