// The basic and slow functions of functions.cpp: products of fractions, singly or in a series, and conversions
// between floats and integers. In C++ they take two to four times as long and twice the memory.
// Arguments and results are in the compiler's registers.
#ifdef __AVR__

  .section .text.machine_series, "ax", @progbits

; uint32_t fraction(uint32_t a, uint32_t b): the bytes of the product above the lowest three.
  .global _ZN9functions8fractionEmm
  .type _ZN9functions8fractionEmm, @function
_ZN9functions8fractionEmm:
  mul r22, r21        ; r31 r30 r27 r26 = the product
  mov r26, r1
  clr r27
  clr r22             ; 0 from here on
  mul r25, r18
  add r26, r1
  adc r27, r22
  mul r24, r19
  add r26, r1
  adc r27, r22
  mul r23, r20
  add r26, r1
  adc r27, r22
  mul r25, r21
  movw r30, r0
  mul r24, r20
  add r26, r0
  adc r27, r1
  adc r30, r22
  adc r31, r22
  mul r25, r19
  add r26, r0
  adc r27, r1
  adc r30, r22
  adc r31, r22
  mul r23, r21
  add r26, r0
  adc r27, r1
  adc r30, r22
  adc r31, r22
  mul r25, r20
  add r27, r0
  adc r30, r1
  adc r31, r22
  mul r24, r21
  add r27, r0
  adc r30, r1
  adc r31, r22
  movw r22, r26
  movw r24, r30
  clr r1
  ret

; uint32_t series(uint32_t y, const uint32_t* table, uint8_t terms): t0 - y (t1 - y (t2 - ...)), last coefficient first.
  .global _ZN9functions6seriesEmPKmh
  .type _ZN9functions6seriesEmPKmh, @function
_ZN9functions6seriesEmPKmh:
  movw r30, r20
  mov r26, r18
  movw r18, r22
  movw r20, r24
  lpm r22, Z+
  lpm r23, Z+
  lpm r24, Z+
  lpm r25, Z+
  dec r26
  push r14
  push r15
  push r16
  push r17
  clr r27
1:mul r25, r18        ; r17..r14 = r25..r22 times r21..r18, as above
  mov r14, r1
  clr r15
  mul r24, r19
  add r14, r1
  adc r15, r27
  mul r23, r20
  add r14, r1
  adc r15, r27
  mul r22, r21
  add r14, r1
  adc r15, r27
  mul r25, r21
  movw r16, r0
  mul r24, r20
  add r14, r0
  adc r15, r1
  adc r16, r27
  adc r17, r27
  mul r25, r19
  add r14, r0
  adc r15, r1
  adc r16, r27
  adc r17, r27
  mul r23, r21
  add r14, r0
  adc r15, r1
  adc r16, r27
  adc r17, r27
  mul r25, r20
  add r15, r0
  adc r16, r1
  adc r17, r27
  mul r24, r21
  add r15, r0
  adc r16, r1
  adc r17, r27
  lpm r22, Z+
  lpm r23, Z+
  lpm r24, Z+
  lpm r25, Z+
  sub r22, r14
  sbc r23, r15
  sbc r24, r16
  sbc r25, r17
  dec r26
  brne 1b
  clr r1
  pop r17
  pop r16
  pop r15
  pop r14
  ret

; uint32_t fixed(float x, int8_t up): the lower 32 bits of x 2^up, truncated.
  .global _ZN9functions5fixedEfa
  .type _ZN9functions5fixedEfa, @function
_ZN9functions5fixedEfa:
  bst r25, 7
  rcall split
  clr r21
  sbrc r20, 7
  com r21
  add r20, r26
  adc r21, r1
  subi r20, 127 + 31
  sbci r21, 0
  rcall _ZN9functions5movedEmi
  brtc 1f
negated:
  com r25
  com r24
  com r23
  neg r22
  sbci r23, 0xff
  sbci r24, 0xff
  sbci r25, 0xff
1:ret

; r25..r22 = the mantissa of a float in 2^-31, r26 = its exponent.
split:
  mov r26, r24
  lsl r26
  mov r26, r25
  rol r26
  mov r25, r24
  ori r25, 0x80
  mov r24, r23
  mov r23, r22
  clr r22
  ret

