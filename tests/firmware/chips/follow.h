// Asks sensor::count by two words. The first one is a reading, and 2^16 if it failed; or 2^17, and the second one is then
// a kit to begin anew with: counts per flip, the kind of its sensor at 2^16, and 2^24 if it counts to the left.
#pragma once

#include "sensor.h"

static uint32_t answer(uint32_t reading, uint32_t kit) {
  if (!(reading >> 17)) return sensor::count(reading, reading >> 16);
  protocol::Board board = protocol::Board();
  board.counts_per_flip = kit;
  board.sensor = static_cast<uint8_t>(kit >> 16);
  board.sense = kit >> 24 ? -1 : 1;
  sensor::start(board);
  return 0;
}
