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
  // Forget everything. counts: from one beginning to the next, 8..16384; 0 means 65536 and that
  // every jump is believed.
  void start(uint16_t counts) {
    counts_ = counts;
    slack_ = counts ? counts / 8 : 32767;
    position_ = 0;
  }

  // Take the first reading, which stands for this place.
  void begin(uint16_t raw, int32_t position) {
    position_ = position;
    last_ = raw;
    step_ = going_ = 0;
    bridged_ = 0;
  }

  // Count from elsewhere.
  void shift(int32_t by) { position_ += by; }

  // Take a reading that goes on with the motion; false, and nothing is changed, for any other.
  bool follow(uint16_t raw) {
    const int16_t jump = nearest(raw - last_);
    if (!alike(jump, going_)) return false;
    going_ = common(step_, jump);
    step_ = jump;
    last_ = raw;
    position_ += jump;
    return true;
  }

  // Take any reading; return the first place plus all that was passed and shifted since.
  int32_t update(uint16_t raw) {
    if (follow(raw) || (settle(raw) && follow(raw))) bridged_ = 0;
    return position_;
  }

  // What update() returned last.
  int32_t position() const { return position_; }

  // Whether the last reading was bridged.
  bool doubtful() const { return bridged_ != 0; }

 private:
  static constexpr uint8_t kPatience = 8;  // readings bridged in a row; then the next one is believed

  // The same difference less whole ranges: half the range at most.
  __attribute__((always_inline)) int16_t nearest(int16_t difference) const {
    if (static_cast<uint16_t>(difference + counts_ / 2) < counts_ || !counts_) return difference;
    return difference < 0 ? difference + counts_ : difference - counts_;
  }

  bool alike(int16_t step, int16_t other) const {
    return static_cast<uint16_t>(static_cast<uint16_t>(step) - other + slack_) <= 2 * slack_;
  }

  // The motion that goes on is what the last two steps have in common: the smaller one, nothing if they lead apart.
  static int16_t common(int16_t a, int16_t b) {
    if ((a ^ b) < 0) return 0;
    if (a < 0) return a < b ? b : a;
    return a < b ? a : b;
  }

  // Take a doubtful reading; return whether the motion on the side is believed now, which it then goes on with. If
  // not, the reading is bridged.
  bool settle(uint16_t raw) {
    const int16_t further = nearest(raw - (bridged_ ? aside_ : static_cast<uint16_t>(last_)));
    const bool one_motion = bridged_ ? alike(further, aside_step_) : !counts_;
    if (!bridged_) aside_ahead_ = 0;
    const bool believed = one_motion || bridged_ == kPatience;
    if (believed) {
      position_ += aside_ahead_;
      step_ = aside_step_;
      going_ = nearest(further);  // as it will look from there
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
  int16_t last_ = 0;  // the reading that belongs to position_
  uint16_t slack_ = 0;
  int16_t step_ = 0;   // the last one that was believed
  int16_t going_ = 0;  // the motion that goes on
  int32_t aside_ahead_ = 0;  // where the doubtful readings lead, from position_
  uint16_t aside_ = 0;
  int16_t aside_step_ = 0;
  uint8_t bridged_ = 0;
};
