// What the computer has asked about the board, sent when the queue has room.
#pragma once

#include <stdint.h>

#include "protocol.h"
#include "sender.h"

class Answers {
 public:
  enum Which : uint8_t { kHello = 1, kSettings = 2 };

  void want(Which which) { wanted_ |= which; }

  // refused: settings that no kit has were sent.
  void want_settings(bool refused) {
    refused_ = refused;
    want(kSettings);
  }

  bool waiting() const { return wanted_ != 0; }

  // Send what fits; settings that are being saved wait until they are.
  void send(Sender& sender);

 private:
  // Not a part of its callers: what it needs of the stack, others have meanwhile.
  __attribute__((noinline)) bool send_hello(Sender& sender);
  bool send_settings(Sender& sender);

  uint8_t wanted_ = 0;
  bool refused_ = false;
};
