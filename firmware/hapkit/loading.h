// A law on its way from the computer into the machine's memory, checked when it is whole.
#pragma once

#include <stdint.h>

#include "estimator.h"
#include "machine.h"
#include "protocol.h"

class Loading {
 public:
  // Take note of a law that is to come; false if it is the one that came last. It is refused at once if the board has
  // no room or no such rate for it.
  bool announce(const protocol::Law& law);

  // Forget a law that is not whole.
  void cancel() { phase_ = kNone; }

  // The memory is free: return whether the law is whole already; if not, take its pieces from now on.
  bool begin();

  // Take a piece if it is the next one; return whether the law is whole now and fit to run.
  bool take(const protocol::Piece& piece);

  machine::Shape shape() const { return {law_.states, law_.given, law_.slots, law_.code}; }
  estimator::Loop loop() const { return {law_.period, law_.estimator, law_.first, law_.second}; }

  // What samples tell of the law that is coming or came last; generation 0 is none since the start.
  uint8_t generation() const { return law_.generation; }
  uint16_t received() const { return received_; }
  uint8_t refusal() const { return static_cast<uint8_t>(refusal_); }

 private:
  enum Phase : uint8_t { kNone, kAnnounced, kComing };

  uint16_t size() const { return 4 * law_.given + law_.code; }
  bool advance();
  machine::Refusal look() const;
  machine::Refusal check() const;

  protocol::Law law_ = {};
  Phase phase_ = kNone;
  machine::Refusal refusal_ = machine::Refusal::kNone;
  uint16_t received_ = 0;
  uint16_t crc_ = 0;  // of what was received
};
