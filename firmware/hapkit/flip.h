// Unwraps a sensor whose reading wraps repeatedly as the motor turns.
#pragma once

#include <stdint.h>

// A jump of more than half the sensor's range between two readings is a wrap, so the handle may travel up to
// half the range per sample. The range is constant, so errors do not accumulate.
//
// At the wrap, a reading may fall between both ends. A handle changes its speed by less than an eighth of the
// range per sample. A reading that implies a larger change is bridged: the motion is extrapolated, while a
// second hypothesis is tracked. Readings that fit the old motion again end the doubt. Two consecutive
// readings that fit the second hypothesis confirm it.
class FlipTracker {
 public:
  // Reset. counts is the range of the sensor, 8..16384; 0 means 65536, and every jump is accepted.
  void start(uint16_t counts) {
    counts_ = counts;
    slack_ = counts ? counts / 8 : 32767;
    position_ = 0;
  }

  // Set the first reading and its position.
  void begin(uint16_t raw, int32_t position) {
    position_ = position;
    last_ = raw;
    step_ = going_ = 0;
    bridged_ = 0;
  }

  // Shift the position.
  void shift(int32_t by) { position_ += by; }

  // Process a reading that continues the motion; return false without changes for any other reading.
  bool follow(uint16_t raw) {
    const int16_t jump = nearest(raw - last_);
    if (!alike(jump, going_)) return false;
    going_ = common(step_, jump);
    step_ = jump;
    last_ = raw;
    position_ += jump;
    return true;
  }

  // Process any reading; return the unwrapped position, which includes shifts.
  int32_t update(uint16_t raw) {
    if (follow(raw) || (settle(raw) && follow(raw))) bridged_ = 0;
    return position_;
  }

  // Return the last result of update().
  int32_t position() const { return position_; }

  // Return true if the last reading was bridged.
  bool doubtful() const { return bridged_ != 0; }

 private:
  // number of consecutive readings that are bridged; the next one is accepted
  static constexpr uint8_t kPatience = 8;

  // Return the difference modulo the range; its size is at most half the range.
  __attribute__((always_inline)) int16_t nearest(int16_t difference) const {
    if (static_cast<uint16_t>(difference + counts_ / 2) < counts_ || !counts_) return difference;
    return difference < 0 ? difference + counts_ : difference - counts_;
  }

  bool alike(int16_t step, int16_t other) const {
    return static_cast<uint16_t>(static_cast<uint16_t>(step) - other + slack_) <= 2 * slack_;
  }

  // Return the smaller one of the last two steps, or 0 if they have opposite signs. This is the extrapolated
  // step.
  static int16_t common(int16_t a, int16_t b) {
    if ((a ^ b) < 0) return 0;
    if (a < 0) return a < b ? b : a;
    return a < b ? a : b;
  }

  // Process a doubtful reading. Return true if the second hypothesis is confirmed and replaces the motion.
  // Otherwise the reading is bridged.
  bool settle(uint16_t raw) {
    const int16_t further = nearest(raw - (bridged_ ? aside_ : static_cast<uint16_t>(last_)));
    const bool one_motion = bridged_ ? alike(further, aside_step_) : !counts_;
    if (!bridged_) aside_ahead_ = 0;
    const bool believed = one_motion || bridged_ == kPatience;
    if (believed) {
      position_ += aside_ahead_;
      step_ = aside_step_;
      going_ = nearest(further);  // extrapolate with the step between the last two readings
      last_ = raw - further;
    }
    aside_ahead_ += further;
    aside_step_ = further;
    aside_ = raw;
    if (!believed) bridge();
    return believed;
  }

  void bridge() {
    ++bridged_;
    last_ += going_;
    if (last_ < 0) last_ += counts_;
    if (last_ >= static_cast<int16_t>(counts_)) last_ -= counts_;
    position_ += going_;
    aside_ahead_ -= going_;
  }

  int32_t position_ = 0;
  uint16_t counts_ = 0;
  int16_t last_ = 0;  // reading at position_
  uint16_t slack_ = 0;
  int16_t step_ = 0;   // last accepted step
  int16_t going_ = 0;  // extrapolated step
  int32_t aside_ahead_ = 0;  // position of the second hypothesis relative to position_
  uint16_t aside_ = 0;
  int16_t aside_step_ = 0;
  uint8_t bridged_ = 0;
};
