// machine.cpp's run() in assembler: in C++ each operation takes 40 cycles more.
// r25..r22 A     Y the next byte of code     r17 4, the size of a slot
// Call-saved registers of the compiler are preserved; r1 is 0 between operations.
#ifdef __AVR__

#include "opcodes.h"

#define arena _ZN7machine5arenaE
#define program _ZN7machine7programE
#define run _ZN7machine3runEff

  .section .bss.machine_counters, "aw", @nobits
counters:
  .zero 8             ; two bytes for each open loop

  .section .text.machine_run, "ax", @progbits
table:                ; one word for each code
  .macro operation code, place
  .org 2 * \code
  rjmp \place
  .endm
  operation OP_RETURN, return
  operation OP_MAIN, leave
  operation OP_CALL, call
  operation OP_JUMP, jump
  operation OP_FAR_JUMP, far_jump
  operation OP_LOOP, loop
  operation OP_NEXT, next_turn
  operation OP_LOAD, load
  operation OP_STORE, store
  operation OP_LOAD_AT, load_at
  operation OP_STORE_AT, store_at
  operation OP_ADD, add
  operation OP_SUBTRACT, subtract
  operation OP_SUBTRACT_FROM, subtract_from
  operation OP_MULTIPLY, multiply
  operation OP_DIVIDE, divide
  operation OP_DIVIDE_INTO, divide_into
  operation OP_MINIMUM, minimum
  operation OP_MAXIMUM, maximum
  operation OP_FLOOR_DIVIDE, floor_divide
  operation OP_MODULO, modulo
  operation OP_REMAINDER, remainder
  operation OP_POWER, power
  operation OP_ATAN2, atan2
  operation OP_HYPOT, hypot
  operation OP_COPYSIGN, copysign
  operation OP_NEGATE, negate
  operation OP_ABSOLUTE, absolute
  operation OP_SQRT, sqrt
  operation OP_FLOOR, floor
  operation OP_CEIL, ceil
  operation OP_TRUNCATE, truncate
  operation OP_SIN, sin
  operation OP_COS, cos
  operation OP_TAN, tan
  operation OP_ASIN, asin
  operation OP_ACOS, acos
  operation OP_ATAN, atan
  operation OP_EXP, exp
  operation OP_EXPM1, expm1
  operation OP_LOG, log
  operation OP_LOG1P, log1p
  operation OP_SINH, sinh
  operation OP_COSH, cosh
  operation OP_TANH, tanh
  .org 2 * OP_COMPARE
  .rept 16
  rjmp compare
  .endr
  .org 2 * OP_TEST
  .rept 16
  rjmp test
  .endr

; Continue with the next operation. Slow operations jump to go_on instead, which saves memory.
  .macro next
  ld r30, Y+
  clr r31
  subi r30, pm_lo8(-(table))
  sbci r31, pm_hi8(-(table))
  ijmp
  .endm

; Z = address of the slot in the next byte.
  .macro place
  ld r30, Y+
  mul r30, r17
  movw r30, r0
  clr r1
  subi r30, lo8(-(arena))
  sbci r31, hi8(-(arena))
  .endm

; r21..r18 = value of the slot in the next byte.
  .macro fetch
  place
  ld r18, Z
  ldd r19, Z+1
  ldd r20, Z+2
  ldd r21, Z+3
  .endm

; float run(float x, float v)
  .global run
  .type run, @function
run:
  push r17
  push r28
  push r29
  sts arena, r22
  sts arena+1, r23
  sts arena+2, r24
  sts arena+3, r25
  sts arena+4, r18
  sts arena+5, r19
  sts arena+6, r20
  sts arena+7, r21
  ldi r17, 4
  lds r28, program+2
  lds r29, program+3
  push r28            ; return address of the last RETURN: MAIN itself, which exits
  push r29
  adiw r28, 1
  next

return:
  pop r29
  pop r28
  next

leave:
  pop r29
  pop r28
  pop r17
  ret

