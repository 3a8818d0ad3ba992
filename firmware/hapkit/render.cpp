#include "render.h"

#include <math.h>
#include <string.h>

#include "build.h"
#include "laws/table.h"
#include "lock.h"
#include "times.h"

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define memcpy_P memcpy
#define strncpy_P strncpy
#endif

namespace render {
namespace {

// The Makefile has room for all, and somebody may have said which are to be on the board.
#if defined(HAPKIT_ALL_LAWS) || defined(LAWS_CHOSEN)
using laws::kCount;
using laws::kTable;
#else
#define LAW(name, discrete)                                                                           \
  {laws::name::kKey, laws::name::kParameters, laws::name::kStates, discrete, laws::name::kFingerprint, \
   laws::name::start, laws::name::force},
const laws::Law kTable[] PROGMEM = {HAPKIT_LAWS(LAW)};
constexpr uint8_t kCount = sizeof(kTable) / sizeof(*kTable);
#endif

}  // namespace

uint8_t count() { return kCount; }

bool describe(uint8_t number, protocol::LawName* name) {
  if (number >= kCount) return false;
  laws::Law law;
  memcpy_P(&law, &kTable[number], sizeof(law));
  name->law = number;
  name->parameters = law.parameters;
  name->states = law.states;
  name->fingerprint = law.fingerprint;
  strncpy_P(name->key, law.key, sizeof(name->key));
  return true;
}

float Fade::weighted(float force, uint8_t quarters) {
  uint8_t gone = gone_;
  if (leaving_) {
    gone = gone > kQuarters ? kQuarters : gone > quarters ? gone - quarters : 0;
  } else if (gone < kQuarters) {
    gone += quarters;
  }
  gone_ = gone;
  return gone < kQuarters ? force * times(gone, 1.0f / kQuarters) : force;
}

bool Renderer::accept(const protocol::Scene& scene, bool anew) {
  if (scene.law >= kCount) return false;
  laws::Law law;
  memcpy_P(&law, &kTable[scene.law], sizeof(law));
  for (uint8_t i = 0; i < law.parameters; ++i) {
    if (!isfinite(scene.values[i])) return false;
  }
  if (!anew && goes_on(scene)) {
    move_to(scene);
    return true;
  }
  const uint8_t other = bank_ ^ 1;
  memcpy(banks_[other], scene.values, sizeof(goal_));
  memcpy(goal_, scene.values, sizeof(goal_));
  const Lock lock;
  start_ = law.start;
  force_ = law.force;
  discrete_ = law.discrete;
  parameters_ = law.parameters;
  states_ = law.states;
  turn_ = 0;
  calls_left_ = 0;
  bank_ = other;
  law_ = scene.law;
  active_ = true;
  generation_ = scene.generation;
  fresh_ = true;
  laws::current = false;
  return true;
}

void Renderer::leave() { active_ = false; }

bool Renderer::goes_on(const protocol::Scene& scene) const {
  if (!active_ || scene.law != law_) return false;
  uint16_t choices = discrete_;
  for (uint8_t i = 0; choices; ++i, choices >>= 1) {
    if ((choices & 1) && scene.values[i] != goal_[i]) return false;
  }
  return true;
}

void Renderer::move_to(const protocol::Scene& scene) {
  const float* now = banks_[bank_];
  for (uint8_t i = 0; i < parameters_; ++i) {
    goal_[i] = scene.values[i];
    step_[i] = (goal_[i] - now[i]) * (1.0f / kSteps);
  }
  calls_left_ = kCalls;
  generation_ = scene.generation;
}

// The tick takes whichever bank is named when it begins; naming the other one is a single write.
void Renderer::move() {
  if (calls_left_ == 0 || --calls_left_ % 2) return;
  const bool last = calls_left_ == 0;
  const float* now = banks_[bank_];
  float* next = banks_[bank_ ^ 1];
  for (uint8_t i = 0; i < parameters_; ++i) {
    next[i] = last ? goal_[i] : step_[i] == 0.0f ? now[i] : now[i] + step_[i];
  }
  fence();
  bank_ = bank_ ^ 1;
  laws::current = false;
}

void Renderer::begin(Fade* fade) {
  fresh_ = false;
  start_(state_);
  fade->restart();
}

void Renderer::show_state(protocol::Telemetry* shown) {
  if (turn_ >= states_) turn_ = 0;
  shown->state_at = turn_;
  shown->state = states_ ? state_[turn_] : 0.0f;
  ++turn_;
}

}  // namespace render
