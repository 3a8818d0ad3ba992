// One step of a moving mass, written for the board: hapkit_studio.dynamics.integrators.step in single precision.
// Translated from there it would fill half of the chip, and the exact motion would take many periods. The
// differential tests hold every method to the original.
// The mass is mirrored where the handle is on its right: here it always comes from the left.
#pragma once

#include "law.h"

namespace laws {
namespace numbers {
namespace {

class Mass {
 public:
  // The arguments of step(), as its caller sets them; what is used most comes first, where one instruction
  // reaches it.
  float x, v, touch, speed, friction, pad, h, reach;

 private:
  float inverse_, damping_, stiffness_, force_, span_;
  uint8_t order_;
  bool touching_, closing_, damped_;
  int8_t beyond_;
  float share_, end_, rate_;
  enum : uint8_t { kPieces = 24, kOrders = 9 };
  float term_[kOrders + 1];

 public:
  float method, before, m, b, k, f, side, contact, wall;

  // Return position, velocity, and the acceleration before them.
  FAST_APART Results<float, float, float> step() {
    static Inverse mass = LAWS_NO_INVERSE;
    inverse_ = mass.of(m);
    if (side < 0.0f) mirror();
    const float now = acceleration(x, v);
    if (fast::is(method, 7.0f)) exact();
    else simple(now);
    const Results<float, float, float> found = {x, v, now};
    if (side < 0.0f) return Results<float, float, float>{-found.a, -found.b, -found.c};
    return found;
  }

 private:
  FAST_APART void mirror() {
    x = -x, v = -v, before = -before;
    f = -f, touch = -touch, speed = -speed;
  }

  // Find out what acts at a place: the handle, its damper, a wall.
  FAST_APART void place(float q, float u) {
    touching_ = q < touch;
    closing_ = touching_ && u < speed;
    beyond_ = q > reach ? 1 : q < -reach ? -1 : 0;
  }

  // Reckon what acts there: force_ - damping_ v - stiffness_ x.
  FAST_APART void piece() {
    damping_ = b, stiffness_ = k, force_ = f;
    if (touching_) add(contact, contact * touch);
    if (closing_) damping_ += pad, force_ += pad * speed;
    if (beyond_) add(wall, fast::flipped_by(wall * reach, beyond_));
  }

  FAST_APART void add(float stiffness, float force) {
    stiffness_ += stiffness, force_ += force;
  }

  FAST_APART float pull(float q, float u) const { return force_ - damping_ * u - stiffness_ * q; }

  FAST_APART float acceleration(float q, float u) {
    place(q, u);
    piece();
    return pull(q, u) * inverse_;
  }

  // Every method but exact: x + (h - follows) v + follows u, u the new velocity; two reckon x by themselves.
  FAST_APART void simple(float now) {
    const uint8_t which = static_cast<uint8_t>(method);
    const float half = fast::scaled<-1>(h);
    float follows = which == 0 ? 0.0f : (which == 2 || which == 5) ? h : half;
    float u = v + (which == 0 || which == 2 ? h : half) * now;
    float own = x + (h - follows) * v;
    switch (which) {
      case 1: u += half * before; break;
      case 3:
        own = x + h * u;
        u = settled(u, own, half, 0.0f);
        own -= half * u;
        break;
      case 4: own = runge_kutta(now, &u) - half * u; break;
      case 5:
      case 6: u = settled(which == 5 ? v : u, own, follows, follows); break;
    }
    if (friction > 0.0f) u = stopped(u, friction * h * inverse_);
    x = own + follows * u;
    v = u;
  }

  static float stopped(float u, float most) {
    return fast::magnitude(u) <= most ? 0.0f : u - fast::signed_as(most, u);
  }

  // Return the position, and the velocity through a pointer, by the classical method.
  FAST_APART float runge_kutta(float a, float* to) {
    float u = v, way = v, change = a;
    for (uint8_t n = 0; n < 3; n++) {
      const float t = n < 2 ? fast::scaled<-1>(h) : h;
      const float q = x + t * u;
      u = v + t * a;
      a = acceleration(q, u);
      way += n < 2 ? fast::scaled<1>(u) : u;
      change += n < 2 ? fast::scaled<1>(a) : a;
    }
    const float sixth = h * 0.16666667f;
    *to = v + sixth * change;
    return x + sixth * way;
  }

  // Return the velocity u = base + t x''(q + w u, u): solved for what acts at first, then for what acts there.
  // Where that is never the same, the damper sets in with a jump, and the mass ends at the surface.
  FAST_APART float settled(float base, float q, float t, float w) {
    float u = base;
    place(q + w * u, u);
    for (uint8_t n = 0; n < 6; n++) {
      const uint8_t acting = mark();
      piece();
      const float once = t * inverse_;
      u = (base + once * (force_ - stiffness_ * q)) / (1.0f + once * (damping_ + w * stiffness_));
      place(q + w * u, u);
      if (mark() == acting) return u;
    }
    return w > 0.0f ? (touch - q) / w : u;
  }

  uint8_t mark() const { return touching_ | closing_ << 1 | (beyond_ + 1) << 2; }

  // Move on to the end of the period, from event to event; a mass that meets too much waits.
  FAST_APART void exact() {
    place(x, v);
    float left = h;
    for (uint8_t n = 0; n < kPieces && left > 0.0f; n++) {
      if (!begin(left)) return static_cast<void>(v = 0.0f);
      left -= advance();
    }
  }

