// board::us_of in a third of the time that the compiler takes.
#ifdef __AVR__

#define QUARTER 250  // us

  .section .bss.us_of, "aw", @nobits
known_us: .skip 4        ; the clock at a beginning of a period
known_quarters: .skip 2

  .section .text.us_of, "ax", @progbits

; uint32_t board::us_of(uint32_t stamp): less than 8 s away from the last one
  .global board_us_of
  .type board_us_of, @function
board_us_of:
  lds r20, known_quarters
  lds r21, known_quarters + 1
  sts known_quarters, r24
  sts known_quarters + 1, r25
  sub r24, r20
  sbc r25, r21
  mov r21, r25
  ldi r20, QUARTER
  mulsu r21, r20
  movw r18, r0        ; r25:r19:r18 and a byte below: what the high byte makes
  lsl r1
  sbc r25, r25
  mul r24, r20
  mov r20, r0
  mov r21, r1
  clr r1
  add r21, r18
  adc r19, r1
  adc r25, r1
  lds r24, known_us
  add r20, r24
  lds r24, known_us + 1
  adc r21, r24
  lds r24, known_us + 2
  adc r24, r19
  lds r18, known_us + 3
  adc r25, r18
  sts known_us, r20
  sts known_us + 1, r21
  sts known_us + 2, r24
  sts known_us + 3, r25
  lsr r23             ; two ticks of the timer in a microsecond
  ror r22
  add r22, r20
  adc r23, r21
  adc r24, r1
  adc r25, r1
  ret

#endif
