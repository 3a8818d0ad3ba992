// Answers the computer and reports samples. receive() runs in the main program, sample() in the interrupt.
#pragma once

#include <stdint.h>

#include "board.h"
#include "frame.h"
#include "protocol.h"
#include "safety.h"

class Controller {
 public:
  // Take one received byte and act on the message that it completes.
  void receive(uint8_t byte);

  // Handle one sensor reading: watchdog, position, frames to the computer.
  void sample(const board::Sampling& sampling);

 private:
  void dispatch(const uint8_t* body, uint8_t size);
  void command(const protocol::Force& force);
  void drive(int16_t pwm);
  void off();
  uint16_t delay_since(uint16_t seq) const;
  void send_hello();
  void send_sample(const board::Sampling& sampling, int32_t count);

  frame::Parser parser_;
  Safety safety_;
  volatile bool hello_wanted_ = false;
  volatile bool streaming_ = false;
  bool overrun_ = false;

  // Written by one side, read by the other: only under a Lock.
  uint16_t last_seq_ = 0;
  uint32_t last_time_us_ = 0;
  uint16_t answered_ = 0;
  uint16_t delay_us_ = 0;
  int16_t pwm_ = 0;
};
