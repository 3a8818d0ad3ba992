// Fake hardware for the tests: a clock that the tests set, a motor that records its duty, and the bytes sent.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "board.h"
#include "protocol.h"

namespace fake {

extern uint32_t now_us;
extern int16_t pwm;
extern uint8_t room;
extern uint8_t lost;
extern bool held;                  // true while board::hold stops the sampling
extern std::function<void()> let_go;  // called once, at the end of the next hold
extern protocol::Board configured;  // argument of board::configure, and number of its calls
extern int configurations;
extern uint16_t ticks;              // ticks of a period, as set by board::set_period
extern uint16_t age_us;
extern int pats;
extern std::vector<uint8_t> sent;

using Body = std::vector<uint8_t>;

// Reset to the state after power-on.
void reset();

// Return the bodies of all frames sent so far, oldest first, and discard them. A body is empty if its CRC is
// wrong.
std::vector<Body> take_bodies();

// Return the frame of a body; it is encoded independently of the firmware.
std::vector<uint8_t> frame_of(const Body& body);

// Return the body of a message.
template <class Message>
Body body_of(const Message& message) {
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(&message);
  Body body{Message::kId};
  body.insert(body.end(), bytes, bytes + Message::kSize);
  return body;
}

// Return the CRC-16/CCITT-FALSE, computed bit by bit from its definition.
uint16_t crc_of(const Body& body);

}  // namespace fake
