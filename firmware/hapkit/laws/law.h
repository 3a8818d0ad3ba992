// What every translated law uses: several values at once, faults, inverses that are kept.
// For one translation unit; a law runs to its end before another begins.
#pragma once

#include <math.h>
#include <stdint.h>

#include "../fast.h"

namespace laws {

// What a function gives back that returns several numbers.
template <class... Kinds>
struct Results;
template <class A, class B>
struct Results<A, B> {
  A a;
  B b;
};
template <class A, class B, class C>
struct Results<A, B, C> {
  A a;
  B b;
  C c;
};
template <class A, class B, class C, class D>
struct Results<A, B, C, D> {
  A a;
  B b;
  C c;
  D d;
};
template <class A, class B, class C, class D, class E>
struct Results<A, B, C, D, E> {
  A a;
  B b;
  C c;
  D d;
  E e;
};
template <class A, class B, class C, class D, class E, class F>
struct Results<A, B, C, D, E, F> {
  A a;
  B b;
  C c;
  D d;
  E e;
  F f;
};
template <class A, class B, class C, class D, class E, class F, class G>
struct Results<A, B, C, D, E, F, G> {
  A a;
  B b;
  C c;
  D d;
  E e;
  F f;
  G g;
};
template <class A, class B, class C, class D, class E, class F, class G, class H>
struct Results<A, B, C, D, E, F, G, H> {
  A a;
  B b;
  C c;
  D d;
  E e;
  F f;
  G g;
  H h;
};

// Whether the law divided by zero, indexed outside its state or turned too often since begin().
static bool fault = false;
static uint16_t turns_left = 0;

// Whether the law has taken its parameters over: whoever changes one, or the law, says that it has not.
static volatile bool current = false;

FAST_ONCE void clear(float* s, uint8_t size) {
  while (size) s[--size] = 0.0f;
}

inline void begin() { fault = false; }

inline void begin(uint16_t turns) {
  fault = false;
  turns_left = turns;
}

// Take one turn of a loop; true if there was none left, or the law has a fault anyway.
inline bool spent() {
  if (turns_left == 0) fault = true;
  else turns_left--;
  return fault;
}

// A law with a fault has no force: the board refuses what is not a number.
inline float checked(float force) { return fault ? NAN : force; }

FAST_ONCE float divisor(float b) {
  if (fast::is_zero(b)) fault = true;
  return b;
}

FAST_ONCE uint8_t index(float i, uint8_t size) {
  if (i >= 0.0f && i < size) return static_cast<uint8_t>(i);
  fault = true;
  return 0;
}

// The number of a choice; what is none of its options is none of them here too.
FAST_ONCE int8_t option(float choice) {
  return choice >= 0.0f && choice < 100.0f ? static_cast<int8_t>(choice) : -1;
}

struct Inverse;
extern "C" float laws_inverse(Inverse* self, float b);  // compare_avr.S

// The inverse of what seldom changes: comparing is far cheaper than dividing.
struct Inverse {
  uint32_t key;  // the number's bits turned round, so that what starts as 0 is no finite number
  float value;

#ifdef __AVR__
  float of(float b) { return laws_inverse(this, b); }
#else
  float of(float b) {
    const uint32_t bits = ~fast::bits(b);
    if (bits != key) {
      key = bits;
      value = 1.0f / b;
    }
    return value;
  }
#endif

  FAST_APART float watched(float b) {
    if (fast::is_zero(b)) fault = true;
    return of(b);
  }
};

}  // namespace laws

#define LAWS_NO_INVERSE {0, 0.0f}

// The longest of the laws without state, which run oftenest: they push and pop their registers themselves, 20 cycles
// and more sooner than by the functions that all others share. Those take registers in a row; r2 alone breaks it.
#ifdef __AVR__
#define LAWS_OWN_ENDS asm volatile("" : : : "r2")
#else
#define LAWS_OWN_ENDS
#endif
