// Pending replies to requests of the computer, sent when the queue has room.
#pragma once

#include <stdint.h>

#include "protocol.h"
#include "sender.h"

class Answers {
 public:
  enum Which : uint8_t { kHello = 1, kSettings = 2 };

  void want(Which which) { wanted_ |= which; }

  // refused: the computer sent invalid settings.
  void want_settings(bool refused) {
    refused_ = refused;
    want(kSettings);
  }

  bool waiting() const { return wanted_ != 0; }

  // Send pending replies that fit; settings wait until a save has ended.
  void send(Sender& sender);

 private:
  // noinline: its stack frame must not add to the caller's deepest path.
  __attribute__((noinline)) bool send_hello(Sender& sender);
  bool send_settings(Sender& sender);

  uint8_t wanted_ = 0;
  bool refused_ = false;
};
