// Transfers a law from the computer into the machine's memory, and verifies it when it is complete.
#pragma once

#include <stdint.h>

#include "estimator.h"
#include "machine.h"
#include "protocol.h"

class Loading {
 public:
  // Announce a law; return false if it is the last law again. The law is refused at once if the board has no
  // room or does not support its rate.
  bool announce(const protocol::Law& law);

  // Discard an incomplete law.
  void cancel() { phase_ = kNone; }

  // Start the transfer; the memory must be free. Return true if the law is already complete. Otherwise accept
  // the pieces of the law from here on.
  bool begin();

  // Accept a piece if it is the next one; return true if the law is then complete and valid.
  bool take(const protocol::Piece& piece);

  machine::Shape shape() const { return {law_.states, law_.given, law_.slots, law_.code}; }
  estimator::Loop loop() const { return {law_.period, law_.estimator, law_.first, law_.second}; }

  // Status, for samples, of the law that is being received or was received last; generation 0 means that
  // there was no law since the start.
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
  uint16_t crc_ = 0;  // CRC of the bytes received
};
