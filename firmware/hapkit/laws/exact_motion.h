// The exact motion of a mass: hapkit_studio.dynamics.events in single precision, written for the board.
// Within a piece, where the same springs and dampers act, position and velocity after a period are linear in
// velocity and acceleration before it; the four numbers of each piece are kept. Only where something is met
// within the period is it gone through from event to event.
#pragma once

#include "contact.h"

namespace laws {
namespace numbers {
namespace mass {

static bool damped, rubbed, rough;
static Real drop;                // what friction takes of the acceleration
static Real damping, stiffness;  // by the mass, of the present piece
static Real acting, rate, span;

// The motion over a period: in the air, in contact, in a wall.
struct Map {
  Real way, bend, rest, gain;
  uint8_t piece;
};
static Map maps[3];
static uint8_t missing;  // maps that wait for an idle period
constexpr float kSlight = 1e-6f;  // a mass this deep for a period feels nothing of it
enum : uint8_t { kPieces = 24, kOrders = 10, kAny = 0x80, kLong = 0x40 };

inline uint8_t mark() { return kAny | touching | closing << 1 | beyond << 2; }

// Whether two numbers have different signs, neither being 0.
FAST_ONCE bool turned(float from, float to) {
  return fast::above_zero(from) ? fast::below_zero(to) : fast::below_zero(from) && fast::above_zero(to);
}

// Whether their signs' bits are different: sooner.
inline bool signs_differ(float from, float to) { return (fast::bits(from) ^ fast::bits(to)) >> 31; }

// Reckon damping and stiffness of what acts.
FAST_ONCE void shape() {
  float sum = with_b;
  if (closing) sum = sum + with_pad;
  damping = sum * inverse;
  sum = with_k;
  if (touching) sum = sum + with_contact;
  if (beyond) sum = sum + with_wall;
  stiffness = sum * inverse;
}

// 1 / n: dividing takes three times as long.
inline float share(uint8_t n) {
  static const float kParts[] PROGMEM = {
      1.0f, 0.5f, 0.33333333f, 0.25f, 0.2f, 0.16666667f, 0.14285714f, 0.125f, 0.11111111f, 0.1f};
#ifdef __AVR__
  return pgm_read_float(kParts + n - 1);
#else
  return kParts[n - 1];
#endif
}

// Reckon the velocity after a time, and the mean one, from the velocity and the acceleration * time before. A
// power series, until it says nothing more; once, twice = damping * time, stiffness * time^2 by the mass.
static Real once, twice;
FAST_ONCE bool says_nothing(float part) { return !fast::larger(part, 1e-7f); }
FAST_ONCE void series(float older, float term) {
  rate = older + term;
  end = older + fast::scaled<-1>(term);
  float stiff = older * twice;
  for (uint8_t n = 2; n < kOrders; n++) {
    const float braked = term * once, ahead = term * twice;
    if (says_nothing(stiff) && says_nothing(braked) && says_nothing(ahead)) break;
    term = -(stiff * share(n - 1) + braked) * share(n);
    rate = term + rate;
    end = term * share(n + 1) + end;
    stiff = ahead;
  }
}

// Reckon `once` and `twice`; return their sum: the series is short while it is small.
constexpr float kShort = 0.7f;
FAST_ONCE float spread(float t) {
  once = t * damping;
  twice = t * stiffness * t;
  return once + twice;
}

FAST_ONCE void chart(Map* map) {
  shape();
  map->piece = mark();
  const float size = spread(with_h);
  if (size < 1e-3f) {
    // its first terms: the next are below 1e-7 of what comes of them
    const float c = once;
    rate = (c * once - twice) * 0.16666667f - fast::scaled<-1>(c) + 1.0f;
    end = c * -0.16666667f + 0.5f;
  } else {
    if (!(size < kShort)) map->piece |= kLong;
    series(0.0f, 1.0f);
  }
  const float h = with_h, mean = end;
  map->way = (mean * once + rate) * h;
  map->bend = mean * h * h;
  map->rest = 1.0f - mean * twice;
  map->gain = h * rate;
}

// Change the end for a surface that was passed, the wall's or the handle's: its spring has acted since then, or has
// not any more, with a push that grew with the depth. False where that is not near enough.
inline bool bent(float a, bool wall) {
  if (rough) return false;
  const float deep = end - (wall ? like(with_reach, end) : with_touch.n);
  const float since = deep / rate.n, speed = fast::magnitude(rate);
  const float change = fast::scaled<-1>(since * deep * inverse * (wall ? with_wall : with_contact));
  if (fast::larger(a * since, fast::scaled<-4>(speed))) return false;
  if (fast::larger(change, fast::scaled<-10>(speed))) return false;
  const float more = like(change, wall ? -end : facing(1.0f));
  rate = more + rate;
  end = fast::scaled<-2>(since * more) + end;
  return true;
}

// Whether the end is right as it is, or after a small change.
FAST_ONCE bool reached(float a) {
  const float deep = depth(end);
  const bool touches = fast::above_zero(deep), leaves = walled && fast::larger(end, with_reach.n);
  const bool same = touches == touching;
  if (signs_differ(with_v, rate) && turned(with_v, rate)) {
    const float before = fast::magnitude(with_v), after = fast::magnitude(rate), out = fast::magnitude(end);
    const float swing = (before + after) * with_h;
    if (rubbed || leaves != beyond || !fast::larger(out - with_reach, swing)) return false;
    return fast::larger(deep, swing) ? same : !damped && !fast::larger(swing, kSlight);
  }
  if (damped && (touches || touching)) {
    const bool closes = fast::above_zero(approach(rate));
    return same && leaves == beyond && closes == closing;
  }
  const bool passed = leaves != beyond;
  return passed == same ? bent(a, passed) : same;
}

// Begin a piece: what acts there; false if nothing moves.
FAST_ONCE bool begin() {
  closing = false;
  const float v = with_v;
  float sum = loaded(with_x) - v * with_b;
  const bool rests = fast::is_zero(v), still = rests && !fast::larger(sum, with_friction.n);
  if (damped && touching) {
    // at equal speed by what pulls
    float near = approach(v);
    if (fast::is_zero(near) && !still) near = facing(like(with_friction, rests ? sum : v) - sum);
    if (fast::above_zero(near)) {
      closing = true;
      sum -= (v - with_speed) * with_pad;
    }
  }
  if (rests && !fast::larger(sum, with_friction.n)) return false;
  acting = (sum - like(with_friction, rests ? sum : v)) * inverse;
  shape();
  return true;
}

// Move on from the piece's beginning by its span.
FAST_ONCE void advance() {
  const float t = span;
  spread(t);
  series(with_v, t * acting);
  end = t * end + with_x;
}

// Shorten the piece to where the place, or the velocity, crosses a level, which it does once.
FAST_ONCE void until(bool place, float level) {
  Real& ahead = place ? end : rate;
  const float start = (place ? with_x : with_v) - level;
  float low = 0.0f, high = span;
  span = span * (start / (start - (ahead - level)));
  for (uint8_t n = 0; n < 12; n++) {
    advance();
    const float off = ahead - level;
    (turned(start, off) ? high : low) = span;
    const float change = acting - (rate - with_v) * damping - (end - with_x) * stiffness;
    float guess = span - off / (place ? rate : change);
    if (!(low <= guess && guess <= high)) guess = fast::scaled<-1>(low + high);
    const float more = guess - span;
    span = guess;
    if (fast::larger(more, 1e-3f * with_h)) continue;
    end = more * rate + end;
    rate = more * change + rate;
    break;
  }
  ahead = level;
}

// Shorten the piece to the first event: the velocity's zero parts it, because the mass may touch something and
// leave it again, and friction turns round.
inline void part() {
  if (turned(with_v, rate)) until(false, 0.0f);
  if (damped && touching && turned(approach(with_v), approach(rate))) until(false, with_speed);
  const float deep = depth(end);
  const bool touched = touching;
  if (turned(touched ? 1.0f : -1.0f, deep)) {
    until(true, with_touch);
    touching = !touched;
  }
  const bool leaves = fast::larger(end, with_reach.n);
  if (leaves == beyond) return;
  until(true, like(with_reach, end));
  touching = touched;
  beyond = leaves;
}

FAST_ONCE void arrive() {
  with_x = end.n;
  with_v = rate.n;
}

// Move on to the end of the period, from event to event; a mass that meets too much waits.
FAST_ONCE void pieces() {
  float left = with_h;
  end = with_x.n;
  for (uint8_t n = kPieces; n && fast::above_zero(left); n--) {
    if (!begin()) return static_cast<void>(with_v = 0.0f);
    float t = left;
    while (!(spread(t) < kShort)) t = fast::scaled<-1>(t);
    span = t;
    advance();
    part();
    arrive();
    left = left - span;
  }
}

FAST_ONCE Map* map_of(uint8_t piece) { return &maps[piece]; }

// A mass that rests leaves time to chart what it will meet; not in the period in which all was prepared.
inline void foresee() {
  if (!missing || --missing >= 3) return;
  beyond = walled && missing == 2;
  touching = missing == 1;
  closing = touching && damped;
  chart(map_of(missing));
}

FAST_ONCE void exact(float a) {
  const float v = with_v;
  const bool rests = fast::is_zero(v);
  if (rests && !fast::larger(a, drop.n)) return foresee();
  if (rubbed) a -= like(drop, rests ? a : v);
  Map* const map = map_of(beyond ? 2 : touching);
  if ((map->piece & static_cast<uint8_t>(~kLong)) != mark()) chart(map);
  end = v * map->way + a * map->bend + with_x;
  rate = v * map->rest + a * map->gain;
  if ((map->piece & kLong) || !reached(a)) return pieces();
  arrive();
}

}  // namespace mass
}  // namespace numbers
}  // namespace laws
