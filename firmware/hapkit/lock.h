// Hold interrupts off for the life of a Lock; keep that life far below 250 cycles, two bytes on the wire.
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

// What is written before is in memory before what is written after.
inline void fence() { __asm__ volatile("" ::: "memory"); }
