// The exact motion of a mass, written for the board: hapkit_studio.dynamics.events in single precision.
// That module sums matrix exponentials and searches with them, which takes the board many periods. Here each
// linear piece is its power series over the time that is left, cut where it moves the mass by less than
// a nanometre, and an event is a root of that polynomial.
#pragma once

#include "law.h"

namespace laws {
namespace numbers {

// Set by step(), as for every function of a moving mass.
static float with_m, with_b, with_k, with_f, with_touch, with_side, with_speed, with_contact, with_pad,
    with_reach, with_wall, with_friction, with_h;

namespace {

class Motion {
 public:
  Motion(float x, float v) : x_(x), v_(v) {
    touching_ = toward_touch(x) > 0.0f;
    beyond_ = x > with_reach ? 1 : x < -with_reach ? -1 : 0;
  }

  // Move on to the end of the period; a mass that meets too much waits.
  Results<float, float> run() {
    left_ = with_h;
    for (uint8_t n = 0; n < kPieces && left_ > 0.0f; n++) {
      if (!piece()) return Results<float, float>{x_, 0.0f};
    }
    return Results<float, float>{x_, v_};
  }

 private:
  enum Event : uint8_t { kNone, kMeet, kWall };
  static constexpr uint8_t kPieces = 24, kOrders = 9;

  static float toward_touch(float x) { return fast::flipped(with_touch - x, with_side); }

  // Whether handle and object approach each other; at equal speed by what pulls.
  bool approaching(float pull) const {
    float rate = fast::flipped(with_speed - v_, with_side);
    if (rate == 0.0f) {
      const float held = fast::signed_as(with_friction, v_ == 0.0f ? pull : v_);
      const bool still = v_ == 0.0f && fast::magnitude(pull) <= with_friction;
      rate = still ? 0.0f : -fast::flipped(pull - held, with_side);
    }
    return rate > 0.0f;
  }

  // Set the series of the piece that begins here; false if nothing moves.
  bool begin() {
    static Inverse mass = LAWS_NO_INVERSE;
    float b = with_b, k = with_k, f = with_f;
    if (touching_) {
      k += with_contact;
      f += with_contact * with_touch;
    }
    if (beyond_) {
      k += with_wall;
      f += fast::flipped(with_wall * with_reach, beyond_);
    }
    float pull = f - b * v_ - k * x_;
    closing_ = touching_ && with_pad > 0.0f;
    if (closing_ && approaching(pull)) {
      b += with_pad;
      pull += with_pad * (with_speed - v_);
    }
    if (v_ == 0.0f && fast::magnitude(pull) <= with_friction) return false;
    if (with_friction > 0.0f) pull -= fast::signed_as(with_friction, v_ != 0.0f ? v_ : pull);
    const float inverse = mass.of(with_m);
    const float damped = b * inverse, sprung = k * inverse;
    span_ = left_;
    float once, twice;
    for (;;) {  // a series of few terms
      once = damped * span_;
      twice = sprung * span_ * span_;
      if (!(once + twice > 0.5f)) break;
      span_ = fast::scaled<-1>(span_);
    }
    series(pull * inverse, once, twice);
    return true;
  }

  // Fill the terms d_n span^n / n!, d_n the n-th derivative of the position.
  void series(float acceleration, float once, float twice) {
    term_[0] = x_;
    term_[1] = v_ * span_;
    term_[2] = fast::scaled<-1>(acceleration * span_ * span_);
    order_ = 2;
    while (order_ < kOrders) {
      const float n = order_ + 1;
      const float one = term_[order_], other = term_[order_ - 1];
      const float next = -(once * one + twice * other / (n - 1.0f)) / n;
      term_[++order_] = next;
      // two in a row, or one of them could be 0 by chance
      if (fast::magnitude(next) + fast::magnitude(one) * 0.25f < 1e-9f) break;
    }
  }

  // Return position (0), velocity * span (1) or acceleration * span^2 (2) at a share of the span.
  FAST_APART float at(uint8_t derivative, float share) const {
    float sum = 0.0f;
    for (int8_t n = order_; n >= static_cast<int8_t>(derivative); n--) {
      const uint8_t factor = derivative == 2 ? n * (n - 1) : n;
      sum = sum * share + (derivative ? factor * term_[n] : term_[n]);
    }
    return sum;
  }

  // Shorten the piece to where the derivative crosses a level; it does so once.
  void until(uint8_t derivative, float level) {
    const float start = at(derivative, 0.0f) - level;
    float low = 0.0f, high = share_;
    float t = share_, value = at(derivative, t) - level;
    t = start == value ? 0.0f : share_ * start / (start - value);
    for (uint8_t n = 0; n < 12; n++) {
      value = at(derivative, t) - level;
      if (value == 0.0f) break;
      if ((value < 0.0f) == (start < 0.0f)) low = t;
      else high = t;
      const float slope = at(derivative + 1, t);
      float guess = slope != 0.0f ? t - value / slope : high;
      if (!(low < guess && guess < high)) guess = fast::scaled<-1>(low + high);
      const float change = fast::magnitude(guess - t);
      t = guess;
      if (change < 3e-7f) break;
    }
    share_ = t;
  }

  // Do one piece; false if nothing moves.
  bool piece() {
    if (!begin()) return false;
    share_ = 1.0f;
    Event event = kNone;
    float q = at(0, 1.0f), u = at(1, 1.0f);
    const float v = term_[1], speed = with_speed * span_;
    bool stopped = false, matched = false;
    if (v * u < 0.0f && (with_friction > 0.0f || near_something(q))) {
      stopped = true;
      until(1, 0.0f);
      u = 0.0f;
      q = at(0, share_);
    }
    if (closing_ && (v - speed) * (u - speed) < 0.0f) {
      matched = true;
      stopped = false;
      until(1, speed);
      u = speed;
      q = at(0, share_);
    }
    const float depth = toward_touch(q);
    if (touching_ ? depth < 0.0f : depth > 0.0f) {
      event = kMeet;
      until(0, with_touch);
      q = with_touch;
    }
    if (beyond_ ? fast::flipped(q, beyond_) < with_reach : fast::magnitude(q) > with_reach) {
      event = kWall;
      const float level = fast::signed_as(with_reach, beyond_ ? static_cast<float>(beyond_) : q);
      until(0, level);
      q = level;
    }
    if (event != kNone) u = at(1, share_);
    x_ = q;
    v_ = event == kNone && stopped ? 0.0f : event == kNone && matched ? with_speed : u / span_;
    if (event == kMeet) touching_ = !touching_;
    if (event == kWall) beyond_ = beyond_ ? 0 : q > 0.0f ? 1 : -1;
    left_ = share_ == 1.0f ? left_ - span_ : left_ - share_ * span_;
    return true;
  }

  // Whether the piece may touch and leave something within the span.
  bool near_something(float q) const {
    const float way = fast::magnitude(q - x_) + fast::magnitude(term_[1]) + fast::magnitude(term_[2]);
    return fast::magnitude(x_ - with_touch) <= way || with_reach - fast::magnitude(x_) <= way;
  }

  float x_, v_, left_ = 0.0f, span_ = 0.0f, share_ = 1.0f;
  float term_[kOrders + 1];
  uint8_t order_ = 0;
  bool touching_, closing_ = false;
  int8_t beyond_;
};

}  // namespace

FAST_ONCE Results<float, float> exact(float x, float v) { return Motion(x, v).run(); }

}  // namespace numbers
}  // namespace laws
