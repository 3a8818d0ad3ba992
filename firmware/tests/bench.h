// A controller on a new board; the test controls the sample periods.
#pragma once

#include <cstring>
#include <vector>

#include "check.h"
#include "controller.h"
#include "fake_board.h"
#include "fake_eeprom.h"

class Bench {
 public:
  Bench() {
    fake::fresh_board();
    controller_.begin();
  }

  template <class Message>
  void receive(const Message& message) {
    say_bytes(fake::frame_of(fake::body_of(message)));
  }

  void say_bytes(const std::vector<uint8_t>& bytes) {
    for (uint8_t byte : bytes) controller_.receive(byte);
  }

  // Advance by one sample period, or by several of which all but the last are missed. The main program does
  // not run.
  void tick(uint16_t raw = 500, uint8_t missed = 0) {
    const uint16_t ended = ticks_;
    ticks_ = fake::ticks;
    time_ticks_ += static_cast<uint64_t>(ended) * (missed + 1);
    seq_ = static_cast<uint16_t>(seq_ + missed + 1);
    fake::now_us = static_cast<uint32_t>(time_ticks_ / 2);
    controller_.sample({seq_, raw, missed, ended, false});
  }

  void poll() { controller_.poll(); }

  // Advance by one sample period.
  void period(uint16_t raw = 500, uint8_t missed = 0) {
    tick(raw, missed);
    poll();
  }

  // Advance by one sample period; return the report.
  protocol::Sample sample(uint16_t raw = 500, uint8_t missed = 0) {
    fake::sent.clear();
    period(raw, missed);
    return last<protocol::Sample>();
  }

  template <class Message>
  Message last() {
    Message message{};
    const auto bodies = fake::take_bodies();
    CHECK(bodies.size() == 1);
    const bool right = !bodies.empty() && bodies[0].size() == 1 + Message::kSize && bodies[0][0] == Message::kId;
    CHECK(right);
    if (right) std::memcpy(&message, bodies[0].data() + 1, Message::kSize);
    return message;
  }

  void periods(int count, uint16_t raw = 500) {
    while (count--) period(raw);
  }

  uint16_t seq() const { return seq_; }

 private:
  Controller controller_;
  uint16_t seq_ = 65533;  // close to the wrap at 65536
  uint64_t time_ticks_ = 2 * UINT64_C(0xfffff000);
  uint16_t ticks_ = board::kTicksPerMs;
};