fail:                 ; return NaN from any call depth
  ldi r25, 0x7f
  ldi r24, 0xc0
  clr r23
  clr r22
1:pop r29
  pop r28
  ld r30, Y
  cpi r30, OP_MAIN
  brne 1b
  rjmp leave

call:
  ld r30, Y+
  ld r31, Y+
  push r28
  push r29
  lds r28, program
  lds r29, program+1
  adiw r28, 1
  add r28, r30
  adc r29, r31
  rjmp go_on

far_jump:
  ld r30, Y+
  ld r31, Y+
  add r28, r30
  adc r29, r31
  rjmp go_on

jump:
  ld r30, Y+
  add r28, r30
  adc r29, r1
  next

; Z = address of the counter in the next byte.
  .macro counter
  ld r30, Y+
  lsl r30
  clr r31
  subi r30, lo8(-(counters))
  sbci r31, hi8(-(counters))
  .endm

loop:
  counter
  ld r18, Y+
  ld r19, Y+
  st Z, r18
  std Z+1, r19
  rjmp go_on

next_turn:
  counter
  ld r18, Z
  ldd r19, Z+1
  ld r20, Y+
  ld r21, Y+
  subi r18, 1
  sbci r19, 0
  st Z, r18
  std Z+1, r19
  breq 1f
  sub r28, r20
  sbc r29, r21
1:next

load:
  place
  ld r22, Z
  ldd r23, Z+1
  ldd r24, Z+2
  ldd r25, Z+3
  next

store:
  place
  st Z, r22
  std Z+1, r23
  std Z+2, r24
  std Z+3, r25
  next

; Z = address of the slot at an index of a table.
element:
  fetch
  ld r26, Y+          ; first slot
  ld r27, Y+          ; number of slots
  bst r21, 7
  lsl r20
  rol r21
  breq 2f             ; below the smallest normal float: 0, unless negative
  brts 3f
  subi r21, 127
  brcs 1f             ; below 1
  cpi r21, 8
  brsh 3f
  sec
  ror r20             ; to be shifted right by 7 - r21 bits
  subi r21, 7
  breq 4f
5:lsr r20
  inc r21
  brne 5b
  rjmp 4f
2:brtc 1f
  or r20, r19
  or r20, r18
  brne 3f
1:clr r20
4:cp r20, r27
  brsh 3f
  clr r31
  mov r30, r26
  add r30, r20        ; the slot is at most 255, as verified
  mul r30, r17
  movw r30, r0
  clr r1
  subi r30, lo8(-(arena))
  sbci r31, hi8(-(arena))
  ret
3:pop r30
  pop r30
  rjmp fail

load_at:
  rcall element
  ld r22, Z
  ldd r23, Z+1
  ldd r24, Z+2
  ldd r25, Z+3
  rjmp go_on

store_at:
  rcall element
  st Z, r22
  std Z+1, r23
  std Z+2, r24
  std Z+3, r25
  rjmp go_on

add:
  fetch
  call __addsf3
  next

subtract:
  fetch
  call __subsf3
  next

subtract_from:
  fetch
  subi r25, 0x80
  call __addsf3
  next

multiply:
  fetch
  call __mulsf3
  next

; r21..r18 = value of the slot in the next byte; fails if it is a divisor of 0.
divisor:
  fetch
  mov r30, r20
  lsl r30
  mov r30, r21
  rol r30
  breq 1f
  ret
1:pop r30
  pop r30
  rjmp fail

divide_into:
  fetch
  movw r26, r22
  movw r22, r18
  movw r18, r26
  movw r26, r24
  movw r24, r20
  movw r20, r26
  lsl r26
  rol r27
  brne 1f
  rjmp fail
divide:
  rcall divisor
1:call __divsf3
  rjmp go_on

; r31 = the outcome of A against r21..r18; leaves r27.
outcome:
  mov r26, r25
  andi r26, 0x7f
  cpi r26, 0x7f
  breq 4f
1:mov r26, r21
  andi r26, 0x7f
  cpi r26, 0x7f
  breq 5f
