// Serial port of the Hapkit board.
#ifdef __AVR__
#pragma GCC optimize("O2")  // also for what is included

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#include "board.h"
#include "hardware.h"
#include "lock.h"
#include "protocol.h"
#include "ring.h"

namespace {

constexpr uint32_t kCpu = 16000000;
constexpr uint16_t kBaudDivisor = kCpu / 16 / protocol::kBaud - 1;
static_assert((kBaudDivisor + 1) * 16 * protocol::kBaud == kCpu, "this baud rate is not exact");

Ring<128> received;  // a loop and its scene come in one piece, 91 bytes
Ring<board::kQueue + 1> to_send;
volatile uint8_t lost = 0;

}  // namespace

// A byte comes every 160 cycles and one goes every 160 cycles, so these two are in assembler: 47 and 37 cycles,
// where the compiler takes 66 and 54. Three registers that nothing else uses keep what others would push;
// interrupts stay off, so the two are never in each other's way.
#define KEEP "out %[keep0], r30\n\tout %[keep1], r31\n\tin r30, __SREG__\n\tout %[keep2], r30\n\t"
#define BACK "in r30, %[keep2]\n\tout __SREG__, r30\n\tin r30, %[keep0]\n\tin r31, %[keep1]\n\treti\n\t"
#define KEPT \
  [keep0] "I"(_SFR_IO_ADDR(GPIOR0)), [keep1] "I"(_SFR_IO_ADDR(GPIOR1)), [keep2] "I"(_SFR_IO_ADDR(GPIOR2))

// Put the byte into the ring. A damaged one, or one for which there is no room, is counted.
ISR(USART_RX_vect, ISR_NAKED) {
  __asm__ volatile(
      KEEP
      "push r24\n\t"
      "lds r31, %[status]\n\t"
      "lds r24, %[data]\n\t"
      "andi r31, %[damage]\n\t"
      "brne 2f\n"
      "1:\tlds r30, %[ring]+%[head]\n\t"
      "inc r30\n\t"
      "andi r30, %[mask]\n\t"
      "lds r31, %[ring]+%[tail]\n\t"
      "cp r30, r31\n\t"
      "breq 3f\n\t"
      "sts %[ring]+%[head], r30\n\t"
      "clr r31\n\t"
      "subi r30, lo8(-(%[ring]))\n\t"
      "sbci r31, hi8(-(%[ring]))\n\t"
      "st Z, r24\n\t"
      "pop r24\n\t"
      BACK
      "3:\tpop r24\n\t"
      "lds r30, %[lost]\n\t"
      "inc r30\n\t"
      "sts %[lost], r30\n\t"
      BACK
      "2:\tlds r30, %[lost]\n\t"
      "inc r30\n\t"
      "sts %[lost], r30\n\t"
      "rjmp 1b"
      :
      : KEPT, [status] "i"(_SFR_MEM_ADDR(UCSR0A)), [data] "i"(_SFR_MEM_ADDR(UDR0)),
        [damage] "M"(_BV(FE0) | _BV(DOR0)), [ring] "i"(&received), [head] "M"(received.kHead),
        [tail] "M"(received.kTail), [mask] "M"(received.kMask), [lost] "i"(&lost));
}

// Send the next byte; the last one of the ring switches this interrupt off.
ISR(USART_UDRE_vect, ISR_NAKED) {
  __asm__ volatile(
      KEEP
      "lds r30, %[ring]+%[tail]\n\t"
      "inc r30\n\t"
      "andi r30, %[mask]\n\t"
      "sts %[ring]+%[tail], r30\n\t"
      "lds r31, %[ring]+%[head]\n\t"
      "cp r30, r31\n\t"
      "breq 2f\n"
      "1:\tclr r31\n\t"
      "subi r30, lo8(-(%[ring]))\n\t"
      "sbci r31, hi8(-(%[ring]))\n\t"
      "ld r30, Z\n\t"
      "sts %[data], r30\n\t"
      BACK
      "2:\tlds r31, %[control]\n\t"
      "andi r31, %[quiet]\n\t"
      "sts %[control], r31\n\t"
      "rjmp 1b"
      :
      : KEPT, [data] "i"(_SFR_MEM_ADDR(UDR0)), [control] "i"(_SFR_MEM_ADDR(UCSR0B)),
        [quiet] "M"(0xff ^ _BV(UDRIE0)), [ring] "i"(&to_send), [head] "M"(to_send.kHead),
        [tail] "M"(to_send.kTail), [mask] "M"(to_send.kMask));
}

