// One step of a moving mass: hapkit_studio.dynamics.integrators.step in single precision, written for the
// board. Translated from there it would fill half of the chip and take several periods; the differential tests
// hold every method to the original. What depends on parameters alone is reckoned when one of them changes.
#pragma once

#include "exact_motion.h"

namespace laws {
namespace numbers {
namespace mass {

static uint8_t which;
static Real half;
static Real thrust;                 // Verlet's, and its denominators' inverses without and with the damper
static Real loose, braced, dragged;
static Real pull;                   // of spring and wall where the mass is,
static bool known;                  // if a step left it there

FAST_ONCE void prepare() {
  static Inverse mass, slow, slower;
  anew = false;
  which = static_cast<uint8_t>(with_method.n);
  known = beyond = false;
  walled = fast::above_zero(with_wall);
  damped = fast::above_zero(with_pad);
  rubbed = fast::above_zero(with_friction);
  inverse = mass.of(with_m.n);
  half = fast::scaled<-1>(with_h);
  thrust = half * inverse;
  drop = with_friction * inverse;
  const float slowed = with_b * thrust + 1.0f;
  rough = slowed > 1.004f;
  if (which == 3) {
    loose = slow.of(slowed);
    dragged = with_pad * thrust;
    if (damped) braced = slower.of(dragged + slowed);
  }
  for (Map& map : maps) map.piece = 0;
  missing = 4;
}

// Return Verlet's new velocity at a place. With the damper it is on the same side of the handle's as without.
inline float braked(float base, float q) {
  look(q);
  pull = pulled(q);
  known = !rubbed;
  touching = fast::above_zero(depth(q));
  float sum = pull;
  if (touching) sum -= (q - with_touch) * with_contact;
  sum = sum * thrust + base;
  if (damped && touching) {
    const float u = (with_speed * dragged + sum) * braced;
    if (fast::above_zero(approach(u))) return u;
  }
  return sum * loose;
}

// Return the position, and the velocity through a pointer, by the classical method.
FAST_ONCE float runge_kutta(float a, float* to) {
  float u = with_v, way = u, change = a;
  for (uint8_t n = 0; n < 3; n++) {
    const float t = n < 2 ? half : with_h;
    const float q = u * t + with_x;
    u = a * t + with_v;
    meet(q, u);
    if (walled) look(q);
    a = acceleration(u, pulled(q));
    way += n < 2 ? u + u : u;
    change += n < 2 ? a + a : a;
  }
  const float sixth = 0.16666667f * with_h;
  *to = sixth * change + with_v;
  return sixth * way + with_x;
}

// Return the velocity u = base + t x''(q + t u, u): solved for what acts at first, then for what acts there.
// Where that is never the same, the damper sets in with a jump, and the mass ends at the surface.
FAST_ONCE float settled(float base, float q, float t) {
  float u = base;
  for (uint8_t n = 0, before = 0; n < 7; n++) {
    end = t * u + q;
    look(end);
    meet(end, u);
    if (mark() == before) return u;
    before = mark();
    shape();
    float sum = loaded(q);
    if (closing) sum = with_pad * with_speed + sum;
    u = (sum * inverse * t + base) / ((t * stiffness + damping) * t + 1.0f);
  }
  return -(q - with_touch) / t;
}

// Take over where the mass is: friction takes of its velocity, and the place follows what is left of it.
FAST_ONCE void rub(float own, float u, float follows) {
  const float most = drop * with_h;
  u = fast::larger(u, most) ? u - like(most, u) : 0.0f;
  with_x = follows * u + own;
  with_v = u;
}

// Forces at the middle of the period, and at its end.
FAST_ONCE void verlet(float now) {
  const float u = now * half + with_v.n;
  float own = u * with_h + with_x.n;
  const float after = braked(u, own);
  if (rubbed) return rub(own - after * half, after, half);
  with_x = own;
  with_v = after;
}

// Every other method but exact: own + follows u, u the new velocity.
FAST_ONCE void simple(float now) {
  const float v = with_v.n;
  float own = with_x.n, u = v, follows = half;
  if (which == 0) {
    own = v * with_h + own;
    u = now * with_h + u;
    follows = 0.0f;
  } else if (which == 1) {
    own = v * half + own;
    u = (now + with_before) * half + u;
  } else if (which == 2) {
    follows = with_h;
    u = now * follows + u;
  } else if (which == 4) {
    own = runge_kutta(now, &u);
    if (rubbed) own -= u * half;
    else follows = 0.0f;
  } else if (which == 5) {
    follows = with_h;
    u = settled(u, own, follows);
  } else {
    own = v * half + own;
    u = settled(now * half + u, own, half);
  }
  if (rubbed) return rub(own, u, follows);
  with_x = follows * u + own;
  with_v = u;
}

}  // namespace mass

// Return position, velocity, and the acceleration before them.
FAST_ONCE const Moved& step() {
  using namespace mass;
  if (anew || !fast::is(with_x.n, at_x.n) || !fast::is(with_v.n, at_v.n)) {
    known = false;
    reaction();
  }
  if (anew) prepare();
  if (!known) {
    look(with_x);
    pull = pulled(with_x);
  }
  known = false;
  const float now = acceleration(with_v.n, pull.n);
  moved.c.n = now;
  if (which == 7) exact(now);
  else if (which == 3) verlet(now);
  else simple(now);
  return moved;
}

}  // namespace numbers
}  // namespace laws
