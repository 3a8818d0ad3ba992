// Says R when ready; for two words of four bytes, low byte first, gives the answer of follow.h.
#include "chip.h"
#include "follow.h"

int main() {
  begin_serial();
  put('R');
  for (;;) {
    const uint32_t reading = get_word();
    put('A');
    put_word(answer(reading, get_word()));
  }
}