  // Begin a piece: the power series of the motion over what is left of the period; false if nothing moves.
  FAST_APART bool begin(float left) {
    closing_ = false;
    piece();
    float acting = pull(x, v);
    damped_ = touching_ && pad > 0.0f;
    const bool still = v == 0.0f && fast::magnitude(acting) <= friction;
    const float dry = fast::signed_as(friction, v == 0.0f ? acting : v);
    // at equal speed by what pulls
    if (damped_ && (v < speed || (v == speed && !still && acting < dry))) {
      closing_ = true;
      damping_ += pad;
      acting += pad * (speed - v);
    }
    if (v == 0.0f && fast::magnitude(acting) <= friction) return false;
    acting -= dry;
    const float damped = damping_ * inverse_, sprung = stiffness_ * inverse_;
    span_ = left;
    float once, twice;
    for (;;) {  // a series of few terms
      once = damped * span_;
      twice = sprung * span_ * span_;
      if (!(once + twice > 0.5f)) break;
      span_ = fast::scaled<-1>(span_);
    }
    term_[0] = x;
    term_[1] = v * span_;
    term_[2] = fast::scaled<-1>(acting * inverse_ * span_ * span_);
    order_ = 2;
    end_ = x + term_[1] + term_[2];
    rate_ = term_[1] + fast::scaled<1>(term_[2]);
    // the n-th derivative * span^n / n!, until two in a row move the mass by less than a nanometre
    float n = 3.0f;
    while (order_ < kOrders) {
      const float one = term_[order_];
      const float next = -(once * one + twice * term_[order_ - 1] * part(order_)) * part(order_ + 1);
      term_[++order_] = next;
      end_ += next;
      rate_ += n * next;
      n += 1.0f;
      if (fast::magnitude(next) < 1e-9f && fast::magnitude(one) < 4e-9f) break;
    }
    return true;
  }

  // 1 / n for n from 2 on: dividing takes three times as long.
  static float part(uint8_t n) {
    static const float kParts[] PROGMEM = {0.5f,        0.33333333f, 0.25f,       0.2f, 0.16666667f,
                                           0.14285714f, 0.125f,      0.11111111f, 0.1f};
#ifdef __AVR__
    return pgm_read_float(kParts + n - 2);
#else
    return kParts[n - 2];
#endif
  }

  // Return position (0), velocity * span (1) or acceleration * span^2 (2) at a share of the span.
  FAST_APART float at(uint8_t derivative, float share) const {
    float sum = 0.0f;
    for (int8_t n = order_; n >= static_cast<int8_t>(derivative); n--) {
      sum *= share;
      const uint8_t factor = derivative == 2 ? n * (n - 1) : n;
      sum += derivative ? factor * term_[n] : term_[n];
    }
    return sum;
  }

  // Shorten the piece to where the derivative crosses a level, which it does once.
  FAST_APART void until(uint8_t derivative, float level) {
    const float start = term_[derivative] - level;
    float low = 0.0f, high = share_, t = share_;
    for (uint8_t n = 0; n < 12; n++) {
      const float value = at(derivative, t) - level;
      if ((value < 0.0f) == (start < 0.0f)) low = t;
      else high = t;
      float guess = t - value / at(derivative + 1, t);
      if (!(low <= guess && guess <= high)) guess = fast::scaled<-1>(low + high);
      const float change = fast::magnitude(guess - t);
      t = guess;
      if (change < 3e-7f) break;
    }
    share_ = t;
  }

  // Move to the end of the piece, or to the first event before; return the time that took.
  FAST_APART float advance() {
    share_ = 1.0f;
    float q = end_, u = rate_;
    const float start = term_[1], same = speed * span_;
    const bool touched = touching_;
    const int8_t behind = beyond_;
    // The velocity's zero parts a piece: it may touch something and leave it again, and friction turns round.
    if (start * u < 0.0f) {
      until(1, 0.0f);
      q = at(0, share_), u = 0.0f;
    }
    if (damped_ && (start - same) * (u - same) < 0.0f) {
      until(1, same);
      q = at(0, share_), u = same;
    }
    if (touched ? q > touch : q < touch) {
      touching_ = !touched;
      until(0, touch);
      q = touch;
    }
    const float wall_at = behind ? fast::flipped_by(reach, behind) : fast::signed_as(reach, q);
    if (behind ? fast::flipped_by(q, behind) < reach : fast::magnitude(q) > reach) {
      touching_ = touched;
      beyond_ = behind ? 0 : q > 0.0f ? 1 : -1;
      until(0, wall_at);
      q = wall_at;
    }
    if (touching_ != touched || beyond_ != behind) u = at(1, share_);
    x = q;
    v = u == same ? speed : u / span_;
    return share_ * span_;
  }
};

Mass mass;

}  // namespace

// The address is hidden from the compiler: a store beside it takes half of what one to a known place does.
inline Mass* given() {
  Mass* to = &mass;
#ifdef __AVR__
  asm("" : "+b"(to));
#endif
  return to;
}

template <float Mass::*place>
struct With {
  void operator=(float value) const { given()->*place = value; }
};

#define LAWS_WITH(name) static const With<&Mass::name> with_##name = {}
LAWS_WITH(method); LAWS_WITH(x); LAWS_WITH(v); LAWS_WITH(before);
LAWS_WITH(h); LAWS_WITH(friction); LAWS_WITH(m); LAWS_WITH(b);
LAWS_WITH(k); LAWS_WITH(f); LAWS_WITH(touch); LAWS_WITH(side);
LAWS_WITH(speed); LAWS_WITH(contact); LAWS_WITH(pad); LAWS_WITH(reach);
LAWS_WITH(wall);
#undef LAWS_WITH

inline Results<float, float, float> step() { return mass.step(); }

}  // namespace numbers
}  // namespace laws
