// Protocol of an AS5048A, a magnetic angle sensor of 14 bits on the SPI bus.
#pragma once

#include <stdint.h>

// A frame is 16 bits: even parity, the read bit of a request or the error bit of a reply, 14 data bits.
// A reply comes in the frame after its request. Each reading requests the angle, then the sensor's
// diagnostics, whose reply comes at the beginning of the next reading.
class As5048A {
 public:
  static constexpr uint16_t kReadAngle = 0xffff;
  static constexpr uint16_t kReadHealth = 0x7ffd;
  static constexpr uint16_t kClearError = 0x4001;

  // The request after the angle. An error bit stays set until it is cleared.
  uint16_t next() {
    asked_ = clear_ ? kClearError : kReadHealth;
    return asked_;
  }

  // Process the replies to the last reading's second request and to this one's first; false if this reading
  // is invalid.
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

  // The last valid angle, 0..16383.
  uint16_t reading() const { return reading_; }

  // True if a frame has even parity and no error bit.
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
  static constexpr uint16_t kSettled = 0x0100;   // diagnostics: start-up finished
  static constexpr uint16_t kOverflow = 0x0200;  // diagnostics: the angle is invalid

  uint16_t reading_ = 0;
  uint16_t asked_ = 0;
  bool clear_ = false;
  bool expected_ = false;  // the next frame begins with a reply with diagnostics
  bool begun_ = false;
};
