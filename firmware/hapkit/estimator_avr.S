// Estimator::step in half of the time that the compiler takes.
#ifdef __AVR__

#define SECOND 0   // places in a Design; in an Estimator come last count, what is left, speed
#define FIRST 4
#define FASTEST 8

; r0:r25:r24:r19 = r23..r20 times twice the half coefficient, within two units; without its last byte. T: large.
.macro share coefficient
  ldd r16, Z + \coefficient + 1
  mulsu r22, r16
  movw r18, r0        ; r25:r24:r19:r18 = 256ths
  sbc r24, r24
  mov r25, r24
  ldd r16, Z + \coefficient + 2
  mulsu r22, r16
  sbc r25, r17
  add r19, r0
  adc r24, r1
  adc r25, r17
  mul r21, r16
  add r18, r0
  adc r19, r1
  adc r24, r17
  adc r25, r17
  mul r20, r16
  add r18, r1
  adc r19, r17
  adc r24, r17
  adc r25, r17
  ldd r16, Z + \coefficient + 3
  mulsu r22, r16
  add r24, r0
  adc r25, r1
  mul r21, r16
  add r19, r0
  adc r24, r1
  adc r25, r17
  mul r20, r16
  add r18, r0
  adc r19, r1
  adc r24, r17
  adc r25, r17
  lsl r18
  rol r19
  rol r24
  rol r25
  brts .Llarge\coefficient
  lsl r18             ; round
  adc r19, r17
  adc r24, r17
  adc r25, r17
  mov r0, r25
  lsl r0
  sbc r0, r0
.Ldone\coefficient:
.endm

  .section .text.estimator_step, "ax", @progbits
  .global estimator_step
  .type estimator_step, @function

.Ljumped:
  ldi r24, 8
6:st X+, r1
  dec r24
  brne 6b
  ret

; An Estimator at r25:r24, a Design at r23:r22, the count in r21..r18. In r24 whether the handle is within its limit.
estimator_step:
  movw r26, r24
  movw r30, r22
  ld r0, X
  st X+, r18
  sub r18, r0
  ld r0, X
  st X+, r19
  sbc r19, r0
  ld r0, X
  st X+, r20
  sbc r20, r0
  ld r0, X
  st X+, r21
  sbc r21, r0
  movw r24, r18       ; steps: 12 bits and the sign
  mov r22, r19
  subi r22, 0xf0
  cpi r22, 0x20
  brsh .Ljumped
  lsl r19
  sbc r19, r19
  cp r20, r19
  cpc r21, r19
  brne .Ljumped
  push r16
  push r17
  ld r20, X+          ; r23..r20 = steps - speed + what is left
  ld r21, X+
  ld r22, X+
  ld r23, X+
  ld r0, X+
  sub r20, r0
  ld r0, X+
  sbc r21, r0
  ld r0, X+
  sbc r22, r0
  ld r0, X+
  sbc r23, r0
  add r22, r24
  adc r23, r25
  sbiw r26, 8
  clr r17
  clt
  movw r24, r22       ; beyond 64 counts the last byte is not worth while
  subi r24, 0xc0
  sbci r25, 0xff
  cpi r24, 0x80
  cpc r25, r17
  brlo 1f
  set
  st X, r20
  rcall .Lnarrow
1:share FIRST
  brtc 2f
  mov r22, r21
  mov r21, r20
  ld r20, X
2:mov r1, r20
  sub r1, r19
  st X+, r1
  mov r1, r21
  sbc r1, r24
  st X+, r1
  mov r1, r22
  sbc r1, r25
  st X+, r1
  mov r1, r23
  sbc r1, r0
  st X+, r1
  brtc 3f
  rcall .Lnarrow
  rjmp 3f
.Llarge4:
  rcall .Lwiden
  rjmp .Ldone4
3:share SECOND
  ld r1, X
  add r1, r19
  st X+, r1
  ld r1, X
  adc r1, r24
  st X+, r1
  ld r20, X
  adc r20, r25
  st X+, r20
  ld r21, X
  adc r21, r0
  st X, r21
  clr r1
  pop r17
  pop r16
  ldd r18, Z + FASTEST
  ldd r19, Z + FASTEST + 1
  ldi r24, 1
  cp r20, r18         ; whole counts
  cpc r21, r19
  brge 4f
  add r20, r18
  adc r21, r19
  brpl 5f
4:clr r24
5:ret
.Llarge0:
  rcall .Lwiden
  rjmp .Ldone0
.Lwiden:
  mov r0, r25
  mov r25, r24
  mov r24, r19
  mov r19, r18
  ret
.Lnarrow:
  mov r20, r21
  mov r21, r22
  mov r22, r23
  ret
  .size estimator_step, .-estimator_step

#endif
