// The machine on a PC, controlled on standard input by tests/laws/machine_pc.py.
//   'L' Shape, initial values, code: load and verify a law    -> refusal, cycles
//   'S' slot, number: write a slot
//   'R' count, rows of position and velocity: call the law    -> rows of force and state; total cycles by the table
#include <cstdio>
#include <cstring>
#include <vector>

#include "machine.h"

namespace {

using namespace machine;

uint32_t counted = 0;
Shape shape = {};

template <class T>
bool take(T* where, size_t count = 1) {
  return std::fread(where, sizeof(T), count, stdin) == count;
}

template <class T>
void give(const T* from, size_t count = 1) {
  std::fwrite(from, sizeof(T), count, stdout);
}

bool load() {
  if (!take(&shape.states) || !take(&shape.given) || !take(&shape.slots) || !take(&shape.code)) return false;
  static float numbers[256];
  static uint8_t bytes[65536];
  if (!take(numbers, shape.given) || !take(bytes, shape.code)) return false;
  uint32_t cycles = 0;
  Refusal refusal = Refusal::kTooLarge;
  if (fits(shape)) {
    std::memset(arena, 0, kArena);
    std::memcpy(slots() + kFirstGiven, numbers, shape.given * sizeof(float));
    std::memcpy(code(shape), bytes, shape.code);
    refusal = verify(shape, &cycles);
  }
  give(&refusal);
  give(&cycles);
  return true;
}

bool set() {
  uint8_t slot;
  float value;
  if (!take(&slot) || !take(&value) || slot >= shape.slots) return false;
  slots()[slot] = value;
  return true;
}

bool call() {
  uint32_t count;
  if (!take(&count)) return false;
  std::vector<float> rows(2 * count), answers;
  if (!take(rows.data(), rows.size())) return false;
  counted = 0;
  for (uint32_t k = 0; k < count; k++) {
    answers.push_back(run(rows[2 * k], rows[2 * k + 1]));
    answers.insert(answers.end(), slots() + kFirstGiven, slots() + kFirstGiven + shape.states);
  }
  give(answers.data(), answers.size());
  give(&counted);
  return true;
}

}  // namespace

void machine_count(uint8_t opcode) {
  counted += kTable[opcode < kMasked ? opcode : kSingle + ((opcode - kMasked) >> 4)].most;
}

int main() {
  for (int what; (what = std::getchar()) != EOF; std::fflush(stdout)) {
    const bool good = what == 'L' ? load() : what == 'S' ? set() : what == 'R' && call();
    if (!good) return 1;
  }
  return 0;
}
