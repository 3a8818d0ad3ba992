// Sums, products and quotients of floats in two thirds of the library's time, since a law spends most of its time
// on them. Rounded to nearest, ties to even, as in IEEE 754, except that numbers below 2^-126 are zero. Registers
// as in the compiler's own functions of these names: r25..r22 and r21..r18 in, r25..r22 out.
#ifdef __AVR__

  .section .text.avr-libc.fplib, "ax", @progbits  // next to the library's functions, which call each other

; An integer in r25..r22 times a positive float in r21..r18.
  .global times
  .type times, @function
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
1:ldi r26, 150
2:tst r25             ; exceeds the mantissa: truncate
  breq 3f
  lsr r25
  ror r24
  ror r23
  ror r22
  inc r26
  rjmp 2b
3:tst r24
  brmi 5f
  brne 4f
  subi r26, 8
  mov r24, r23
  mov r23, r22
  clr r22
  cpi r26, 150 - 24
  brne 3b
  rjmp zero
4:dec r26
  lsl r22
  rol r23
  rol r24
  brpl 4b
5:mov r25, r26
  lsl r20
  rol r21
  sec
  ror r20
  subi r25, 128
  subi r21, 128
  sec
  adc r25, r21
  brvs 6f
  rjmp multiply
6:rjmp far

; --- the product
odd_product:
  inc r25
  inc r21
  tst r25
  breq 3f
  tst r21
  breq 4f
  cpi r25, 0xff
  brne 1f
  or r24, r23
  or r24, r22
  brne unknown
1:cpi r21, 0xff
  brne infinite
2:or r20, r19
  or r20, r18
  brne unknown
  rjmp infinite
3:cpi r21, 0xff
  breq unknown
  rjmp zero
4:cpi r25, 0xff
  breq unknown
zero:                 ; with the sign in T
  clr r25
  clr r24
  rjmp 2f
unknown:
  ldi r24, 0xc0
  rjmp 1f
infinite:
  ldi r24, 0x80
1:ldi r25, 0x7f
2:clr r23
  clr r22
  bld r25, 7
  ret
far:                  ; overflow of the exponents' sum; N: upwards
  brpl zero
  rjmp infinite

  .global __mulsf3
  .type __mulsf3, @function
__mulsf3:
  mov r0, r25
  eor r0, r21
  bst r0, 7
  lsl r24             ; exponents to r25 and r21
  rol r25
  lsl r20
  rol r21
  dec r25
  dec r21
  cpi r25, 0xfe
  brsh odd_product
  cpi r21, 0xfe
  brsh odd_product
  subi r25, 127       ; signed, so that V indicates an overflow
  subi r21, 127
  sec
  adc r25, r21
  brvs far
  sec                 ; the bit before the point
  ror r24
  sec
  ror r20
multiply:             ; r25 = exponent, r24..r22 and r20..r18 from 1 to 2
  mul r22, r18        ; bytes of the product, from below: r26, r27, r30, r31, then r27, r23 once more
  movw r26, r0
  mul r22, r20
  movw r30, r0
  mul r22, r19
  clr r22
  add r27, r0
  adc r30, r1
  adc r31, r22
  mul r23, r18
  add r27, r0
  adc r30, r1
  adc r31, r22
  or r26, r27         ; of the lower bytes it only matters whether they are zero
  mul r23, r20
  add r31, r0
  mov r27, r1
  adc r27, r22
  mul r23, r19
  add r30, r0
  adc r31, r1
  adc r27, r22
  mul r24, r20
  add r27, r0
  mov r23, r1
  adc r23, r22
  mul r24, r18
  add r30, r0
  adc r31, r1
  adc r27, r22
  adc r23, r22
  mul r24, r19
  add r31, r0
  adc r27, r1
  adc r23, r22
  clr r1
  mov r24, r23
  mov r23, r27
  mov r22, r31
  tst r24
  brmi 1f
  lsl r30
  rol r22
  rol r23
  rol r24
  rjmp 2f
1:inc r25
  brvs 6f
2:lsl r30
  brcc 4f
  or r30, r26
  brne 3f
  sbrs r22, 0
  rjmp 4f
3:subi r22, 0xff
  sbci r23, 0xff
  sbci r24, 0xff
  brcs 4f
  inc r25
  brvs 6f
4:subi r25, 0x80
  breq 5f
  cpi r25, 0xff
  breq 6f
  lsl r24
  lsr r25
  ror r24
  bld r25, 7
  ret
5:rjmp zero
6:rjmp infinite
  .size __mulsf3, .-__mulsf3

; --- sum and difference
odd_sum:              ; the larger one is infinite or NaN
  mov r0, r24
  or r0, r23
  or r0, r22
  brne 1f
  brtc 9f
  cpi r21, 0xff
  brne 9f
1:rjmp unknown
alone:
  tst r25
  brne 9f
  brtc 1f             ; two zeros: negative only if both are
nothing:
  clr r30
1:clr r25
  clr r24
  movw r22, r24
9:rjmp join

  .global __subsf3
  .type __subsf3, @function
  .global __addsf3
  .type __addsf3, @function
__subsf3:
  subi r21, 0x80
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
  movw r26, r22       ; larger operand first
  movw r22, r18
  movw r18, r26
  movw r26, r24
  movw r24, r20
  movw r20, r26
  brtc 1f
  com r30
1:cpi r25, 0xff
  breq odd_sum
  tst r21
  breq alone
  mov r31, r25
  sub r31, r21        ; shift of the smaller operand
  cpi r31, 26
  brsh alone
  sec                 ; the bit before the point
  ror r24
  sec
  ror r20
  clr r26             ; bits shifted out
  cpi r31, 5
  brlo 1f
  rjmp far_apart
