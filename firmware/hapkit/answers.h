// Pending replies to requests of the computer, sent when the queue has room.
#pragma once

#include <stdint.h>

#include "protocol.h"
#include "sender.h"

class Answers {
 public:
  enum Which : uint8_t { kHello = 1, kSettings = 2 };

  void want(Which which) { wanted_ |= which; }

  // Send the settings as the next reply. refused is true if the computer has sent invalid settings.
  void want_settings(bool refused) {
    refused_ = refused;
    want(kSettings);
  }

  bool waiting() const { return wanted_ != 0; }

  // Send the pending replies that fit into the queue; settings wait until a save has ended.
  void send(Sender& sender);

 private:
  // noinline, because its stack frame must not add to the deepest path of the caller
  __attribute__((noinline)) bool send_hello(Sender& sender);
  bool send_settings(Sender& sender);

  uint8_t wanted_ = 0;
  bool refused_ = false;
};
