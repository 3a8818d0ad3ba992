// The board's own law: run by the tick in the machine, its constants ramped by the main program, its force faded.
#pragma once

#include <stdint.h>

#include "board.h"
#include "lock.h"
#include "machine.h"
#include "protocol.h"

namespace render {

// A force that fades in or out over 30 ms.
class Fade {
 public:
  void restart() { gone_ = 0; }

  // Fade out, or in again.
  void leave() { leaving_ = true; }
  void stay() { leaving_ = false; }
  bool leaving() const { return leaving_; }
  bool out() const {
    const Lock lock;
    return leaving_ && gone_ == 0;
  }

  // True if the force is at full weight.
  bool whole() const { return gone_ >= kWhole && !leaving_; }

  // Return the force, weighted, one period later.
  float weighted(float force, uint16_t ticks);

 private:
  static constexpr uint16_t kWhole = 30 * board::kTicksPerMs;

  volatile uint16_t gone_ = 0;
  volatile bool leaving_ = false;
};

class Renderer {
 public:
  // Main program.

  // Start the law in the machine's memory.
  void start(const machine::Shape& shape, uint8_t generation);

  // Return the rendering to the computer.
  void leave() {
    active_ = false;
    count_ = 0;
  }

  // Let constants of the law in force begin to move to new values. A message for another law, or one for whose
  // constants there is no room, is passed over; return false for one that no law can follow.
  bool tune(const protocol::Tune& tune);

  // Let the constants move on by a millisecond.
  void move() {
    if (count_) move_on();
  }

  bool active() const { return active_; }

  // The tick, which the main program never interrupts.

  // The number of the law in force or of its last change.
  uint8_t generation() const { return generation_; }

  // Fill one value of the law's state and its place; they take turns.
  void show_state(protocol::Telemetry* shown);

 private:
  // A constant that moves, behind the code.
  struct __attribute__((packed, may_alias)) Moving {
    uint8_t slot;
    uint8_t left;  // ms until it is at its target
    float target;
  };
  static_assert(sizeof(Moving) == machine::kRamp, "the machine keeps room for some of these");

  Moving* moving() const { return reinterpret_cast<Moving*>(machine::code(shape_) + shape_.code); }
  void move_on();
  uint8_t room() const;
  Moving* find(uint8_t slot) const;
  bool fits(const protocol::Tune& tune) const;

  volatile bool active_ = false;
  machine::Shape shape_ = {};
  uint8_t law_ = 0;  // its generation
  uint8_t generation_ = 0;
  uint8_t turn_ = 0;  // which state is shown next
  uint8_t count_ = 0;  // of the constants that move
};

}  // namespace render
