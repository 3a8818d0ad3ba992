// The controller's part in the interrupt: position, velocity, safety, force, motor.
#include "controller.h"
#include "lock.h"
#include "motor.h"
#include "sensor.h"

// Assume that the handle moves uniformly over missed periods.
void Controller::miss(const board::Sampling& sampling, int32_t count) {
  for (uint8_t missed = sampling.missed; missed; --missed) safety_.period(sampling.ticks);
  overruns_ += sampling.missed;
  estimator_.miss(sampling.missed, count);
}

// The old design applies until the period has changed.
void Controller::adopt() {
  if (design_.ticks != next_.ticks) estimator_.change();
  design_ = next_;
  next_ready_ = false;
}

inline void Controller::watch(const board::Sampling& sampling, int32_t count) {
  if (sampling.missed) miss(sampling, count);
  safety_.period(sampling.ticks);
  const uint8_t news = sensor::news;
  safety_.sensor(news & sensor::kFaulty);
  if (news & (sensor::kMoved | sensor::kFaulty)) {
    sensor::take_moved();
    estimator_.restart(count);
  } else if (sampling.ticks != design_.ticks) {
    estimator_.skip(count);
  } else if (!estimator_.update(design_, count)) {
    safety_.over_speed();
  }
}

inline void Controller::follow() {
  const motor::Duty duty = motor::duty_of(fade_.whole() ? asked_ : fade_.weighted(asked_, design_.ticks));
  safety_.rendered(duty.flags);
  drive(duty.pwm);
}

__attribute__((always_inline)) inline void Controller::render(int32_t count) {
  // this product takes up to a fifth of the time of a law at the fastest rate
  const float velocity = machine::program.reads_velocity ? estimator_.velocity(design_) : 0.0f;
  asked_ = safety_.refused() ? 0.0f : machine::run(times(count, design_.quantum), velocity);
  if (safety_.off()) {
    fade_.restart();
    return drive(0);
  }
  follow();
  const uint16_t age = board::age_us();
  delays_us_ += age;
}

// Report every n-th tick, with the smallest n for which reports are at least a millisecond apart.
inline void Controller::show(const board::Sampling& sampling, int32_t count, bool rendered) {
  if (++since_shown_ >= design_.shown) show_now(sampling, count, rendered);
}

void Controller::vouch() {
  vouched_ = vouched_ - 1;
  board::pat();
}

void Controller::show_now(const board::Sampling& sampling, int32_t count, bool rendered) {
  since_shown_ = 0;
  if (due_) {
    late_ = true;
    if (vouched_) vouch();
    return;
  }
  stamp_ = board::stamp();
  shows_law_ = rendered;
  if (shows_law_) {
    show_law(sampling, count);
  } else {
    show_sample(sampling, count);
  }
  fence();
  due_ = true;
  board::wake();
}

void Controller::sample(const board::Sampling& sampling) {
  if (next_ready_ && sampling.ticks == next_.ticks) adopt();
  const int32_t count = sensor::count(sampling.raw, sampling.failed);
  watch(sampling, count);
  const bool renders = renderer_.active() && !next_ready_;  // a new law waits until its rate applies
  if (renders) {
    render(count);
  } else {
    last_seq_ = sampling.seq;
    last_stamp_ = board::stamp();
    if (safety_.off()) drive(0);
  }
  show(sampling, count, renders);
}

static uint8_t doubt_flag() { return sensor::take_doubt() ? protocol::kFlagSensor : 0; }

// A force applied after this function belongs to the next sample, even if this sample is not sent yet.
// Therefore the computer never uses the age of one force for two periods.
void Controller::show_sample(const board::Sampling& sampling, int32_t count) {
  shown_.sample.seq = sampling.seq;
  shown_.sample.count = count;
  shown_.sample.raw = sampling.raw;
  shown_.sample.answered = answered_;
  shown_.sample.delay_us = delay_us_;
  shown_.sample.flags = doubt_flag();
}

// Return the mean over one to four ticks without a division, which would take 200 cycles.
static uint16_t mean(uint16_t sum, uint8_t ticks) {
  constexpr uint32_t kThird = 21846;  // a third in 2^-16
  if (ticks == 3) return static_cast<uint16_t>(sum * kThird >> 16);
  for (; ticks > 1; ticks >>= 1) sum >>= 1;
  return sum;
}

void Controller::show_law(const board::Sampling& sampling, int32_t count) {
  shown_.law.seq = sampling.seq;
  shown_.law.count = count;
  shown_.law.velocity = estimator_.velocity(design_);
  shown_.law.asked = asked_;
  shown_.law.pwm = pwm_;
  shown_.law.flags = safety_.flags() | doubt_flag();
  shown_.law.delay_us = mean(delays_us_, design_.shown);
  shown_.law.overruns = overruns_;
  shown_.law.generation = renderer_.generation();
  renderer_.show_state(&shown_.law);
  delays_us_ = 0;
}
