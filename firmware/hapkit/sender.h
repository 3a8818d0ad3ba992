// Queues whole frames for the computer, filled up to a multiple of bytes where it asks for that.
#pragma once

#include <stdint.h>

#include "board.h"
#include "frame.h"

class Sender {
 public:
  // Fill every frame with delimiters to a multiple of so many bytes; 0: do not. What would never fit the queue
  // goes out as it is.
  void pad(uint8_t multiple) { multiple_ = multiple; }

  // Queue the frame of a message; false, and nothing queued, if it does not fit now.
  template <class Message>
  bool send(const Message& message) {
    static_assert(1 + sizeof(Message) + frame::kOverhead <= board::kQueue, "the frame never fits the queue");
    return send(Message::kId, &message, sizeof(message));
  }

 private:
  bool send(uint8_t id, const void* payload, uint8_t size);
  uint8_t filled(uint8_t size) const;

  uint8_t multiple_ = 0;
};
