// Runs a received law: float32 slots and code with one accumulator. Code that passed verify() cannot
// hang, write elsewhere, or exceed its number of cycles. hapkit_studio/laws/machine.py lists the operations.
#pragma once

#include "opcodes.h"

namespace machine {

// Sizes of a law. Its slots are position, velocity, states, constants (states and constants are given), temporaries.
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

// Location of the verified code, offset of its MAIN, and whether it reads the velocity.
struct Program {
  const uint8_t* code;
  const uint8_t* main;
  bool reads_velocity;
};
extern Program program;

inline float* slots() { return reinterpret_cast<float*>(arena); }
inline uint8_t* code(const Shape& shape) { return arena + sizeof(float) * shape.slots; }

// True if a law fits, before it is received.
bool fits(const Shape& shape);

// Verify code and given numbers in the arena; on kNone, cycles is the worst case of a call and
// run() may be called.
Refusal verify(const Shape& shape, uint32_t* cycles);

// One call of the law: its force, NaN on a fault. On the chip in machine_avr.S.
float run(float x, float v);

}  // namespace machine
