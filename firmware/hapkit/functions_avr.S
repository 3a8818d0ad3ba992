// What functions.cpp takes most of its time for: products of fractions, one by one or in a series. In C++ they take
// four times as long. Arguments and results as the compiler passes them.
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

#endif
