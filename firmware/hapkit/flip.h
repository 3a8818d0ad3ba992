// Follows a sensor that begins anew, over and over, as the motor turns.
#pragma once

#include <stdint.h>

// A jump of more than half the sensor's range from one reading to the next is such a beginning, so up to half
// the range per sample may be travelled; its size is fixed, so errors do not add up.
//
// Just where it begins anew, a reading may fall between the end and the beginning. A handle changes its speed
// by less than an eighth of the range per sample: what asks for more is bridged, as if the motion went on,
// and followed on the side. Readings that fit the old motion again make good for it; two in a row that make
// another motion on the side are the truth.
class FlipTracker {
 public:
  // Begin with the next reading. counts: from one beginning to the next, 8..16384; 0 means 65536 and that
  // every jump is believed.
  void start(uint16_t counts) {
    counts_ = counts;
    slack_ = counts / 8;
    started_ = false;
  }

  // Return the reading plus all that was passed so far; the first reading has passed nothing.
  int32_t update(uint16_t raw) {
    if (!started_) return begin(raw);
    const int16_t jump = nearest(raw - last_);
    if (!counts_ || alike(jump, going_)) return follow(raw, jump);
    return doubt(raw, jump);
  }

  // Whether the last reading was bridged.
  bool doubtful() const { return bridged_ != 0; }

 private:
  static constexpr uint8_t kPatience = 8;  // readings bridged in a row; then the next one is believed

  // The same difference less whole ranges: half the range at most.
  int16_t nearest(int16_t difference) const {
    const int16_t half = counts_ / 2;
    if (!counts_) return difference;
    if (difference > half) return difference - counts_;
    return difference < -half ? difference + counts_ : difference;
  }

  bool alike(int16_t step, int16_t other) const {
    const int16_t change = step - other;
    return -slack_ <= change && change <= slack_;
  }

  int32_t begin(uint16_t raw) {
    started_ = true;
    bridged_ = 0;
    step_ = going_ = 0;
    last_ = raw;
    return position_ = raw;
  }

  // What two steps have in common: the smaller one, nothing if they lead apart.
  static int16_t common(int16_t a, int16_t b) {
    if ((a < 0) != (b < 0)) return 0;
    return (a < b) == (a < 0) ? b : a;
  }

  // The motion that goes on is what the last two steps have in common.
  int32_t follow(uint16_t raw, int16_t jump) {
    going_ = common(step_, jump);
    step_ = jump;
    last_ = raw;
    bridged_ = 0;
    return position_ += jump;
  }

  int32_t doubt(uint16_t raw, int16_t jump) {
    const int16_t further = bridged_ ? nearest(raw - aside_) : jump;
    const bool one_motion = bridged_ && alike(further, aside_step_);
    aside_position_ = (bridged_ ? aside_position_ : position_) + further;
    if (one_motion || bridged_ == kPatience) {
      position_ = aside_position_ - further;
      step_ = aside_step_;
      return follow(raw, further);
    }
    aside_step_ = further;
    aside_ = raw;
    return bridge();
  }

  int32_t bridge() {
    ++bridged_;
    last_ += going_;
    if (last_ < 0) last_ += counts_;
    if (last_ >= static_cast<int16_t>(counts_)) last_ -= counts_;
    return position_ += going_;
  }

  int32_t position_ = 0;
  uint16_t counts_ = 0;
  int16_t last_ = 0;  // the reading that belongs to position_
  int16_t slack_ = 0;
  int16_t step_ = 0;   // the last one that was believed
  int16_t going_ = 0;  // the motion that goes on
  int32_t aside_position_ = 0;  // where the doubtful readings lead
  uint16_t aside_ = 0;
  int16_t aside_step_ = 0;
  uint8_t bridged_ = 0;
  bool started_ = false;
};
