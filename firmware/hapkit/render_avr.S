// Renderer::call: a function in r25:r24 with parameters at r23:r22, state at r21:r20, and at r19:r18 period, place, speed.
#ifdef __AVR__

  .section .text.render_call, "ax", @progbits
  .global render_call
  .type render_call, @function

render_call:
  push r10
  push r11
  push r12
  push r13
  push r14
  push r15
  push r16
  push r17
  movw r30, r18
  movw r26, r24
  movw r24, r22
  movw r22, r20
  ld r10, Z
  ldd r11, Z+1
  ldd r12, Z+2
  ldd r13, Z+3
  ldd r18, Z+4
  ldd r19, Z+5
  ldd r20, Z+6
  ldd r21, Z+7
  ldd r14, Z+8
  ldd r15, Z+9
  ldd r16, Z+10
  ldd r17, Z+11
  movw r30, r26
  icall
  pop r17
  pop r16
  pop r15
  pop r14
  pop r13
  pop r12
  pop r11
  pop r10
  ret
  .size render_call, .-render_call

#endif
