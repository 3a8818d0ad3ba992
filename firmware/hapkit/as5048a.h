// The protocol of an AS5048A, a magnetic angle sensor with 14 bits on the SPI bus.
#pragma once

#include <stdint.h>

// A frame has 16 bits: even parity, the read bit of a request or the error bit of a reply, and 14 data bits.
// A reply comes in the frame after its request. Each reading requests the angle, and then the diagnostics of
// the sensor, whose reply comes at the beginning of the next reading.
class As5048A {
 public:
  static constexpr uint16_t kReadAngle = 0xffff;
  static constexpr uint16_t kReadHealth = 0x7ffd;
  static constexpr uint16_t kClearError = 0x4001;

  // Return the request that follows the angle. An error bit stays set until it is cleared.
  uint16_t next() {
    asked_ = clear_ ? kClearError : kReadHealth;
    return asked_;
  }

  // Process two replies: to the second request of the last reading, and to the first request of this reading.
  // Return false if this reading is invalid.
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

  // Return the last valid angle, 0..16383.
  uint16_t reading() const { return reading_; }

  // Return true if a frame has even parity and no error bit.
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
  bool expected_ = false;  // the next frame begins with a reply that contains diagnostics
  bool begun_ = false;
};
