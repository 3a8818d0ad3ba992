// Fuzz target: the machine's verifier, and the machine running code that passed it.
//
// An input consists of the shape (3 bytes), the initial values (one byte each) and the code. Verified code is
// run: it must leave code and constants unchanged, and take at most the number of cycles that the verifier
// computed.

#include "machine.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "check.h"

namespace {

using namespace machine;

uint32_t counted = 0, bound = 0;

float number(uint8_t byte) {
  constexpr float kOdd[] = {0.0f, -0.0f, 1e-40f, 1.1754944e-38f, 3.4e38f, -3.4e38f, 1e-20f, 1e20f};
  return byte < 8 ? kOdd[byte] : static_cast<float>(byte - 128) / 16.0f;
}

constexpr float kRows[][2] = {{0.0f, 0.0f},    {0.01f, -0.2f}, {-0.03f, 1.5f},   {1.0f, 3.0f},
                              {-4.0f, 1e-30f}, {NAN, 0.0f},    {INFINITY, NAN},  {-1e30f, -INFINITY}};

}  // namespace

void machine_count(uint8_t opcode) {
  counted += kTable[opcode < kMasked ? opcode : kSingle + (opcode - kMasked) / kMasks].most;
  CHECK(counted <= bound);
}

void check::fail(const char* file, int line, const char* what) {
  std::fprintf(stderr, "%s:%d: %s\n", file, line, what);
  std::abort();
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const uint8_t states = data[0] % 8, given = states + data[1] % 8, slots = kFirstGiven + given + data[2] % 8;
  data += 3;
  size -= 3;
  if (size < given) return 0;
  const Shape shape{states, given, slots, static_cast<uint16_t>(size - given)};
  if (!fits(shape)) return 0;
  std::memset(arena, 0x55, kArena);
  std::memset(machine::slots(), 0, sizeof(float) * slots);
  for (uint8_t i = 0; i < given; i++) machine::slots()[kFirstGiven + i] = number(data[i]);
  std::copy(data + given, data + size, code(shape));
  uint32_t cycles = 0;
  if (verify(shape, &cycles) != Refusal::kNone) return 0;
  bound = cycles;
  const uint8_t* const constants = arena + sizeof(float) * (kFirstGiven + states);
  const uint8_t* const others = arena + sizeof(float) * (kFirstGiven + given);
  const std::vector<uint8_t> kept(constants, others), rest(code(shape), arena + kArena);
  for (const auto& row : kRows) {
    counted = 0;
    run(row[0], row[1]);
    CHECK(std::equal(kept.begin(), kept.end(), constants));
    CHECK(std::equal(rest.begin(), rest.end(), code(shape)));
    CHECK(std::memcmp(machine::slots(), row, sizeof row) == 0);
  }
  return 0;
}
