#pragma GCC optimize("O2")  // also for what is included

#include "sender.h"

// How many bytes a frame takes with its filling. A frame is below 128 bytes, so this cannot pass 255.
uint8_t Sender::filled(uint8_t size) const {
  if (multiple_ == 0) return size;
  uint8_t whole = multiple_;
  while (whole < size) whole += multiple_;
  return whole <= board::kQueue ? whole : size;
}

bool Sender::send(uint8_t id, const void* payload, uint8_t size) {
  return board::send_frame(id, payload, size, filled(1 + size + frame::kOverhead));
}
