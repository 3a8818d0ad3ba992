// The serial port of the Hapkit board.
#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "hardware.h"
#include "lock.h"
#include "protocol.h"
#include "ring.h"

namespace {

constexpr uint16_t kBaudDivisor = board::kCpu / 16 / protocol::kBaud - 1;
static_assert((kBaudDivisor + 1) * 16 * protocol::kBaud == board::kCpu, "this baud rate is not exact");

Ring<88> received;  // the settings of a kit arrive as one frame of 74 bytes
volatile uint8_t lost = 0;

// Frames are queued one after the other and sent up to `stop`, the low byte of an address. After all have
// been sent, the next frame is written at the beginning again.
uint8_t queue[board::kQueue];
uint8_t* volatile from = queue;
volatile uint8_t stop;
uint8_t* end = queue;  // used only by the main program

constexpr uint8_t kQuiet = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
constexpr uint8_t kSending = kQuiet | _BV(TXCIE0);

inline uint8_t low(const uint8_t* place) { return static_cast<uint8_t>(reinterpret_cast<uint16_t>(place)); }

inline bool all_sent() { return low(from) == stop; }

}  // namespace

// Store the byte in the ring and end the sleep. Count damaged bytes, and bytes for which there is no room.
ISR(USART_RX_vect) {
  const uint8_t status = UCSR0A;
  if (status & (_BV(FE0) | _BV(DOR0))) lost = lost + 1;
  if (!received.push(UDR0)) lost = lost + 1;
  SMCR = 0;
}

// The shift register and its buffer are empty, so send two bytes. With the last bytes, this interrupt is
// disabled; its flag is set again after they are sent, and starts the next frame. Two bytes are sent every
// 352 cycles, so this is written in assembler: it takes 40 cycles, the compiler's code 83. Three reserved
// registers make pushes unnecessary, and no instruction changes the status register. The second byte must
// wait until the first one has left the buffer, up to the time of a bit, 16 cycles; the instructions in
// between take this time.
ISR(USART_TX_vect, ISR_NAKED) {
  __asm__ volatile(
      "out %[keep0], r30\n\t"
      "out %[keep1], r31\n\t"
      "out %[keep2], r24\n\t"
      "lds r30, %[from]\n\t"
      "lds r31, %[from]+1\n\t"
      "ld r24, Z+\n\t"
      "sts %[data], r24\n\t"
      "lds r24, %[stop]\n\t"
      "cpse r30, r24\n\t"
      "rjmp 1f\n\t"
      "sts %[from], r30\n\t"
      "ldi r24, %[quiet]\n\t"
      "sts %[control], r24\n\t"
      "rjmp 3f\n"
      "1:\tld r24, Z+\n\t"
      "sts %[from], r30\n\t"
      "sts %[from]+1, r31\n\t"
      "lds r31, %[stop]\n\t"
      "cpse r30, r31\n\t"
      "rjmp 2f\n\t"
      "ldi r31, %[quiet]\n\t"
      "sts %[control], r31\n"
      "2:\tlds r31, %[status]\n\t"
      "sbrs r31, %[empty]\n\t"
      "rjmp 2b\n\t"
      "sts %[data], r24\n"
      "3:\tin r24, %[keep2]\n\t"
      "in r31, %[keep1]\n\t"
      "in r30, %[keep0]\n\t"
      "reti"
      :
      : [keep0] "I"(_SFR_IO_ADDR(GPIOR0)), [keep1] "I"(_SFR_IO_ADDR(GPIOR1)), [keep2] "I"(_SFR_IO_ADDR(GPIOR2)),
        [data] "i"(_SFR_MEM_ADDR(UDR0)), [control] "i"(_SFR_MEM_ADDR(UCSR0B)),
        [status] "i"(_SFR_MEM_ADDR(UCSR0A)), [empty] "I"(UDRE0), [quiet] "M"(int{kQuiet}), [from] "i"(&from),
        [stop] "i"(&stop));
}

void hardware::begin_serial() {
  UBRR0 = kBaudDivisor;
  UCSR0A = _BV(TXC0);
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = kQuiet;
  stop = low(from);
  UDR0 = 0;  // the first delimiter: after it is sent, its flag starts the next byte
}

bool board::read(uint8_t* byte) { return received.pop(byte); }

uint8_t* board::room_for(uint8_t size) {
  if (all_sent()) end = queue;
  return queue + kQueue - end < size ? nullptr : end;
}

// If all earlier bytes have been sent, sending continues with this frame, which may be at the beginning of the
// queue.
void board::send(uint8_t* filled) {
  const Lock lock;
  if (all_sent()) from = end;
  end = filled;
  stop = low(filled);
  UCSR0B = kSending;
}

// Every event for the main program withdraws the permission to sleep.
void board::may_sleep() { SMCR = _BV(SE); }

void board::wake() { SMCR = 0; }

void board::sleep() {
  if (!received.empty()) return;
  uint8_t mode;
  __asm__ volatile(
      "1:\tsleep\n\t"
      "in %[mode], %[control]\n\t"
      "sbrc %[mode], %[enabled]\n\t"
      "rjmp 1b"
      : [mode] "=r"(mode)
      : [control] "I"(_SFR_IO_ADDR(SMCR)), [enabled] "I"(SE)
      : "memory");
}

uint8_t board::lost_bytes() { return lost; }

#endif
