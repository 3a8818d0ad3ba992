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
    if (!begin<Message>()) return false;
    frame_.put(&message, sizeof(message));
    end();
    return true;
  }

  // The same of one that is made up of two parts.
  template <class Message, class First, class Second>
  bool send(const First& first, const Second& second) {
    static_assert(sizeof(First) + sizeof(Second) == sizeof(Message), "the parts are not the whole message");
    if (!begin<Message>()) return false;
    frame_.put(&first, sizeof(first));
    frame_.put(&second, sizeof(second));
    end();
    return true;
  }

 private:
  template <class Message>
  bool begin() {
    static_assert(1 + sizeof(Message) + frame::kOverhead <= board::kQueue, "the frame never fits the queue");
    return begin(Message::kId, 1 + sizeof(Message) + frame::kOverhead);
  }

  bool begin(uint8_t id, uint8_t size);
  void end();
  uint8_t filled(uint8_t size) const;

  frame::Writer frame_;
  uint8_t* end_ = nullptr;  // of the frame and what fills it up
  uint8_t multiple_ = 0;
};
