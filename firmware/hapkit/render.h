// The board's law: the tick runs it in the machine, the main program ramps its constants, and its force fades
// in and out.
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

  // Start to fade the force out, or in again.
  void leave() { leaving_ = true; }
  void stay() { leaving_ = false; }
  bool leaving() const { return leaving_; }
  bool out() const {
    const Lock lock;
    return leaving_ && gone_ == 0;
  }

  // Return true if the force has its full weight.
  bool whole() const { return gone_ >= kWhole && !leaving_; }

  // Return the weighted force, and advance the fade by a period in ticks.
  float weighted(float force, uint16_t ticks);

 private:
  static constexpr uint16_t kWhole = 30 * board::kTicksPerMs;

  volatile uint16_t gone_ = 0;
  volatile bool leaving_ = false;
};

class Renderer {
 public:
  // These functions belong to the main program.

  // Start the law that is in the machine's memory.
  void start(const machine::Shape& shape, uint8_t generation);

  // Let the computer render again.
  void leave() {
    active_ = false;
    count_ = 0;
  }

  // Start ramps of constants of the present law to new values. Ignore a message for a different law, and one
  // that needs more ramps than are free. Return false for a message that is invalid for every law.
  bool tune(const protocol::Tune& tune);

  // Advance the ramps of the constants by a millisecond.
  void move() {
    if (count_) move_on();
  }

  bool active() const { return active_; }

  // These functions belong to the tick, which the main program never interrupts.

  // Return the generation of the present law, or of its last change.
  uint8_t generation() const { return generation_; }

  // Write one state variable and its index; all state variables are sent in turn.
  void show_state(protocol::Telemetry* shown);

 private:
  // The ramp of a constant, stored after the code.
  struct __attribute__((packed, may_alias)) Moving {
    uint8_t slot;
    uint8_t left;  // ms until the target
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
  uint8_t law_ = 0;  // generation of the law
  uint8_t generation_ = 0;
  uint8_t turn_ = 0;  // index of the state variable that is sent next
  uint8_t count_ = 0;  // number of active ramps
};

}  // namespace render
