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
    return send(Message::kId, &message, sizeof(message), nullptr, 0);
  }

  // The same of one that is made up of two parts.
  template <class Message, class First, class Second>
  bool send(const First& first, const Second& second) {
    static_assert(sizeof(First) + sizeof(Second) == sizeof(Message), "the parts are not the whole message");
    return send(Message::kId, &first, sizeof(first), &second, sizeof(second));
  }

 private:
  bool send(uint8_t id, const void* payload, uint8_t size, const void* more, uint8_t more_size);
  uint8_t filled(uint8_t size) const;

  uint8_t multiple_ = 0;
};
