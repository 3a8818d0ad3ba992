// Says R when ready; for a float x and then a float that is 0, 1, 2 or 3, four bytes each, low byte first, answers
// with the sine of x turns, the cosine, e^x or e^(-18 x^2).
#include "chip.h"
#include "fast.h"

static float answer(float x, float which) {
  if (which == 0.0f) return fast::sin_of_turns(x);
  if (which == 1.0f) return fast::cos_of_turns(x);
  return which == 2.0f ? fast::exp(x) : fast::exp_of_square(-18.0f, x);
}

int main() {
  begin_serial();
  put('R');
  for (;;) {
    const float x = fast::number(get_word());
    put('A');
    put_word(fast::bits(answer(x, fast::number(get_word()))));
  }
}
