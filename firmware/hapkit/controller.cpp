#include "controller.h"

#include "lock.h"
#include "motor.h"
#include "profile.h"
#include "settings.h"

namespace {

template <class Message>
bool is(const uint8_t* body, uint8_t size) {
  return body[0] == Message::kId && size == 1 + Message::kSize;
}

// Messages are packed, so they may be read where they are.
template <class Message>
const Message& as(const uint8_t* body) {
  return *reinterpret_cast<const Message*>(body + 1);
}

}  // namespace

// Ticks have begun already; until their design is there they skip.
void Controller::begin() {
  static_assert(protocol::kEstimatorDifference == 0, "a loop begins with differences");
  loop_.rate = profile::kSampleRate;
  redesign();
}

void Controller::receive(uint8_t byte) {
  const uint8_t size = parser_.push(byte);
  if (size) dispatch(parser_.body(), size);
}

void Controller::dispatch(const uint8_t* body, uint8_t size) {
  if (is<protocol::Force>(body, size)) {
    command(as<protocol::Force>(body));
  } else if (is<protocol::Alive>(body, size)) {
    if (renderer_.active()) safety_.alive();
  } else if (is<protocol::Stop>(body, size)) {
    safety_.stop();
    off();
  } else if (is<protocol::Release>(body, size)) {
    safety_.release();
    off();
  } else if (is<protocol::Scene>(body, size)) {
    choose(as<protocol::Scene>(body));
  } else if (is<protocol::Loop>(body, size)) {
    set_loop(as<protocol::Loop>(body));
  } else if (is<protocol::Stream>(body, size)) {
    set_stream(as<protocol::Stream>(body));
  } else {
    ask(body, size);
  }
}

void Controller::ask(const uint8_t* body, uint8_t size) {
  if (is<protocol::HelloRequest>(body, size)) {
    answers_.want(Answers::kHello);
  } else if (is<protocol::LawRequest>(body, size)) {
    answers_.want_law(as<protocol::LawRequest>(body).law);
  } else if (is<protocol::SettingsRequest>(body, size)) {
    answers_.want(Answers::kSettings);
  } else if (is<protocol::Save>(body, size)) {
    settings::save();
    answers_.want(Answers::kSettings);
  } else if (is<protocol::Board>(body, size)) {
    set_kit(as<protocol::Board>(body));
  }
}

// What was on its way to a board that has begun anew meanwhile is not meant for this one.
void Controller::command(const protocol::Force& force) {
  if (renderer_.active()) return safety_.alive();
  if (!streaming_) return;
  const motor::Limited limited = motor::limit(force.force);
  const int16_t pwm = motor::pwm_of(limited.force);
  uint32_t now, stamp;
  uint16_t seq;
  {
    const Lock lock;
    if (!safety_.command(limited.flags)) return drive(0);
    drive(pwm);
    now = board::now_us();
    stamp = last_stamp_;
    seq = last_seq_;
  }
  answered_ = force.seq;
  // samples are strictly periodic, so an older one's time follows from its number
  constexpr uint16_t kForever = 65535;
  const uint16_t age = seq - force.seq;
  const uint32_t delay = now - board::us_of(stamp) + age * profile::kPeriodUs;
  delay_us_ = age < kForever / profile::kPeriodUs && delay < kForever ? static_cast<uint16_t>(delay) : kForever;
}

void Controller::leave_law() {
  renderer_.leave();
  fade_.stay();
  safety_.accept();
  off();
  redesign();
}

// The computer renders once the board's force has gone out, poll() sees to it; told again, it does so at once.
// A scene that cannot be rendered leaves nothing that could be: the motor is off until the next one.
void Controller::choose(const protocol::Scene& scene) {
  if (scene.law == protocol::kNoLaw) {
    const bool felt = renderer_.active() && !safety_.off();
    return felt && !fade_.leaving() ? fade_.leave() : leave_law();
  }
  if (renderer_.accept(scene, safety_.refused())) {
    fade_.stay();
    safety_.accept();
    safety_.alive();
  } else {
    return refuse();
  }
  redesign();
}

void Controller::refuse() {
  safety_.refuse();
  off();
}

void Controller::set_loop(const protocol::Loop& loop) {
  estimator::Design made;
  if (!estimator::design(loop, settings::now().quantum, kFastest, &made)) return refuse();
  loop_ = loop;
  redesign();
}

// The zero may be elsewhere now, so whatever was rendered ends; the sensor tells the next tick that no handle
// moved.
void Controller::set_kit(const protocol::Board& kit) {
  renderer_.leave();
  off();
  answers_.want_settings(!settings::accept(kit));
  redesign();
}

void Controller::set_stream(const protocol::Stream& stream) {
  streaming_ = stream.on != 0;
  sender_.pad(stream.padded);
  if (!streaming_) off();
}

// The computer renders at the usual rate; the board's own laws have their own.
void Controller::redesign() {
  protocol::Loop loop = loop_;
  if (!renderer_.active()) loop.rate = profile::kSampleRate;
  next_ready_ = false;
  fence();
  estimator::design(loop, settings::now().quantum, kFastest, &next_);
  fence();
  next_ready_ = true;
  board::set_period(next_.quarters);
}

void Controller::off() {
  const Lock lock;
  safety_.expire();
  fade_.restart();
  drive(0);
}
