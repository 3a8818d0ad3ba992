#include "sender.h"

// Return the size of a frame with padding. It is at most 255, because a frame has less than 128 bytes.
uint8_t Sender::filled(uint8_t size) const {
  if (multiple_ == 0) return size;
  uint8_t whole = multiple_;
  while (whole < size) whole += multiple_;
  return whole <= board::kQueue ? whole : size;
}

bool Sender::begin(uint8_t id, uint8_t size) {
  const uint8_t whole = filled(size);
  uint8_t* const room = board::room_for(whole);
  if (!room) return false;
  frame_ = frame::Writer(room);
  frame_.put(&id, 1);
  end_ = room + whole;
  return true;
}

void Sender::end() {
  for (uint8_t* at = frame_.finish(); at != end_; ++at) *at = 0;
  board::send(end_);
}
