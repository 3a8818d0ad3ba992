#include "render.h"

#include <math.h>

#include "flash.h"
#include "lock.h"
#include "times.h"

namespace render {
namespace {

using machine::kFirstGiven;

constexpr uint8_t kRampMs = 30;

// The fraction of the remaining distance that the next step of a ramp covers: 1 / remaining steps.
const float kShares[] PROGMEM = {1.0f,      1.0f / 2,  1.0f / 3,  1.0f / 4,  1.0f / 5,  1.0f / 6,  1.0f / 7, 1.0f / 8,
                                 1.0f / 9,  1.0f / 10, 1.0f / 11, 1.0f / 12, 1.0f / 13, 1.0f / 14, 1.0f / 15};
static_assert(2 * sizeof(kShares) / sizeof(*kShares) == kRampMs, "a step every other ms");

}  // namespace

float Fade::weighted(float force, uint16_t ticks) {
  uint16_t gone = gone_;
  if (leaving_) {
    gone = gone > kWhole ? kWhole : gone > ticks ? gone - ticks : 0;
  } else if (gone < kWhole) {
    gone += ticks;
  }
  gone_ = gone;
  return gone < kWhole ? force * times(gone, 1.0f / kWhole) : force;
}

void Renderer::start(const machine::Shape& shape, uint8_t generation) {
  shape_ = shape;
  law_ = generation_ = generation;
  turn_ = count_ = 0;
  fence();
  active_ = true;
}

// Return the number of ramps of constants for which the memory has room.
uint8_t Renderer::room() const {
  const uint16_t most = (machine::kArena - 4 * shape_.slots - shape_.code) / sizeof(Moving);
  return most < 255 ? most : 255;
}

Renderer::Moving* Renderer::find(uint8_t slot) const {
  for (Moving* one = moving(); one != moving() + count_; ++one) {
    if (one->slot == slot) return one;
  }
  return nullptr;
}

// Only constants may ramp, and only to finite numbers.
bool Renderer::fits(const protocol::Tune& tune) const {
  if (tune.count > protocol::kTuned) return false;
  for (uint8_t i = 0; i < tune.count; ++i) {
    const uint8_t slot = tune.slots[i];
    if (slot < kFirstGiven + shape_.states || slot >= kFirstGiven + shape_.given || !isfinite(tune.values[i])) return false;
  }
  return true;
}

bool Renderer::tune(const protocol::Tune& tune) {
  if (!active_ || tune.law != law_ || tune.generation == generation_) return true;
  if (!fits(tune)) return false;
  uint8_t more = 0;
  for (uint8_t i = 0; i < tune.count; ++i) more += !find(tune.slots[i]);
  if (count_ + more > room()) return true;
  for (uint8_t i = 0; i < tune.count; ++i) {
    Moving* one = find(tune.slots[i]);
    if (!one) one = moving() + count_++;
    *one = {tune.slots[i], kRampMs, tune.values[i]};
  }
  generation_ = tune.generation;
  return true;
}

// A step every other millisecond takes half of the work, and is imperceptible.
void Renderer::move_on() {
  for (uint8_t i = 0; i < count_;) {
    Moving* one = moving() + i;
    if (--one->left % 2 == 0) {
      float* slot = machine::slots() + one->slot;
      const float share = flash::read(&kShares[one->left / 2]);
      const float next = one->left ? *slot + (one->target - *slot) * share : one->target;
      const Lock lock;
      *slot = next;
    }
    if (one->left) {
      ++i;
    } else {
      *one = moving()[--count_];
    }
  }
}

void Renderer::show_state(protocol::Telemetry* shown) {
  if (turn_ >= shape_.states) turn_ = 0;
  shown->state_at = turn_;
  shown->state = shape_.states ? machine::slots()[kFirstGiven + turn_] : 0.0f;
  ++turn_;
}

}  // namespace render
