// Says R when ready; for an integer and a float of four bytes, low byte first, answers with their product.
#include "times.h"
#include "chip.h"
#include "fast_bits.h"

int main() {
  begin_serial();
  put('R');
  for (;;) {
    const int32_t value = get_word();
    put('A');
    put_word(fast::bits(times(value, fast::number(get_word()))));
  }
}
