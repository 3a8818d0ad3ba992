#pragma GCC optimize("O2")  // also for what is included

#include "sender.h"

// How many delimiters fill a frame up.
uint8_t Sender::filling(uint8_t size) const {
  const uint8_t rest = multiple_ ? size % multiple_ : 0;
  const uint16_t missing = rest ? multiple_ - rest : 0;
  return size + missing <= board::kQueue ? static_cast<uint8_t>(missing) : 0;
}

bool Sender::send(uint8_t id, const void* payload, uint8_t size) {
  const uint8_t whole = 1 + size + frame::kOverhead;
  const uint8_t more = filling(whole);
  if (board::room() < whole + more) return false;
  board::send_frame(id, payload, size, more);
  return true;
}
