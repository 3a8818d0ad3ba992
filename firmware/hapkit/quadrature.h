// Counts the steps of two channels in quadrature.
#pragma once

#include <stdint.h>

// edge() runs in an interrupt. The other functions must be called within an interrupt or with interrupts off.
class Quadrature {
 public:
  // Channels A and B are neighbouring bits on pins 2 and 3 of a port; channel A is the lower one.
  void start(uint8_t pins) {
    place_ = place(pins);
    forward_ = true;
    slip_ = false;
  }

  // Process the pins after an edge. If both channels have changed, one edge was missed, and the last
  // direction is assumed.
  void edge(uint8_t pins) {
    const uint8_t next = place(pins);
    const uint8_t turned = (next - place_) & 3;
    place_ = next;
    if (turned == 1) {
      forward_ = true;
      steps_ = steps_ + 1;
    } else if (turned == 3) {
      forward_ = false;
      steps_ = steps_ - 1;
    } else if (turned == 2) {
      slip_ = true;
      steps_ = steps_ + (forward_ ? 2 : -2);
    }
  }

  uint16_t steps() const { return steps_; }

  // Return true if both channels changed at once since the last call.
  bool take_slip() {
    const bool taken = slip_;
    slip_ = false;
    return taken;
  }

 private:
  // The states 00, 01, 11, 10 of channels BA are the steps 0, 1, 2, 3 of a period.
  static uint8_t place(uint8_t pins) {
    const uint8_t both = (pins >> 2) & 3;
    return both ^ (both >> 1);
  }

  volatile uint16_t steps_ = 0;  // this must be the first member, because the timer's interrupt reads it
  volatile uint8_t place_ = 0;
  volatile bool forward_ = true;
  volatile bool slip_ = false;
};
