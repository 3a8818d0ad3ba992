// Multiply two floats in two thirds of the time that the library takes, which every law does several times.
// Rounds to the nearest; what is too small is zero; where one is not finite, the product is not a number.
// In r25..r22 and r21..r18, out r25..r22; as the compiler expects of its own function of this name.
#ifdef __AVR__

  .section .text.avr-libc.fplib, "ax", @progbits  // beside the library's, which calls and is called nearby
  .type __mulsf3, @function

; An integer in r25..r22 times a positive float in r21..r18.
  .global times
times:
  bst r25, 7
  brtc 1f
  com r25
  com r24
  com r23
  neg r22
  sbci r23, 0xff
  sbci r24, 0xff
  sbci r25, 0xff
1:ldi r26, 0x96
  tst r25
  breq 3f
2:lsr r25             ; more than a float holds: cut off
  ror r24
  ror r23
  ror r22
  inc r26
  tst r25
  brne 2b
3:tst r24
  brne 4f
  subi r26, 8
  mov r24, r23
  mov r23, r22
  clr r22
  tst r24
  brne 4f
  subi r26, 8
  mov r24, r23
  clr r23
  tst r24
  breq zero
4:brmi 6f
5:dec r26
  lsl r22
  rol r23
  rol r24
  brpl 5b
6:mov r25, r26
  lsl r20
  rol r21
  sec
  ror r20
  rjmp multiply

zero:
  clr r25
  clr r24
  movw r22, r24
  bld r25, 7
  ret
unknown:
  ldi r25, 0x7f
  ldi r24, 0xc0
  clr r23
  clr r22
  ret

  .global __mulsf3
__mulsf3:
  mov r0, r25
  eor r0, r21
  bst r0, 7
  lsl r24             ; exponents to r25 and r21
  rol r25
  lsl r20
  rol r21
  tst r25
  breq zero
  tst r21
  breq zero
  cpi r25, 0xff
  breq unknown
  cpi r21, 0xff
  breq unknown
  sec                 ; the bit before the point
  ror r24
  sec
  ror r20
multiply:
  add r25, r21        ; r21:r25 = exponent of the product
  ldi r21, 0
  rol r21
  subi r25, 126
  sbci r21, 0
  mul r24, r20        ; r31 r30 r27 r26 = its upper bytes; what is lower is never more than a rounding
  movw r30, r0
  mul r22, r20
  movw r26, r0
  mul r22, r19
  add r26, r1
  brcc 1f
  inc r27
1:mul r23, r18
  add r26, r1
  brcc 2f
  inc r27
2:mul r23, r19
  add r26, r0
  adc r27, r1
  brcc 3f
  adiw r30, 1
3:mul r24, r18
  add r26, r0
  adc r27, r1
  brcc 4f
  adiw r30, 1
4:mul r23, r20
  add r27, r0
  adc r30, r1
  brcc 5f
  inc r31
5:mul r24, r19
  add r27, r0
  adc r30, r1
  brcc 6f
  inc r31
6:clr r1
  tst r31
  brmi 7f
  lsl r26
  rol r27
  rol r30
  rol r31
  subi r25, 1
  sbci r21, 0
7:lsl r26             ; round
  adc r27, r1
  adc r30, r1
  adc r31, r1
  brcs carried
8:tst r21
  brne far
  tst r25
  breq small
  cpi r25, 0xff
  breq large
  lsl r31
  lsr r25
  ror r31
  mov r24, r31
  bld r25, 7
  mov r23, r30
  mov r22, r27
  ret
carried:
  ldi r31, 0x80
  subi r25, 0xff
  sbci r21, 0xff
  rjmp 8b
far:
  brpl large
small:
  rjmp zero
large:
  rjmp unknown
  .size __mulsf3, .-__mulsf3

; Add and subtract, in less than two thirds of the library's time. Rounds to the nearest, to the even one of two
; where no bit of the smaller number lies below an eighth bit behind the last, else within a neighbour; what is
; too small is zero. Infinities and what is not a number go the way that IEEE 754 says.
  .type __addsf3, @function
  .type __subsf3, @function
  .global __subsf3
__subsf3:
  subi r21, 0x80
  .global __addsf3
__addsf3:
  mov r30, r25        ; sign of the larger
  mov r0, r25
  eor r0, r21
  bst r0, 7           ; T: the signs differ
  lsl r24             ; exponents to r25 and r21
  rol r25
  lsl r20
  rol r21
  cp r22, r18
  cpc r23, r19
  cpc r24, r20
  cpc r25, r21
  brsh 1f
  movw r26, r22       ; the larger one first
  movw r22, r18
  movw r18, r26
  movw r26, r24
  movw r24, r20
  movw r20, r26
  brtc 1f
  com r30
1:cpi r25, 0xff
  brne 10f
  rjmp odd
10:
  tst r21
  breq alone
  mov r31, r25
  sub r31, r21        ; places that the smaller one moves
  cpi r31, 26
  brsh alone
  sec
  ror r24
  sec
  ror r20
  clr r26             ; what lies below
2:cpi r31, 8
  brlo 3f
  mov r26, r18
  mov r18, r19
  mov r19, r20
  clr r20
  subi r31, 8
  rjmp 2b
3:tst r31
  breq 5f
4:lsr r20
  ror r19
  ror r18
  ror r26
  dec r31
  brne 4b
5:brts minus
  add r22, r18
  adc r23, r19
  adc r24, r20
  brcc nearest
  ror r24
  ror r23
  ror r22
  ror r26
  inc r25
  cpi r25, 0xff
  breq infinite
nearest:
  lsl r26
  brcc pack
  brne 6f
  sbrs r22, 0
  rjmp pack
6:subi r22, 0xff
  sbci r23, 0xff
  sbci r24, 0xff
  brcs pack
  inc r25
pack:
  lsl r24
join:
  lsr r25
  ror r24
  bst r30, 7
  bld r25, 7
  ret
alone:
  tst r25
  brne join
  brtc 7f             ; two zeros: negative only if both are
nothing:
  clr r30
7:clr r25
  clr r24
  movw r22, r24
  rjmp join
minus:
  neg r26
  sbc r22, r18
  sbc r23, r19
  sbc r24, r20
  brmi nearest
  breq nothing
8:tst r24
  brne 9f
  mov r24, r23
  mov r23, r22
  mov r22, r26
  clr r26
  subi r25, 8
  brcs nothing
  breq nothing
  tst r24
  brpl 8b
  rjmp nearest
9:dec r25
  breq nothing
  lsl r26
  rol r22
  rol r23
  rol r24
  brpl 9b
  rjmp nearest
odd:
  mov r0, r24
  or r0, r23
  or r0, r22
  brne 10f
  brtc infinite
  cpi r21, 0xff
  brne infinite
10:
  rjmp unknown
infinite:
  clr r24
  clr r23
  clr r22
  rjmp join
  .size __addsf3, .-__addsf3

#endif