void hardware::begin_serial() {
  UBRR0 = kBaudDivisor;
  UCSR0A = 0;
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
  set_sleep_mode(SLEEP_MODE_IDLE);
  sleep_enable();
}

bool board::read(uint8_t* byte) { return received.pop(byte); }

uint8_t board::room() { return to_send.room(); }

// Frame::Writer in one pass, and 29 cycles a byte. Where the body ends, the CRC's high byte is taken as the next
// one; that moves its low byte up, which is the one after.
void board::send_frame(uint8_t id, const void* payload, uint8_t size, uint8_t more) {
  uint8_t high = 0xff, low = 0xff, left = size + 1, parts = 2, count = 1, mix, after;
  uint16_t code;
  __asm__ volatile(
      "lds r26, %[ring]+%[head]\n\t"
      "inc r26\n\t"
      "andi r26, %[mask]\n\t"
      "clr r27\n\t"
      "subi r26, lo8(-(%[ring]))\n\t"
      "sbci r27, hi8(-(%[ring]))\n\t"
      "movw %[code], r26\n\t"
      "rcall 7f\n\t"
      "rjmp 2f\n"
      "1:\tld %[id], Z+\n"
      "2:\teor %[high], %[id]\n\t"
      "mov %[mix], %[high]\n\t"
      "swap %[mix]\n\t"
      "andi %[mix], 15\n\t"
      "eor %[high], %[mix]\n\t"
      "mov %[mix], %[high]\n\t"
      "swap %[mix]\n\t"
      "andi %[mix], 240\n\t"
      "eor %[low], %[mix]\n\t"
      "lsl %[mix]\n\t"
      "eor %[mix], %[high]\n\t"
      "lsr %[high]\n\t"
      "lsr %[high]\n\t"
      "lsr %[high]\n\t"
      "eor %[high], %[low]\n\t"
      "mov %[low], %[mix]\n\t"
      "tst %[id]\n\t"
      "breq 4f\n\t"
      "st X+, %[id]\n\t"
      "inc %[count]\n\t"
      "cpi r26, lo8(%[ring]+%[head])\n\t"
      "breq 5f\n"
      "3:\tdec %[left]\n\t"
      "brne 1b\n\t"
      "inc %[left]\n\t"
      "mov %[id], %[high]\n\t"
      "dec %[parts]\n\t"
      "brpl 2b\n\t"
      "rcall 6f\n\t"
      "rjmp 9f\n"
      "4:\trcall 6f\n\t"
      "movw %[code], r26\n\t"
      "ldi %[count], 1\n\t"
      "rcall 7f\n\t"
      "rjmp 3b\n"
      "5:\trcall 8f\n\t"
      "rjmp 3b\n"
      "6:\tmov %[mix], r26\n\t"  // the block's code
      "mov %[after], r27\n\t"
      "movw r26, %[code]\n\t"
      "st X, %[count]\n\t"
      "mov r26, %[mix]\n\t"
      "mov r27, %[after]\n\t"
      "ret\n"
      "7:\tadiw r26, 1\n\t"  // the next place
      "cpi r26, lo8(%[ring]+%[head])\n\t"
      "brne 10f\n"
      "8:\tldi r26, lo8(%[ring])\n\t"
      "ldi r27, hi8(%[ring])\n"
      "10:\tret\n"
      "11:\trcall 7b\n"
      "9:\tst X, __zero_reg__\n\t"
      "dec %[more]\n\t"
      "brpl 11b\n\t"
      "subi r26, lo8(%[ring])\n\t"
      "sts %[ring]+%[head], r26"
      : [id] "+&r"(id), [high] "+&r"(high), [low] "+&r"(low), [left] "+&r"(left), [parts] "+&r"(parts),
        [count] "+&d"(count), [more] "+&r"(more), [mix] "=&d"(mix), [after] "=&r"(after), [code] "=&r"(code),
        "+&z"(payload)
      : [ring] "i"(&to_send), [head] "M"(to_send.kHead), [mask] "M"(to_send.kMask)
      : "r26", "r27", "memory");
  const Lock lock;  // the interrupt changes this register too
  // A tick in between may have let all of it go; the interrupt sends without a look whether anything is left.
  if (!to_send.empty()) UCSR0B |= _BV(UDRIE0);
}

// Interrupts come on again with the instruction before the sleep, so none is missed between look and sleep.
void board::sleep_unless(const volatile bool& due) {
  const uint8_t read = received.read();
  for (;;) {
    cli();
    if (due || received.written() != read) break;
    sei();
    sleep_cpu();
  }
  sei();
}

uint8_t board::lost_bytes() { return lost; }

#endif
