// Runs the board's laws on a PC: jobs on standard input, forces and states on standard output.
// A job: law, whether each row brings its state, period, 16 parameters, rows; each row position, velocity
// and, where it does, the state before it. An answer: for each row the force and the state after it.
#include <stdint.h>
#include <stdio.h>

#include "laws/table.h"

namespace {

constexpr uint8_t kMost = 16;

bool take(void* where, size_t size) { return fread(where, 1, size, stdin) == size; }

void give(const float* values, size_t count) { fwrite(values, sizeof(float), count, stdout); }

bool job() {
  uint32_t head[3];
  float dt, p[kMost], s[kMost] = {};
  if (!take(head, sizeof head) || !take(&dt, sizeof dt) || !take(p, sizeof p)) return false;
  if (head[0] >= laws::kCount) return false;
  const laws::Law& law = laws::kTable[head[0]];
  // No law may read or write beyond what it declares: the sanitizers watch the ends of these.
  float* const own_p = new float[law.parameters];
  float* const own_s = new float[law.states];
  for (uint8_t i = 0; i < law.parameters; i++) own_p[i] = p[i];
  law.start(own_s);
  laws::current = false;
  for (uint32_t n = 0; n < head[2]; n++) {
    float row[2];
    if (!take(row, sizeof row) || (head[1] && !take(s, law.states * sizeof(float)))) return false;
    for (uint8_t i = 0; head[1] && i < law.states; i++) own_s[i] = s[i];
    const float force = law.force(own_p, own_s, row[0], row[1], dt);
    give(&force, 1);
    give(own_s, law.states);
  }
  delete[] own_p;
  delete[] own_s;
  return true;
}

}  // namespace

int main() {
  while (job()) {
  }
  return ferror(stdin) || !feof(stdin);
}
