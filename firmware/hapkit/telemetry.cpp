// The main program does this once per millisecond: it sends the pending replies that fit, then the report of
// the last tick.
#include "controller.h"
#include "lock.h"

void Controller::poll() {
  if (answers_.waiting()) answers_.send(sender_);
  if (!due_) return;
  const uint32_t time_us = board::us_of(stamp_);
  if (fade_.out()) {
    leave_law();
    take_pieces();
  }
  if (streaming_) report(time_us);
  due_ = false;
  board::pat();
  renderer_.move();
  if (next_.shown * next_.ticks > board::kTicksPerMs * 3 / 2) renderer_.move();
}

void Controller::report(uint32_t time_us) {
  const uint8_t rx_errors = parser_.bad_frames() + board::lost_bytes();
  const uint8_t flags = overrun_flag();
  if (shows_law_) {
    shown_.law.time_us = time_us;
    shown_.law.flags |= flags;
    shown_.law.rx_errors = rx_errors;
    lost_frame_ = !sender_.send(shown_.law);
    return;
  }
  {
    const Lock lock;
    shown_.sample.pwm = pwm_;
    shown_.sample.flags |= flags | safety_.flags();
  }
  shown_.sample.time_us = time_us;
  shown_.sample.rx_errors = rx_errors;
  shown_.sample.stale = stale_;
  shown_.sample.generation = loading_.generation();
  shown_.sample.received = loading_.received();
  shown_.sample.refusal = loading_.refusal();
  lost_frame_ = !sender_.send(shown_.sample);
}

// Return the flag for skipped ticks and lost reports since the last frame.
uint8_t Controller::overrun_flag() {
  const bool lost = lost_frame_ || late_ || told_overruns_ != overruns_;
  late_ = false;
  told_overruns_ = overruns_;
  return lost ? protocol::kFlagOverrun : 0;
}
