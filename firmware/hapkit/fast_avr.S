// Sine and powers by tables in half the time that the compiler's code takes: fast.h has the same in C++ for a PC.
// Arguments and results as the compiler passes them: r25..r22 first, then r21 r20, r19 r18, r17 r16.
#ifdef __AVR__

  .section .text._ZN4fast_avr, "ax", @progbits

; r24 r23 r22 so many places up or, if negative, down: r30, from -128 to 31; r25 is 0 before.
move:
  tst r30
  brmi 5f
1:cpi r30, 8
  brlo 2f
  mov r25, r24
  mov r24, r23
  mov r23, r22
  clr r22
  subi r30, 8
  rjmp 1b
2:tst r30
  breq 4f
3:lsl r22
  rol r23
  rol r24
  rol r25
  dec r30
  brne 3b
4:ret
5:cpi r30, -7
  brge 6f
  mov r22, r23
  mov r23, r24
  clr r24
  subi r30, -8
  brmi 5b
  ret
6:lsr r24
  ror r23
  ror r22
  inc r30
  brne 6b
  ret

; uint32_t fast_shifted(uint32_t bits, int8_t places): the 24 bits of a float so many places up or down, up to 31.
  .global fast_shifted
  .type fast_shifted, @function
fast_shifted:
  ori r24, 0x80
  clr r25
  mov r30, r20
  rjmp move

; float fast_floor(float)
  .global fast_floor
  .type fast_floor, @function
fast_floor:
  mov r31, r24
  lsl r31
  mov r30, r25
  rol r30             ; exponent
  subi r30, 127
  brcs 7f
  ldi r31, 23
  sub r31, r30        ; places behind the point
  breq 6f
  brcs 6f
  ldi r30, 1          ; the lowest place before it, in its byte
  clr r26             ; what was behind it
  cpi r31, 8
  brlo 3f
  mov r26, r22
  clr r22
  subi r31, 8
  cpi r31, 8
  brlo 2f
  or r26, r23
  clr r23
  subi r31, 8
  rcall 9f
  and r31, r24
  or r26, r31
  eor r24, r31
  rcall 8f
  add r24, r30
  adc r25, r1
  ret
2:rcall 9f
  and r31, r23
  or r26, r31
  eor r23, r31
  rcall 8f
  add r23, r30
  adc r24, r1
  adc r25, r1
  ret
3:rcall 9f
  and r31, r22
  or r26, r31
  eor r22, r31
  rcall 8f
  add r22, r30
  adc r23, r1
  adc r24, r1
  adc r25, r1
6:ret
7:mov r0, r24         ; below 1
  or r0, r23
  or r0, r22
  mov r30, r25
  lsl r30
  or r0, r30
  breq 6b
  ldi r24, 0x80
  sbrs r25, 7
  clr r24
  lsl r25
  sbc r25, r25
  andi r25, 0xbf
  clr r23
  clr r22
  ret
8:sbrs r25, 7         ; away from zero only what is negative and not whole
  rjmp 1f
  tst r26
  brne 6b
1:clr r30
  ret
9:tst r31             ; r30 = 2^r31, r31 = what is below
  breq 5f
4:lsl r30
  dec r31
  brne 4b
5:mov r31, r30
  dec r31
  ret

; A table's value at Z, r24 r23 / 2^16 of the way to the next one, on the straight line: r20 r19 r18; r26 says how far
; the curve lies beside it. Leaves r27 alone.
between:
  lpm r18, Z+
  lpm r19, Z+
  lpm r20, Z+
  lpm r21, Z+
  lpm r22, Z+
  lpm r25, Z
  sub r21, r18
  sbc r22, r19
  sbc r25, r20
  mov r26, r24        ; d (1 - d) in 8 bits, times the value's upper ones
  com r26
  mul r26, r24
  lsl r0
  rol r1
  lsl r0
  rol r1
  mul r1, r20
  mov r26, r1
  mul r21, r23        ; the step, of 18 bits, times d
  mov r30, r1
  clr r31
  mul r21, r24
  add r30, r0
  adc r31, r1
  mul r22, r23
  clr r21
  add r30, r0
  adc r31, r1
  adc r21, r21
  mul r22, r24
  add r31, r0
  adc r21, r1
  mul r25, r23
  clr r22
  add r31, r0
  adc r21, r1
  adc r22, r22
  mul r25, r24
  add r21, r0
  adc r22, r1
  clr r1
  add r18, r31
  adc r19, r21
  adc r20, r22
  ret

; Z = r21 r20 + 3 r30.
place:
  mov r31, r30
  lsl r30
  add r30, r31
  clr r31
  add r30, r20
  adc r31, r21
  ret

; float fast_sine(float turns, const uint8_t* table, uint8_t quarter): quarter is 0x40 for the cosine.
  .global fast_sine
  .type fast_sine, @function
fast_sine:
  mov r0, r25
  mov r31, r24
  lsl r31
  mov r30, r25
  rol r30             ; exponent
  cpi r30, 0xff
  brne 1f
  rjmp unknown
