#include "controller.h"

#include <string.h>

#include "build.h"
#include "lock.h"
#include "motor.h"
#include "profile.h"
#include "sensor.h"
#include "settings.h"

namespace {

template <class Message>
bool is(const uint8_t* body, uint8_t size) {
  return body[0] == Message::kId && size == 1 + Message::kSize;
}

struct ToComputer {
  void operator()(const uint8_t* bytes, uint8_t size) const { board::send(bytes, size); }
};

// Queue the frame of a message; false, and nothing queued, if it does not fit.
template <class Message>
bool send(const Message& message) {
  if (board::room() < 1 + sizeof(message) + frame::kOverhead) return false;
  frame::Writer<ToComputer> writer{ToComputer()};
  writer.put(Message::kId);
  writer.put(&message, sizeof(message));
  writer.finish();
  return true;
}

}  // namespace

void Controller::receive(uint8_t byte) {
  const uint8_t size = parser_.push(byte);
  if (size) dispatch(parser_.body(), size);
}

void Controller::dispatch(const uint8_t* body, uint8_t size) {
  if (is<protocol::Force>(body, size)) {
    protocol::Force force;
    memcpy(&force, body + 1, sizeof(force));
    command(force);
  } else if (is<protocol::Stop>(body, size)) {
    safety_.stop();
    off();
  } else if (is<protocol::Release>(body, size)) {
    safety_.release();
    off();
  } else if (is<protocol::HelloRequest>(body, size)) {
    hello_wanted_ = true;
  } else if (is<protocol::Stream>(body, size)) {
    streaming_ = body[1] != 0;
    if (!streaming_) off();
  }
}

void Controller::command(const protocol::Force& force) {
  const motor::Limited limited = motor::limit(force.force);
  const int16_t pwm = motor::pwm_of(limited.force);
  const Lock lock;
  if (!safety_.command(limited.flags)) return drive(0);
  drive(pwm);
  answered_ = force.seq;
  delay_us_ = delay_since(force.seq);
}

void Controller::drive(int16_t pwm) {
  board::set_motor(pwm);
  pwm_ = pwm;
}

void Controller::off() {
  const Lock lock;
  safety_.expire();
  drive(0);
}

// Samples are strictly periodic, so an older one's time follows from its number.
uint16_t Controller::delay_since(uint16_t seq) const {
  constexpr uint16_t kForever = 65535;
  const uint16_t age = last_seq_ - seq;
  if (age >= kForever / profile::kPeriodUs) return kForever;
  const uint32_t delay = board::now_us() - last_time_us_ + age * profile::kPeriodUs;
  return delay < kForever ? static_cast<uint16_t>(delay) : kForever;
}

void Controller::sample(const board::Sampling& sampling) {
  {
    const Lock lock;
    last_seq_ = sampling.seq;
    last_time_us_ = sampling.time_us;
    if (safety_.period()) drive(0);
  }
  const int32_t count = sensor::count(sampling.raw, sampling.failed);
  if (sampling.overrun) overrun_ = true;
  if (streaming_) send_sample(sampling, count);
  if (hello_wanted_) send_hello();
}

void Controller::send_sample(const board::Sampling& sampling, int32_t count) {
  protocol::Sample sample;
  sample.seq = sampling.seq;
  sample.time_us = sampling.time_us;
  sample.count = count;
  sample.raw = sampling.raw;
  sample.rx_errors = parser_.bad_frames() + board::lost_bytes();
  {
    const Lock lock;
    sample.answered = answered_;
    sample.delay_us = delay_us_;
    sample.pwm = pwm_;
    sample.flags = safety_.flags();
  }
  if (overrun_) sample.flags |= protocol::kFlagOverrun;
  overrun_ = !send(sample);
}

void Controller::send_hello() {
  protocol::Hello hello;
  hello.version = protocol::kVersion;
  const protocol::Board& kit = settings::now();
  hello.quantum = kit.quantum;
  hello.max_force = kit.max_force;
  hello.motor_constant = kit.motor_constant;
  hello.handle_radius = kit.handle_radius;
  hello.pulley_radius = kit.pulley_radius;
  hello.sector_radius = kit.sector_radius;
  hello.tick_us = board::kTickUs;
  hello.counts_per_flip = kit.counts_per_flip;
  hello.sample_rate = profile::kSampleRate;
  hello.watchdog_ms = profile::kWatchdogMs;
  hello.pwm_top = profile::kPwmTop;
  hello.profile = kit.profile;
  hello.laws = 0;
  hello.origin = settings::origin();
  hello.reset = 0;
  memset(hello.build, 0, sizeof(hello.build));
  memcpy(hello.build, HAPKIT_BUILD, sizeof(HAPKIT_BUILD) - 1);
  static_assert(sizeof(HAPKIT_BUILD) - 1 <= sizeof(hello.build), "the build's name is too long");
  hello_wanted_ = !send(hello);
}
