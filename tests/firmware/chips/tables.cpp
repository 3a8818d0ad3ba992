// Says R when ready; for a float x and then a float that is 0, 1, 2 or 3, four bytes each, low byte first, answers
// with the sine of x turns, the cosine, e^x or e^(-18 x^2).
#include "chip.h"
#include "fast.h"

static float read() {
  uint32_t bits = 0;
  for (uint8_t i = 0; i < 32; i += 8) bits |= static_cast<uint32_t>(get()) << i;
  return fast::number(bits);
}

static float answer(float x, float which) {
  if (which == 0.0f) return fast::sin_of_turns(x);
  if (which == 1.0f) return fast::cos_of_turns(x);
  return which == 2.0f ? fast::exp(x) : fast::exp_of_square(-18.0f, x);
}

int main() {
  begin_serial();
  put('R');
  for (;;) {
    const float x = read();
    put('A');
    const uint32_t bits = fast::bits(answer(x, read()));
    for (uint8_t i = 0; i < 32; i += 8) put(static_cast<uint8_t>(bits >> i));
  }
}