; uint32_t moved(uint32_t m, int16_t up): m 2^up
  .global _ZN9functions5movedEmi
  .type _ZN9functions5movedEmi, @function
_ZN9functions5movedEmi:
  tst r21
  breq 4f
  cpi r20, -31
  brlo 7f             ; below -31: 0
  cpi r21, 0xff
  brne 7f
1:cpi r20, -7
  brge 2f
  mov r22, r23
  mov r23, r24
  mov r24, r25
  clr r25
  subi r20, -8
  rjmp 1b
2:tst r20
  breq 6f
3:lsr r25
  ror r24
  ror r23
  ror r22
  inc r20
  brne 3b
  ret
4:cpi r20, 32
  brsh 7f
5:cpi r20, 8
  brlo 8f
  mov r25, r24
  mov r24, r23
  mov r23, r22
  clr r22
  subi r20, 8
  rjmp 5b
9:lsl r22
  rol r23
  rol r24
  rol r25
8:subi r20, 1
  brcc 9b
6:ret
7:clr r25
  clr r24
  movw r22, r24
  ret

; r25..r22 = |x| times the fraction r21..r18, in 2^-31 2^(r20 - 127).
scaled:
  rcall split
  push r26
  rcall _ZN9functions8fractionEmm
  pop r20
  clr r21
  ret

; uint32_t phase_of(float x)
  .global _ZN9functions8phase_ofEf
  .type _ZN9functions8phase_ofEf, @function
_ZN9functions8phase_ofEf:
  push r25
  ldi r18, 0x6e       ; 2 / pi
  ldi r19, 0x83
  ldi r20, 0xf9
  ldi r21, 0xa2
  rcall scaled
  subi r20, 127 + 1
  sbc r21, r21
  rcall _ZN9functions5movedEmi
  pop r26
  sbrc r26, 7
  rjmp negated
  ret

; float sine_of(uint32_t phase)
  .global _ZN9functions7sine_ofEm
  .type _ZN9functions7sine_ofEm, @function
_ZN9functions7sine_ofEm:
  push r25
  sbrs r25, 6
  rjmp 1f
  com r25
  com r24
  com r23
  com r22
1:ldi r26, 2
2:lsl r22
  rol r23
  rol r24
  rol r25
  dec r26
  brne 2b
  push r22
  push r23
  push r24
  push r25
  movw r18, r22
  movw r20, r24
  rcall _ZN9functions8fractionEmm
  ldi r20, lo8(_ZN9functions5kSineE)
  ldi r21, hi8(_ZN9functions5kSineE)
  ldi r18, 5
  rcall _ZN9functions6seriesEmPKmh
  pop r21
  pop r20
  pop r19
  pop r18
  rcall _ZN9functions8fractionEmm
  pop r18
  ldi r20, 127
  clr r21
  rjmp _ZN9functions9assembledEmih

; float exp_times(float x, int8_t more): e^x 2^more
  .global _ZN9functions9exp_timesEfa
  .type _ZN9functions9exp_timesEfa, @function
_ZN9functions9exp_timesEfa:
  mov r26, r24
  lsl r26
  mov r26, r25
  rol r26
  cpi r26, 127 + 7
  brsh 4f
  push r20
  push r25
  ldi r18, 0x29       ; log2(e) / 2
  ldi r19, 0x3b
  ldi r20, 0xaa
  ldi r21, 0xb8
  rcall scaled
  subi r20, 127 + 6
  sbc r21, r21
  rcall _ZN9functions5movedEmi
  mov r27, r25        ; integer part, and fraction, rounded
  mov r25, r24
  mov r24, r23
  mov r23, r22
  ldi r22, 128
  ldi r20, 127
  clr r21
  pop r26
  sbrc r26, 7
  rjmp 2f
  rcall negated
  sec
  adc r20, r27
  adc r21, r1
  rjmp 3f
2:sub r20, r27
  sbc r21, r1
3:pop r26
  add r20, r26
  adc r21, r1
  sbrc r26, 7
  dec r21
  push r20
  push r21
  ldi r20, lo8(_ZN9functions6kPowerE)
  ldi r21, hi8(_ZN9functions6kPowerE)
  ldi r18, 7
  rcall _ZN9functions6seriesEmPKmh
  pop r21
  pop r20
  clr r18
  rjmp _ZN9functions9assembledEmih
