#pragma GCC optimize("O2")  // also for what is included

#include "sender.h"

namespace {

struct ToComputer {
  void operator()(const uint8_t* bytes, uint8_t size) const { board::send(bytes, size); }
};

}  // namespace

// How many delimiters fill a frame up.
uint8_t Sender::filling(uint8_t size) const {
  const uint8_t rest = multiple_ ? size % multiple_ : 0;
  const uint16_t missing = rest ? multiple_ - rest : 0;
  return size + missing <= board::kQueue ? static_cast<uint8_t>(missing) : 0;
}

bool Sender::send(uint8_t id, const void* payload, uint8_t size) {
  const uint8_t whole = 1 + size + frame::kOverhead;
  uint8_t more = filling(whole);
  if (board::room() < whole + more) return false;
  frame::Writer<ToComputer> writer{ToComputer()};
  writer.put(id);
  writer.put(payload, size);
  writer.finish();
  const uint8_t delimiter = 0;
  for (; more; --more) board::send(&delimiter, 1);
  return true;
}
