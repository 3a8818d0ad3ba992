// What laws do in every tick besides products and sums: compare two floats in two thirds of the library's time, and
// find an inverse that was kept. As the compiler expects of its own functions of these names.
#ifdef __AVR__

  .section .text.avr-libc.fplib, "ax", @progbits  // beside the library's, which is called nearby

; Negative, zero or positive in r24 as r25..r22 is below, like or above r21..r18; where one is not a number, what
; makes the comparison false: 1 for less and equal, -1 for greater.
  .global __gesf2
  .global __gtsf2
__gesf2:
__gtsf2:
  ldi r26, -1
  rjmp 1f
  .global __cmpsf2
  .global __eqsf2
  .global __nesf2
  .global __ltsf2
  .global __lesf2
__cmpsf2:
__eqsf2:
__nesf2:
__ltsf2:
__lesf2:
  ldi r26, 1
1:movw r30, r24
  lsl r30
  rol r31
  cpi r31, 0xff
  breq 7f
2:movw r30, r20
  lsl r30
  rol r31
  cpi r31, 0xff
  breq 8f
3:mov r0, r25
  eor r0, r21
  brmi 5f
  cp r22, r18
  cpc r23, r19
  cpc r24, r20
  cpc r25, r21
  breq 6f
  sbc r24, r24
  ori r24, 1
4:sbrc r25, 7
  neg r24
  ret
5:mov r0, r25         ; two zeros are alike
  or r0, r21
  lsl r0
  or r0, r24
  or r0, r23
  or r0, r22
  or r0, r20
  or r0, r19
  or r0, r18
  ldi r24, 1
  brne 4b
6:clr r24
  ret
7:or r30, r22
  or r30, r23
  breq 2b
  mov r24, r26
  ret
8:or r30, r18
  or r30, r19
  breq 3b
  mov r24, r26
  ret

; float laws_inverse(Inverse*, float): as law.h has it in C++ for a PC.
  .global laws_inverse
  .type laws_inverse, @function
laws_inverse:
  movw r30, r24
  com r20
  com r21
  com r22
  com r23
  ld r0, Z
  cp r0, r20
  brne 1f
  ldd r0, Z+1
  cp r0, r21
  brne 1f
  ldd r0, Z+2
  cp r0, r22
  brne 1f
  ldd r0, Z+3
  cp r0, r23
  brne 1f
  ldd r22, Z+4
  ldd r23, Z+5
  ldd r24, Z+6
  ldd r25, Z+7
  ret
1:st Z, r20
  std Z+1, r21
  std Z+2, r22
  std Z+3, r23
  push r30
  push r31
  movw r18, r20
  movw r20, r22
  com r18
  com r19
  com r20
  com r21
  clr r22
  clr r23
  ldi r24, 0x80
  ldi r25, 0x3f
  call __divsf3
  pop r31
  pop r30
  std Z+4, r22
  std Z+5, r23
  std Z+6, r24
  std Z+7, r25
  ret

#endif
