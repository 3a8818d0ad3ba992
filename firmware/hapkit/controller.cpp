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

// Messages are packed, so they may be read in place.
template <class Message>
const Message& as(const uint8_t* body) {
  return *reinterpret_cast<const Message*>(body + 1);
}

// Return the loop settings that supervise the handle while the computer renders.
estimator::Loop usual() { return {profile::kPeriodUs * board::kTicksPerMs / 1000, protocol::kEstimatorDifference, 0.0f, 0.0f}; }

}  // namespace

// Ticks have started already; they are skipped until a design is set.
void Controller::begin() { redesign(usual()); }

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
  } else if (is<protocol::Law>(body, size)) {
    announce(as<protocol::Law>(body));
  } else if (is<protocol::Piece>(body, size)) {
    take(as<protocol::Piece>(body));
  } else if (is<protocol::Tune>(body, size)) {
    tune(as<protocol::Tune>(body));
  } else if (is<protocol::Leave>(body, size)) {
    leave();
  } else if (is<protocol::Stream>(body, size)) {
    set_stream(as<protocol::Stream>(body));
  } else {
    ask(body, size);
  }
}

void Controller::ask(const uint8_t* body, uint8_t size) {
  if (is<protocol::HelloRequest>(body, size)) {
    answers_.want(Answers::kHello);
  } else if (is<protocol::SettingsRequest>(body, size)) {
    answers_.want(Answers::kSettings);
  } else if (is<protocol::Save>(body, size)) {
    settings::save();
    answers_.want(Answers::kSettings);
  } else if (is<protocol::Board>(body, size)) {
    set_kit(as<protocol::Board>(body));
  }
}

// Forces are ignored until the computer has started the stream, because they may have been sent before the
// board restarted. A delayed force is also ignored, unless it is zero.
void Controller::command(const protocol::Force& force) {
  if (renderer_.active()) return safety_.alive();
  if (!streaming_) return;
  uint16_t seq;
  uint32_t stamp;
  {
    const Lock lock;
    seq = last_seq_;
    stamp = last_stamp_;
  }
  // Samples are strictly periodic, so the time of an older sample follows from its number.
  const uint16_t age = seq - force.seq;
  if (age > profile::kWatchdogMs && force.force != 0.0f) {
    ++stale_;
    return;
  }
  const motor::Duty duty = motor::duty_of(force.force);
  uint32_t now;
  {
    const Lock lock;
    if (!safety_.command(duty.flags)) return drive(0);
    drive(duty.pwm);
    now = board::now_us();
  }
  constexpr uint16_t kForever = 65535;
  const uint16_t answered = force.seq - force.behind;
  const uint16_t before = seq - answered;
  const uint32_t delay = now - board::us_of(stamp) + before * profile::kPeriodUs;
  const bool told = before < kForever / profile::kPeriodUs && delay < kForever;
  const Lock lock;
  answered_ = answered;
  delay_us_ = told ? static_cast<uint16_t>(delay) : kForever;
}

// The present law fades out first; poll() does the rest.
void Controller::announce(const protocol::Law& law) {
  if (!loading_.announce(law)) return;
  if (renderer_.active()) {
    fade_.leave();
  } else {
    take_pieces();
  }
}

void Controller::take_pieces() {
  if (loading_.begin()) start_law();
}

// The verification of a law may take longer than the hardware watchdog allows. Meanwhile the ticks feed the
// watchdog for the main program.
void Controller::take(const protocol::Piece& piece) {
  vouched_ = kVouched;
  const bool ready = loading_.take(piece);
  vouched_ = 0;
  if (ready) start_law();
}

// The tick delays the start until a period has the length that the law needs.
void Controller::start_law() {
  fade_.restart();
  fade_.stay();
  safety_.accept();
  safety_.alive();
  redesign(loading_.loop());
  renderer_.start(loading_.shape(), loading_.generation());
}

// After an invalid change there is no law to render, so the motor is off until the next law.
void Controller::tune(const protocol::Tune& tune) {
  if (renderer_.tune(tune)) return;
  safety_.refuse();
  off();
}

// The computer renders after the board's force has faded out (see poll()), or at once after a second request.
void Controller::leave() {
  loading_.cancel();
  const bool felt = renderer_.active() && !safety_.off();
  return felt && !fade_.leaving() ? fade_.leave() : leave_law();
}

void Controller::leave_law() {
  renderer_.leave();
  fade_.stay();
  safety_.accept();
  off();
  redesign(usual());
}

// The zero may have changed, so rendering ends. The sensor tells the next tick that the handle has not moved.
void Controller::set_kit(const protocol::Board& kit) {
  loading_.cancel();
  renderer_.leave();
  fade_.stay();
  off();
  answers_.want_settings(!settings::accept(kit));
  redesign(usual());
}

void Controller::set_stream(const protocol::Stream& stream) {
  streaming_ = stream.on != 0;
  sender_.pad(stream.padded);
  if (!streaming_) off();
}

void Controller::redesign(const estimator::Loop& loop) {
  next_ready_ = false;
  fence();
  estimator::design(loop, settings::now().quantum, kFastest, &next_);
  fence();
  next_ready_ = true;
  board::set_period(next_.ticks);
}

void Controller::off() {
  const Lock lock;
  safety_.expire();
  fade_.restart();
  drive(0);
}
