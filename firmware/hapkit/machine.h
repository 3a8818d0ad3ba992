// Runs a received law: float32 slots, and code with one accumulator. Code that passed verify() cannot hang,
// write elsewhere, or exceed its number of cycles. hapkit_studio/laws/machine.py lists the operations.
#pragma once

#include "opcodes.h"

namespace machine {

// The sizes of a law. Its slots are position, velocity, states, constants and temporaries; the states and
// constants have initial values (they are "given").
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

// The memory contains slots, code, then constants that are being ramped.
extern uint8_t arena[kArena];

// The location of the verified code, the offset of its MAIN, and whether it reads the velocity.
struct Program {
  const uint8_t* code;
  const uint8_t* main;
  bool reads_velocity;
};
extern Program program;

inline float* slots() { return reinterpret_cast<float*>(arena); }
inline uint8_t* code(const Shape& shape) { return arena + sizeof(float) * shape.slots; }

// Return true if a law fits into the memory; this is known before the law is received.
bool fits(const Shape& shape);

// Verify the code and the given numbers in the arena. If the result is kNone, cycles is the worst case of a
// call, and run() may be called.
Refusal verify(const Shape& shape, uint32_t* cycles);

// Call the law once and return its force, or NaN after a fault. On the chip this is in machine_avr.S.
float run(float x, float v);

}  // namespace machine