4:mov r26, r24        ; NaN stays NaN; otherwise infinite, or 0
  lsl r26
  brcc 5f
  or r26, r23
  or r26, r22
  breq 5f
  mov r26, r25
  lsl r26
  cpi r26, 0xfe
  breq 6f
5:mov r26, r25
  clr r22
  clr r23
  ldi r24, 0x80
  ldi r25, 0x7f
  sbrs r26, 7
6:ret
  clr r24
  clr r25
  ret

; Division divided(float a, float b): quotient in r21..r18, remainder in r25..r22
  .global _ZN9functions7dividedEff
  .type _ZN9functions7dividedEff, @function
_ZN9functions7dividedEff:
  mov r26, r24
  lsl r26
  mov r26, r25
  rol r26
  mov r27, r20
  lsl r27
  mov r27, r21
  rol r27
  cpi r26, 0xff
  breq 7f
  cpi r27, 0xff
  breq 6f
  mov r30, r26
  sub r30, r27
  brlo 5f
  cpi r30, 24
  brsh 8f
  push r25
  rcall split         ; compare r25 r24 r23 with r20 r19 r18; inverted quotient bits go to r31 r21 r22
  ori r20, 0x80
  ldi r22, 0xff
  ldi r21, 0xff
  ldi r31, 0xff
1:cp r23, r18
  cpc r24, r19
  cpc r25, r20
  brlo 3f
2:sub r23, r18
  sbc r24, r19
  sbc r25, r20
  clc
3:rol r22
  rol r21
  rol r31
  dec r30
  brmi 4f
  lsl r23
  rol r24
  rol r25
  brcc 1b
  rjmp 2b
4:com r22
  com r21
  com r31
  pop r18
  push r31
  push r21
  push r22
  clr r22
  mov r20, r27
  clr r21
  rcall _ZN9functions9assembledEmih
  pop r18
  pop r19
  pop r20
  clr r21
  ret
6:lsl r20             ; divisor infinite or NaN
  or r20, r19
  or r20, r18
  brne 7f
5:clr r18             ; the dividend is the remainder
  clr r19
  movw r20, r18
  ret
7:ldi r24, 0xc0
  ldi r25, 0x7f
  rjmp 5b
8:ldi r18, 0xff
  ldi r19, 0xff
  movw r20, r18
  mov r26, r25
  clr r22
  clr r23
  clr r24
  ldi r25, 0
  bst r26, 7
  bld r25, 7
  ret

; float times(float x, uint32_t f): x f / 2^31
  .global _ZN9functions5timesEfm
  .type _ZN9functions5timesEfm, @function
_ZN9functions5timesEfm:
  push r25
  rcall scaled
  subi r20, -1
  pop r18

; float assembled(uint32_t m, int16_t e, uint8_t sign): m / 2^31 * 2^(e - 127), rounded.
  .global _ZN9functions9assembledEmih
  .type _ZN9functions9assembledEmih, @function
_ZN9functions9assembledEmih:
  bst r18, 7
  ldi r26, 4
1:tst r25
  brne 3f
  mov r25, r24
  mov r24, r23
  mov r23, r22
  clr r22
  subi r20, 8
  sbci r21, 0
  dec r26
  brne 1b
  clr r20             ; zero
  rjmp 6f
2:subi r20, 1
  sbci r21, 0
  lsl r22
  rol r23
  rol r24
  rol r25
3:brpl 2b
  tst r21
  brmi 5f
  brne 7f
  tst r20
  breq 5f
  cpi r20, 0xff
  breq 7f
  lsl r22
  adc r23, r1
  adc r24, r1
  adc r25, r1
  brcc 4f
  inc r20
4:lsl r25
  lsr r20
  ror r25
6:mov r22, r23
  mov r23, r24
  mov r24, r25
  mov r25, r20
  bld r25, 7
  ret
5:clr r20
  rjmp 8f
7:ldi r20, 0x7f
8:clr r24
  clr r23
  ldi r25, 0
  sbrc r20, 0
  ldi r25, 0x80
  rjmp 6b

#endif
