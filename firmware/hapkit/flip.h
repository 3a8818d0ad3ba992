// Follows a sensor that begins anew, over and over, as the motor turns.
#pragma once

#include <stdint.h>

// A jump of more than half the sensor's range from one reading to the next is such a beginning, so up to half
// the range per sample may be travelled; its size is fixed, so errors do not add up.
//
// Just where it begins anew, a reading may fall between the end and the beginning. What does not fit the
// motion is therefore bridged, as if the motion went on, until the next readings fit the old motion or make a
// motion of their own. A handle changes its speed by less than an eighth of the range per sample.
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
    if (fits(jump)) return accept(raw, jump);
    return bridged_ ? question(raw, jump) : bridge(raw, jump);
  }

  // Whether the last reading was bridged.
  bool doubtful() const { return bridged_ != 0; }

 private:
  static constexpr uint8_t kPatience = 8;  // readings bridged in a row; then the next one counts as it is

  // The same difference less whole ranges: half the range at most.
  int16_t nearest(int16_t difference) const {
    if (!counts_) return difference;
    const int16_t half = counts_ / 2;
    if (difference > half) return difference - counts_;
    return difference < -half ? difference + counts_ : difference;
  }

  // Anything between standing still and going on as before, and a little more.
  bool fits(int16_t jump) const {
    if (!counts_) return true;
    const int16_t least = (step_ < 0 ? step_ : 0) - slack_;
    const int16_t most = (step_ > 0 ? step_ : 0) + slack_;
    return least <= jump && jump <= most;
  }

  int32_t begin(uint16_t raw) {
    started_ = true;
    position_ = raw;
    last_ = raw;
    step_ = 0;
    bridged_ = 0;
    return position_;
  }

  int32_t accept(uint16_t raw, int16_t jump) {
    position_ += jump;
    last_ = raw;
    step_ = jump;
    bridged_ = 0;
    return position_;
  }

  // Go on as before, and keep in mind where this reading would lead.
  int32_t bridge(uint16_t raw, int16_t jump) {
    ++bridged_;
    suspect_ = raw;
    suspect_jump_ = jump;
    suspect_ahead_ = jump - step_;
    position_ += step_;
    last_ += step_;
    return position_;
  }

  // Two readings in a row that make one motion are right after all.
  int32_t question(uint16_t raw, int16_t jump) {
    const int16_t further = nearest(raw - suspect_);
    const int16_t change = further - suspect_jump_;
    if (-slack_ <= change && change <= slack_) {
      position_ += suspect_ahead_;
      return accept(raw, further);
    }
    if (bridged_ < kPatience) return bridge(raw, jump);
    accept(raw, jump);
    step_ = 0;
    return position_;
  }

  int32_t position_ = 0;
  uint16_t counts_ = 0;
  uint16_t last_ = 0;  // the reading that belongs to position_
  int16_t slack_ = 0;
  int16_t step_ = 0;  // of the last motion that was believed
  uint16_t suspect_ = 0;
  int16_t suspect_jump_ = 0;
  int16_t suspect_ahead_ = 0;  // where the suspect lies, seen from the bridge
  uint8_t bridged_ = 0;
  bool started_ = false;
};
