// A queue of bytes between one writer and one reader, of which either may be an interrupt.
#pragma once

#include <stdint.h>

// Size is a power of two up to 128; one place stays empty. Each index has one writer and is a single byte,
// so neither side needs to hold interrupts off.
template <uint8_t Size>
class Ring {
  static_assert(Size >= 2 && Size <= 128 && (Size & (Size - 1)) == 0, "Size is a power of two up to 128");

 public:
  bool push(uint8_t byte) {
    const uint8_t next = (head_ + 1) & kMask;
    if (next == tail_) return false;
    bytes_[next] = byte;
    head_ = next;
    return true;
  }

  bool pop(uint8_t* byte) {
    if (head_ == tail_) return false;
    const uint8_t next = (tail_ + 1) & kMask;
    *byte = bytes_[next];
    tail_ = next;
    return true;
  }

  uint8_t room() const { return static_cast<uint8_t>(tail_ - head_ - 1) & kMask; }
  uint8_t written() const { return head_; }  // the place last written
  uint8_t read() const { return tail_; }     // and the one last read
  bool empty() const { return head_ == tail_; }

  // For a reader or writer in assembler: the bytes, then the place last written, then the place last read.
  static constexpr uint8_t kMask = Size - 1;
  static constexpr uint16_t kHead = Size;
  static constexpr uint16_t kTail = Size + 1;

 private:
  volatile uint8_t bytes_[Size];
  volatile uint8_t head_ = 0;
  volatile uint8_t tail_ = 0;
};
