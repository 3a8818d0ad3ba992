// Says R when ready; for two words of four bytes, low byte first, gives the board's clock at the first one's time.
#include "board.h"
#include "chip.h"

int main() {
  begin_serial();
  put('R');
  for (;;) {
    const uint32_t stamp = get_word();
    put('A');
    get_word();
    put_word(board::us_of(stamp));
  }
}