1:tst r31
  breq combine
2:lsr r20
  ror r19
  ror r18
  ror r26
  dec r31
  brne 2b
combine:
  brts minus
  add r22, r18
  adc r23, r19
  adc r24, r20
  brcc nearest
  ror r24
  ror r23
  ror r22
  ror r26
  brcc 1f
  ori r26, 1
1:inc r25
  cpi r25, 0xff
  brne nearest
  clr r24
  clr r23
  clr r22
  rjmp join
nearest:
  lsl r26
  brcc pack
  brne 1f
  sbrs r22, 0
  rjmp pack
1:subi r22, 0xff
  sbci r23, 0xff
  sbci r24, 0xff
  brcs pack
  inc r25
pack:
  lsl r24
join:                 ; r25 = exponent, r24 = fractional bits shifted up by one, r30 = sign
  lsr r25
  ror r24
  bst r30, 7
  bld r25, 7
  ret
minus:
  neg r26
  sbc r22, r18
  sbc r23, r19
  sbc r24, r20
  brmi nearest
  breq 9f
1:tst r24
  brne 2f
  mov r24, r23
  mov r23, r22
  mov r22, r26
  clr r26
  subi r25, 8
  brcs 9f
  breq 9f
  tst r24
  brpl 1b
  rjmp nearest
2:dec r25
  breq 9f
  lsl r26
  rol r22
  rol r23
  rol r24
  brpl 2b
  rjmp nearest
9:rjmp nothing
far_apart:
  clr r27             ; whole bytes; nonzero if a nonzero byte is shifted out
6:or r27, r26
  mov r26, r18
  mov r18, r19
  mov r19, r20
  clr r20
  subi r31, 8
  cpi r31, 5
  brge 6b
  tst r31
  breq 9f
  brmi 8f
  mov r21, r26        ; bits that may be shifted out
  andi r21, 15
  or r27, r21
7:lsr r19
  ror r18
  ror r26
  dec r31
  brne 7b
  rjmp 9f
8:lsl r26
  rol r18
  rol r19
  rol r20
  inc r31
  brne 8b
9:cpse r27, r1
  ori r26, 1
  rjmp combine
  .size __addsf3, .-__addsf3

; --- the quotient
odd_quotient:
  inc r25
  inc r21
  tst r25
  breq 3f
  tst r21
  breq 4f
  cpi r25, 0xff
  brne 2f
  or r24, r23
  or r24, r22
  brne 5f
  cpi r21, 0xff
  breq 5f
1:rjmp infinite
2:or r20, r19
  or r20, r18
  brne 5f
  rjmp zero
3:tst r21             ; 0 / b
  breq 5f
  cpi r21, 0xff
  brne 6f
  or r20, r19
  or r20, r18
  brne 5f
6:rjmp zero
4:cpi r25, 0xff       ; a / 0
  brne 1b
  or r24, r23
  or r24, r22
  breq 1b
5:rjmp unknown
  .global __divsf3
  .type __divsf3, @function
__divsf3:
  mov r0, r25
  eor r0, r21
  bst r0, 7
  lsl r24             ; exponents to r25 and r21
  rol r25
  lsl r20
  rol r21
  dec r25
  dec r21
  cpi r25, 0xfe
  brsh odd_quotient
  cpi r21, 0xfe
  brsh odd_quotient
  sec                 ; the bit before the point
  ror r24
  sec
  ror r20
  clr r31
  sub r25, r21        ; r31:r25 = exponent
  sbc r31, r31
  subi r25, lo8(-127)
  sbci r31, hi8(-127)
  cp r22, r18
  cpc r23, r19
  cpc r24, r20
  brsh 1f
  subi r25, 1         ; a quotient from 1/2 to 1: one more bit
  sbci r31, 0
  lsl r22
  rol r23
  rol r24             ; its carry is known: the first bit is 1
1:sub r22, r18        ; the first bit
  sbc r23, r19
  sbc r24, r20
  ldi r30, 3          ; the first bit, below a marker that ends the byte after seven more
  rcall digits
  mov r27, r30
  rcall eight
  mov r26, r30
  rcall eight
  lsl r22             ; compare the remainder with half of the divisor; they are never equal
  rol r23
  rol r24
  brcs 2f
  cp r22, r18
  cpc r23, r19
  cpc r24, r20
  brlo 4f
2:subi r30, 0xff      ; never carries to the next power of two
  sbci r26, 0xff
  sbci r27, 0xff
4:tst r31
  brne 6f
  tst r25
  breq 7f
  cpi r25, 0xff
  breq 5f
  mov r24, r27
  mov r23, r26
  mov r22, r30
  lsl r24
  lsr r25
  ror r24
  bld r25, 7
  ret
5:rjmp infinite
6:tst r31
  brpl 5b
7:rjmp zero

; Up to eight bits of the quotient to r30; the remainder of the dividend stays in r24..r22.
eight:
  ldi r30, 1
digits:
1:lsl r22
  rol r23
  rol r24
  brcs 2f
  cp r22, r18
  cpc r23, r19
  cpc r24, r20
  brlo 3f             ; carry: a 0 bit, after inversion
2:sub r22, r18
  sbc r23, r19
  sbc r24, r20
  sec
  rol r30
  brcc 1b
  ret
3:lsl r30
  brcc 1b
  ret
  .size __divsf3, .-__divsf3

#endif
