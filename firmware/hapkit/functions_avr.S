// What functions.cpp is made of and takes its time for: products of fractions, one by one or in a series, and the ways
// from a float to whole numbers and back. In C++ they take two to four times as long and twice the room.
// Arguments and results as the compiler passes them.
#ifdef __AVR__

  .section .text.machine_series, "ax", @progbits

; uint32_t fraction(uint32_t a, uint32_t b): the bytes of the product that lie above the lowest three.
  .global _ZN9functions8fractionEmm
  .type _ZN9functions8fractionEmm, @function
_ZN9functions8fractionEmm:
  set
  rjmp 1f

; uint32_t series(uint32_t y, const uint32_t* table, uint8_t terms): t0 - y (t1 - y (t2 - ...)), the last one first.
  .global _ZN9functions6seriesEmPKmh
  .type _ZN9functions6seriesEmPKmh, @function
_ZN9functions6seriesEmPKmh:
  clt
  movw r30, r20
  mov r26, r18
  movw r18, r22
  movw r20, r24
  lpm r22, Z+
  lpm r23, Z+
  lpm r24, Z+
  lpm r25, Z+
  dec r26
1:push r14
  push r15
  push r16
  push r17
  clr r27
2:mul r25, r18        ; r17..r14 = r25..r22 times r21..r18
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
  brts 3f
  lpm r22, Z+
  lpm r23, Z+
  lpm r24, Z+
  lpm r25, Z+
  sub r22, r14
  sbc r23, r15
  sbc r24, r16
  sbc r25, r17
  dec r26
  brne 2b
  rjmp 4f
3:movw r22, r14
  movw r24, r16
4:clr r1
  pop r17
  pop r16
  pop r15
  pop r14
  ret

; uint32_t fixed(float x, int8_t up): x 2^up without what is behind the point, or above 32 bits.
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
  brlo 7f             ; below -31: nothing is left
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

; float times(float x, uint32_t f): x f / 2^31
  .global _ZN9functions5timesEfm
  .type _ZN9functions5timesEfm, @function
_ZN9functions5timesEfm:
  push r25
  rcall split
  push r26
  rcall _ZN9functions8fractionEmm
  pop r20
  clr r21
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
