#include "sender.h"

// How many bytes a frame takes with its filling. A frame is below 128 bytes, so this cannot pass 255.
uint8_t Sender::filled(uint8_t size) const {
  if (multiple_ == 0) return size;
  uint8_t whole = multiple_;
  while (whole < size) whole += multiple_;
  return whole <= board::kQueue ? whole : size;
}

bool Sender::send(uint8_t id, const void* payload, uint8_t size, const void* more, uint8_t more_size) {
  const uint8_t whole = filled(1 + size + more_size + frame::kOverhead);
  uint8_t* const begin = board::room_for(whole);
  if (!begin) return false;
  frame::Writer writer(begin);
  writer.put(&id, 1);
  writer.put(payload, size);
  writer.put(more, more_size);
  uint8_t* at = writer.finish();
  while (at != begin + whole) *at++ = 0;
  board::send(at);
  return true;
}
