// A queue of bytes between one writer and one reader; either of them may be an interrupt.
#pragma once

#include <stdint.h>

// One place stays empty. Each index has one writer and is a single byte, so neither side must disable
// interrupts.
template <uint8_t Size>
class Ring {
 public:
  bool push(uint8_t byte) {
    const uint8_t next = after(head_);
    if (next == tail_) return false;
    bytes_[next] = byte;
    head_ = next;
    return true;
  }

  bool pop(uint8_t* byte) {
    if (head_ == tail_) return false;
    const uint8_t next = after(tail_);
    *byte = bytes_[next];
    tail_ = next;
    return true;
  }

  bool empty() const { return head_ == tail_; }

 private:
  static uint8_t after(uint8_t place) { return place + 1 == Size ? 0 : place + 1; }

  volatile uint8_t bytes_[Size] = {};
  volatile uint8_t head_ = 0;
  volatile uint8_t tail_ = 0;
};