2:mov r26, r25
  eor r26, r21
  brmi 3f
  cp r22, r18
  cpc r23, r19
  cpc r24, r20
  cpc r25, r21
  breq 6f
  sbc r26, r26
  eor r26, r25        ; of two negative numbers, the larger bit pattern is less
  ldi r31, 4
  sbrc r26, 7
  ldi r31, 1
  ret
3:ldi r31, 4          ; different signs; both may be zero
  sbrc r25, 7
  ldi r31, 1
  mov r26, r25
  or r26, r21
  lsl r26
  or r26, r24
  or r26, r23
  or r26, r22
  or r26, r20
  or r26, r19
  or r26, r18
  brne 7f
6:ldi r31, 2
7:ret
4:sbrs r24, 7
  rjmp 1b
  mov r26, r24        ; infinite or NaN
  lsl r26
  or r26, r23
  or r26, r22
  breq 1b
8:ldi r31, 8
  ret
5:sbrs r20, 7
  rjmp 2b
  mov r26, r20
  lsl r26
  or r26, r19
  or r26, r18
  breq 2b
  rjmp 8b

compare:
  mov r27, r30
  subi r27, pm_lo8(table)  ; its code
  fetch
  rcall outcome
  ld r30, Y+
  and r27, r31
  breq 1f
  add r28, r30
  adc r29, r1
1:next

test:
  ldi r31, 2
  mov r27, r25
  lsl r27
  mov r26, r27
  or r26, r24
  or r26, r23
  or r26, r22
  breq 2f
  ldi r31, 4
  sbrc r25, 7
  ldi r31, 1
  cpi r27, 0xfe
  brne 2f
  mov r26, r24
  lsl r26
  brcc 2f
  or r26, r23
  or r26, r22
  breq 2f
  ldi r31, 8
2:ld r26, Y+
  subi r30, pm_lo8(table)  ; its code
  and r30, r31
  breq 1f
  add r28, r26
  adc r29, r1
1:next

minimum:
  fetch
  rcall outcome
  cpi r31, 4
  breq take
  rjmp go_on
maximum:
  fetch
  rcall outcome
  cpi r31, 1
  breq take
  rjmp go_on
take:
  movw r22, r18
  movw r24, r20
  rjmp go_on

copysign:
  fetch
  bst r21, 7
  bld r25, 7
  rjmp go_on

negate:
  subi r25, 0x80
  next

absolute:
  andi r25, 0x7f
  next

  .macro unary name, function
\name:
  call \function
  rjmp go_on
  .endm
  .macro binary name, function
\name:
  rcall operand
  call \function
  rjmp go_on
  .endm
  .macro quotient name, function
\name:
  rcall divisor
  call \function
  rjmp go_on
  .endm
  unary sqrt, _ZN9functions4sqrtEf
  unary floor, _ZN9functions5floorEf
  unary ceil, _ZN9functions4ceilEf
  unary truncate, _ZN9functions5truncEf
  unary sin, _ZN9functions3sinEf
  unary cos, _ZN9functions3cosEf
  unary tan, _ZN9functions3tanEf
  unary asin, _ZN9functions4asinEf
  unary acos, _ZN9functions4acosEf
  unary atan, _ZN9functions4atanEf
  unary exp, _ZN9functions3expEf
  unary expm1, _ZN9functions5expm1Ef
  unary log, _ZN9functions3logEf
  unary log1p, _ZN9functions5log1pEf
  unary sinh, _ZN9functions4sinhEf
  unary cosh, _ZN9functions4coshEf
  unary tanh, _ZN9functions4tanhEf
  quotient floor_divide, _ZN9functions12floor_divideEff
  quotient modulo, _ZN9functions6moduloEff
  quotient remainder, _ZN9functions9remainderEff
  binary power, _ZN9functions5powerEff
  binary atan2, _ZN9functions5atan2Eff
  binary hypot, _ZN9functions5hypotEff
go_on:
  next
operand:
  fetch
  ret
  .size run, .-run

#endif
