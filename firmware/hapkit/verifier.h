// One pass over the code of a law, forward, as all its jumps are: what it may touch, where it may go, what it costs.
#pragma once

#include "machine.h"

namespace machine {

class Verifier {
 public:
  explicit Verifier(const Shape& shape) : shape_(shape), code_(code(shape)) {}

  Refusal check();

  // After kNone: where MAIN stands, and what the law takes at most.
  uint16_t entry() const { return section_; }
  uint16_t cycles() const { return worst_; }

 private:
  // A jump that is under way, or a return out of a loop.
  struct Way {
    uint16_t target;
    uint16_t cost;
    uint8_t depth;  // loops around it, up to those that it has left
  };
  // A loop that is open: costs inside it count from 0.
  struct Loop {
    uint16_t body;
    uint16_t times;
    uint16_t before;
    uint8_t counter;
  };
  struct Subroutine {
    uint16_t at;
    uint16_t cost;
    uint8_t counters;  // those below this number may be in use
    uint8_t calls;     // depth
  };

  Refusal step();
  Refusal begin_section();
  Refusal end_section();
  Refusal call(uint16_t at);
  Refusal open_loop(uint8_t counter, uint16_t times);
  Refusal close_loop(uint8_t counter, uint16_t back);
  Refusal arrive();
  Refusal jump(uint16_t distance);
  Refusal leave(uint16_t target);
  Refusal range(uint8_t first, uint8_t count, bool written) const;
  bool is_slot(uint8_t slot) const { return slot < shape_.slots; }
  void spend(uint16_t cycles);

  const Shape& shape_;
  const uint8_t* code_;
  uint16_t at_ = 0;
  uint16_t next_ = 0;
  uint16_t section_ = 0;
  uint16_t cost_ = 0;
  uint16_t worst_ = 0;
  bool inside_ = false;  // of a section
  bool alive_ = false;   // something leads here
  uint8_t counters_ = 0;
  uint8_t calls_ = 0;
  uint8_t ways_ = 0;
  uint8_t depth_ = 0;
  uint8_t subroutines_ = 0;
  Way way_[kMostJumps];
  Loop loop_[kMostCounters];
  Subroutine subroutine_[kMostSubroutines];
};

}  // namespace machine
