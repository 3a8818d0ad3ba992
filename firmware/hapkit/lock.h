// Disables interrupts during the life of a Lock. This must be far shorter than 250 cycles, in which two bytes
// arrive on the wire.
#pragma once

#ifdef __AVR__

#include <avr/interrupt.h>
#include <avr/io.h>

class Lock {
 public:
  __attribute__((always_inline)) Lock() : status_(SREG) {
    cli();
    __asm__ volatile("" ::: "memory");
  }
  __attribute__((always_inline)) ~Lock() {
    __asm__ volatile("" ::: "memory");
    SREG = status_;
  }
  Lock(const Lock&) = delete;

 private:
  const uint8_t status_;
};

#else

class Lock {
 public:
  Lock() {}
  ~Lock() {}
  Lock(const Lock&) = delete;
};

#endif

// A compiler barrier: writes before the fence are not moved after it.
inline void fence() { __asm__ volatile("" ::: "memory"); }
