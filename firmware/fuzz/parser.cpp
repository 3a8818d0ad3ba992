// The firmware's parser as functions that Python calls by ctypes.

#include <cstddef>
#include <cstring>

#include "frame.h"

// Feed a line of n bytes. Write each valid body, after its length, to out, which has room for as many bytes
// as the line. Return the number of bytes written; bad receives the number of invalid frames.
extern "C" std::size_t parse(const uint8_t* line, std::size_t n, uint8_t* out, uint32_t* bad) {
  frame::Parser parser;
  std::size_t end = 0;
  uint8_t before = 0;
  *bad = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const uint8_t size = parser.push(line[k]);
    *bad += static_cast<uint8_t>(parser.bad_frames() - before);
    before = parser.bad_frames();
    if (!size) continue;
    out[end++] = size;
    std::memcpy(out + end, parser.body(), size);
    end += size;
  }
  return end;
}

// Parse random lines of n bytes that are valid COBS; return how many pass the CRC by chance.
extern "C" uint64_t parse_noise(uint64_t count, std::size_t n, uint64_t seed) {
  frame::Parser parser;
  uint64_t accepted = 0;
  uint8_t coded[256];
  const auto draw = [&seed] {
    seed = seed * 6364136223846793005u + 1442695040888963407u;  // Knuth, MMIX
    return static_cast<uint32_t>(seed >> 40);
  };
  for (; count; --count) {
    for (std::size_t k = 0; k < n; ++k) coded[k] = 1 + draw() % 255;
    for (std::size_t at = 0; at < n; at += coded[at]) coded[at] = 1 + draw() % (n - at);
    for (std::size_t k = 0; k < n; ++k) parser.push(coded[k]);
    accepted += parser.push(0) != 0;
  }
  return accepted;
}
