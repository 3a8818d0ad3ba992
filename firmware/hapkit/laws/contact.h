// What acts on a moving mass: hapkit_studio.dynamics.moving_mass in single precision, written for the board.
// The push that the handle got back is the one that moves the mass in the next period: it is reckoned once.
#pragma once

#include "law.h"

namespace laws {
namespace numbers {

// A number at a place of its own: to reckon with it takes half of the instructions so.
struct Real {
  float n;

  FAST_APART operator float() const { return n; }
  FAST_APART void operator=(float value) { n = value; }
};

// One that is set in every period: where it stands is known.
struct Moving : Real {
  void operator=(float value) { n = value; }
};

// And one that is given back.
struct Given : Moving {
  operator float() const { return n; }
};

// One that seldom changes, and says when it does.
static bool anew = false;
struct Kept : Real {
  FAST_APART void operator=(float value) {
    if (fast::is(n, value)) return;
    n = value;
    anew = true;
  }
};

#ifdef __AVR__
// Load the number, and go on to the operation: its return is ours.
#define LAWS_WITH_REAL(word, function)                                                          \
  __attribute__((noinline, naked)) static float operator word(float, const Real&) {             \
    asm volatile(                                                                               \
        "movw r30, r20\n\t ld r18, Z\n\t ldd r19, Z+1\n\t ldd r20, Z+2\n\t ldd r21, Z+3\n\t"    \
        "jmp " function ::                                                                      \
            : "r0", "r18", "r19", "r20", "r21", "r22", "r23", "r24", "r25", "r26", "r27", "r30", \
              "r31", "memory");                                                                 \
  }
LAWS_WITH_REAL(+, "__addsf3")
LAWS_WITH_REAL(-, "__subsf3")
LAWS_WITH_REAL(*, "__mulsf3")
#undef LAWS_WITH_REAL
#else
inline float operator+(float a, const Real& b) { return a + b.n; }
inline float operator-(float a, const Real& b) { return a - b.n; }
inline float operator*(float a, const Real& b) { return a * b.n; }
#endif

// The arguments, as the callers set them: what moves, and what seldom changes.
struct Moved {
  Given a, b;  // place and velocity
  Given c;     // the acceleration before them
};
static Moved moved;
static Moving &with_x = moved.a, &with_v = moved.b;
static Moving with_touch, with_speed;
static Real with_before;
static Kept with_h, with_m, with_b, with_k, with_f, with_contact, with_pad, with_friction;
static Kept with_reach, with_wall, with_method;

static bool right;  // the handle is on the mass's right
struct Side {
  void operator=(float value) const { right = fast::below_zero(value); }
};
static const Side with_side = {};

namespace mass {

static bool touching, closing, beyond;  // at the last place that was looked at
static bool walled;                     // there is a wall
static Real pushing;                     // the push
static Moving at_x, at_v;                // where it was reckoned
static Real inverse, end;

// As it is seen from the handle.
FAST_ONCE float facing(float x) { return right ? -x : x; }
FAST_ONCE float depth(float q) { return facing(-(q - with_touch)); }
FAST_ONCE float approach(float u) { return facing(-(u - with_speed)); }
FAST_ONCE float like(float x, float other) { return fast::signed_as(x, other); }

// Reckon the push of the handle on a mass there; find out whether they touch and the damper acts.
FAST_ONCE void meet(float q, float u) {
  float push = depth(q);
  closing = false;
  touching = fast::above_zero(push);
  if (touching) {
    push = push * with_contact;
    if (!fast::is_zero(with_pad.n)) {
      const float near = approach(u);
      closing = fast::above_zero(near);
      if (closing) push = near * with_pad + push;
    }
  } else {
    push = 0.0f;
  }
  pushing = push;
}

FAST_ONCE void look(float q) {
  if (!walled) return;
  end = q;
  beyond = fast::larger(q, with_reach.n);
}

// Return what spring and wall do there, if it acts; and the contact's spring.
FAST_ONCE float stretched(float q) { return -(q * with_k - with_f); }
FAST_ONCE float stopped(float q) { return stretched(q) - (q - like(with_reach, end)) * with_wall; }
inline float pulled(float q) { return beyond ? stopped(q) : stretched(q); }
FAST_ONCE float loaded(float q) {
  const float sum = pulled(q);
  return touching ? sum - (q - with_touch) * with_contact : sum;
}

// Return the acceleration there, the spring's and the wall's pull given, with the push.
FAST_ONCE float acceleration(float u, float pull) { return (pull - u * with_b + facing(pushing.n)) * inverse; }

}  // namespace mass

// Return the push between handle and mass.
FAST_ONCE float reaction() {
  const float x = with_x.n, v = with_v.n;
  mass::at_x = x;
  mass::at_v = v;
  mass::meet(x, v);
  return mass::pushing.n;
}

}  // namespace numbers
}  // namespace laws
