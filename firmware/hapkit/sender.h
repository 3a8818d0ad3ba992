// Queues whole frames for the computer; on request it pads each frame to a multiple of a given size.
#pragma once

#include <stdint.h>

#include "board.h"
#include "frame.h"

class Sender {
 public:
  // Pad every frame with delimiters to a multiple of this size; 0 means no padding. A padded frame that
  // cannot fit into the queue is sent without padding.
  void pad(uint8_t multiple) { multiple_ = multiple; }

  // Queue the frame of a message. Return false, and queue nothing, if the frame does not fit now.
  template <class Message>
  bool send(const Message& message) {
    if (!begin<Message>()) return false;
    frame_.put(&message, sizeof(message));
    end();
    return true;
  }

  // The same for a message that consists of two parts.
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
  uint8_t* end_ = nullptr;  // end of the frame with its padding
  uint8_t multiple_ = 0;
};