1:cpi r30, 150
  brsh whole
  ori r24, 0x80
  clr r25
  subi r30, 118
  rcall move
  sbrs r0, 7
  rjmp 1f
  call __negsi2       ; of libgcc
1:add r25, r18
  bst r25, 7
  sbrs r25, 6
  rjmp 2f
  com r25
  com r24
  com r23
2:mov r30, r25
  andi r30, 63
  rcall place
  rcall between
  ldi r27, 5
  mul r26, r27
  add r18, r0
  adc r19, r1
  clr r1
  adc r20, r1
  ldi r25, 127
3:tst r20
  brmi 6f
  brne 4f
  mov r20, r19        ; eight places; after three times there is nothing
  mov r19, r18
  clr r18
  subi r25, 8
  cpi r25, 127 - 24
  brne 3b
  rjmp zero
4:dec r25
  lsl r18
  rol r19
  rol r20
  brpl 4b
6:lsl r20
  lsr r25
  ror r20
  bld r25, 7
  mov r24, r20
  movw r22, r18
  ret
whole:
  clr r25
  clr r24
  movw r22, r24
  rjmp 1b

; float fast_power_of_square(float x, const uint8_t* table, uint16_t factor, int8_t places)
  .global fast_power_of_square
  .type fast_power_of_square, @function
fast_power_of_square:
  ldi r30, 0x80       ; to the nearest of 16 bits: r24 r23
  add r22, r30
  adc r23, r1
  adc r24, r1
  adc r25, r1
  mov r31, r24
  lsl r31
  mov r30, r25
  rol r30             ; exponent
  ldi r26, lo8(261)   ; r27 r26 = places down
  ldi r27, hi8(261)
  sub r26, r30
  sbc r27, r1
  sub r26, r30
  sbc r27, r1
  sub r26, r16
  sbc r27, r1
  sbrc r16, 7
  inc r27
  cp r1, r26
  cpc r1, r27
  brge far
  cpi r26, 32
  cpc r27, r1
  brge one
  ori r24, 0x80
  mul r24, r24        ; r31 r30 = upper half of the square
  movw r30, r0
  mul r24, r23
  movw r24, r0
  mul r23, r23
  clr r22
  lsl r24
  rol r25
  rol r22
  ldi r23, 0x80
  add r24, r1
  clr r1
  adc r25, r1
  adc r22, r1
  add r24, r23
  adc r25, r1
  adc r22, r1
  add r30, r25
  adc r31, r22
  mul r31, r19        ; times the factor
  movw r24, r0
  mul r30, r18
  movw r22, r0
  mul r31, r18
  add r23, r0
  adc r24, r1
  clr r1
  adc r25, r1
  mul r30, r19
  add r23, r0
  adc r24, r1
  clr r1
  adc r25, r1
1:cpi r26, 8
  brlo 2f
  mov r22, r23
  mov r23, r24
  mov r24, r25
  clr r25
  subi r26, 8
  rjmp 1b
2:tst r26
  breq 4f
3:lsr r25
  ror r24
  ror r23
  ror r22
  dec r26
  brne 3b
4:rjmp negative
far:
  cpi r30, 0xff
  brne zero
  andi r24, 0x7f
  or r24, r23
  breq zero
  rjmp unknown
one:
  clr r22
  clr r23
  ldi r24, 0x80
  ldi r25, 0x3f
  ret
unknown:
  ldi r25, 0x7f
  ldi r24, 0xc0
  ret
zero:
  clr r25
  clr r24
  movw r22, r24
  ret

; float fast_power(float x, const uint8_t* table): 2^x
  .global fast_power
  .type fast_power, @function
fast_power:
  mov r0, r25
  mov r31, r24
  lsl r31
  mov r30, r25
  rol r30             ; exponent
  cpi r30, 134
  brsh large
  ori r24, 0x80
  clr r25
  subi r30, 128
  rcall move
  sbrs r0, 7
  rjmp 1f
negative:
  com r25
  com r24
  com r23
  com r22
; r25 r24 = whole places and 64ths, r23 r22 = what is below.
1:cpi r24, 0x80
  ldi r30, 0xe0
  cpc r25, r30
  brlt zero
  mov r30, r24
  andi r30, 63
  lsl r24
  rol r25
  lsl r24
  rol r25
  subi r25, -126
  mov r27, r25
  mov r24, r23
  mov r23, r22
  rcall place
  rcall between
  sub r18, r26
  sbc r19, r1
  sbc r20, r1
  clr r24
  lsr r27
  ror r24
  add r24, r20
  mov r25, r27
  adc r25, r1
  movw r22, r18
  ret
large:
  cpi r30, 0xff
  brne 2f
  lsl r24
  or r24, r23
  or r24, r22
  breq 2f
  rjmp unknown
2:sbrc r0, 7
  rjmp zero
  ldi r25, 0x7f
  ldi r24, 0x80
  clr r23
  clr r22
  ret

#endif
