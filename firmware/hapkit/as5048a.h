// What travels between the board and an AS5048A, a magnetic angle sensor of 14 bits on the SPI bus.
#pragma once

#include <stdint.h>

// A frame is 16 bits: even parity, for a question the bit for reading and for an answer the error bit, 14 of
// data. An answer comes in the frame after its question. Each reading asks for the angle, then for the
// sensor's health, whose answer begins the next reading.
class As5048A {
 public:
  static constexpr uint16_t kReadAngle = 0xffff;
  static constexpr uint16_t kReadHealth = 0x7ffd;
  static constexpr uint16_t kClearError = 0x4001;

  // The question after that for the angle. An error bit stands until it is cleared.
  uint16_t next() {
    asked_ = clear_ ? kClearError : kReadHealth;
    return asked_;
  }

  // Take the answers to the last reading's second question and to this one's first; false if this reading
  // cannot be trusted.
  bool take(uint16_t health, uint16_t angle) {
    const bool healthy = expected_ && whole(health) && (health & kSettled) && !(health & kOverflow);
    const bool after_clearing = !expected_ && begun_;
    const bool good = whole(angle) && (healthy || after_clearing);
    clear_ = (health | angle) & kError;
    expected_ = asked_ == kReadHealth;
    begun_ = true;
    if (good) reading_ = angle & kData;
    return good;
  }

  // The last angle that could be trusted, 0..16383.
  uint16_t reading() const { return reading_; }

  // Whether a frame has even parity and no error bit.
  static bool whole(uint16_t frame) {
    uint8_t bits = static_cast<uint8_t>(frame >> 8) ^ static_cast<uint8_t>(frame);
    bits ^= bits >> 4;
    bits ^= bits >> 2;
    bits ^= bits >> 1;
    return !(bits & 1) && !(frame & kError);
  }

 private:
  static constexpr uint16_t kError = 0x4000;
  static constexpr uint16_t kData = 0x3fff;
  static constexpr uint16_t kSettled = 0x0100;   // of the health: start-up is over
  static constexpr uint16_t kOverflow = 0x0200;  // the angle is not valid

  uint16_t reading_ = 0;
  uint16_t asked_ = 0;
  bool clear_ = false;
  bool expected_ = false;  // the next frame begins with an answer about the health
  bool begun_ = false;
};
