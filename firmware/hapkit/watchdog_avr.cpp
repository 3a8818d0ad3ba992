// The hardware watchdog, and the cause of the last reset.
#ifdef __AVR__

#include <avr/io.h>
#include <avr/wdt.h>

#include "board.h"
#include "hardware.h"

namespace {

uint8_t cause __attribute__((section(".noinit")));

constexpr uint8_t kCauses = _BV(PORF) | _BV(EXTRF) | _BV(BORF) | _BV(WDRF);

}  // namespace

// Boot loaders clear the register that contains the cause; optiboot from 4.6 on passes the cause in r2, which
// is unused so far.
extern "C" void __attribute__((naked, used, section(".init0"))) keep_cause() {
  __asm__ volatile("sts %0, r2" : : "i"(&cause));
}

// After a watchdog reset the watchdog is still on, with its shortest time.
extern "C" void __attribute__((naked, used, section(".init3"))) stop_watchdog() {
  if (MCUSR) cause = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

void hardware::begin_watchdog() { wdt_enable(WDTO_15MS); }

void board::pat() { wdt_reset(); }

uint8_t board::reset_cause() { return cause & ~kCauses ? 0 : cause; }

#endif
