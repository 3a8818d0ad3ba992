// Runs a law that was sent: float32 slots and code that works on one accumulator. What verify() has passed cannot
// hang, write elsewhere, or take longer than it says. hapkit_studio/laws/machine.py has the operations.
#pragma once

#include "opcodes.h"

namespace machine {

// Of one law. Its slots are position, velocity, states, constants (states and constants are given), temporaries.
struct Shape {
  uint8_t states;
  uint8_t given;
  uint8_t slots;
  uint16_t code;  // bytes
};

#ifdef HAPKIT_ARENA  // for tests of larger laws
constexpr uint16_t kArena = HAPKIT_ARENA;
#else
constexpr uint16_t kArena = kUsualArena;
#endif
constexpr uint8_t kVelocity = 1;
constexpr uint8_t kFirstGiven = 2;

// Slots, code, then moving constants.
extern uint8_t arena[kArena];

// Where the code of the law lies that verify() has passed, where in it MAIN, and whether the velocity matters to it.
struct Program {
  const uint8_t* code;
  const uint8_t* main;
  bool reads_velocity;
};
extern Program program;

inline float* slots() { return reinterpret_cast<float*>(arena); }
inline uint8_t* code(const Shape& shape) { return arena + sizeof(float) * shape.slots; }

// Whether a law has room, before anything of it has come.
bool fits(const Shape& shape);

// Check the code and the given numbers that lie in the arena; if kNone, one call takes so many cycles at most and
// run() may be called.
Refusal verify(const Shape& shape, uint32_t* cycles);

// One call of the law: its force, nan where it failed. On the chip machine_avr.S has it.
float run(float x, float v);

}  // namespace machine
