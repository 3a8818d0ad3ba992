// sensor::count and FlipTracker::follow in two thirds of the time that the compiler takes.
#ifdef __AVR__

#define COUNTS 4  // places in a FlipTracker, which begins with its position
#define LAST 6
#define SLACK 8
#define STEP 10
#define GOING 12
#define LOWEST 23  // and in what sensor::count has besides
#define SPAN 25
#define WARY 27
#define SENSE 28

  .section .text.sensor_follow, "ax", @progbits

; bool follow(FlipTracker*, uint16_t raw)
  .global flip_follow
  .type flip_follow, @function
flip_follow:
  movw r30, r24
  movw r24, r22
  rcall follow
  ldi r24, 0
  brts 1f
  inc r24
1:ret

; A FlipTracker at r31:r30, a reading in r25:r24. The position in r25..r22; or T and nothing changed, if the reading
; does not go on with the motion.
follow:
  ldd r18, Z + LAST
  ldd r19, Z + LAST + 1
  movw r20, r24
  sub r20, r18
  sbc r21, r19        ; the jump
  ldd r18, Z + COUNTS
  ldd r19, Z + COUNTS + 1
  movw r22, r18
  lsr r23
  ror r22
  add r22, r20
  adc r23, r21
  cp r22, r18
  cpc r23, r19
  brsh 7f
1:ldd r22, Z + GOING
  ldd r23, Z + GOING + 1
  movw r26, r20
  sub r26, r22
  sbc r27, r23
  ldd r22, Z + SLACK
  ldd r23, Z + SLACK + 1
  add r26, r22
  adc r27, r23
  lsl r22
  rol r23
  cp r22, r26
  cpc r23, r27
  set
  brlo 6f
  clt
  ldd r22, Z + STEP
  ldd r23, Z + STEP + 1
  std Z + STEP, r20
  std Z + STEP + 1, r21
  mov r18, r21
  lsl r18
  sbc r18, r18        ; its sign
  mov r19, r23
  eor r19, r21
  brmi 4f
  cp r20, r22         ; what the last two have in common: the smaller one
  cpc r21, r23
  brlt 2f
  sbrc r21, 7
  movw r22, r20
  rjmp 3f
2:sbrs r21, 7
  movw r22, r20
3:std Z + GOING, r22
  std Z + GOING + 1, r23
  std Z + LAST, r24
  std Z + LAST + 1, r25
  ld r22, Z
  ldd r23, Z + 1
  ldd r24, Z + 2
  ldd r25, Z + 3
  add r22, r20
  adc r23, r21
  adc r24, r18
  adc r25, r18
  st Z, r22
  std Z + 1, r23
  std Z + 2, r24
  std Z + 3, r25
6:ret
4:clr r22             ; nothing, as they lead apart
  clr r23
  rjmp 3b
7:cp r18, r1          ; farther than half the range
  cpc r19, r1
  breq 1b
  sbrs r21, 7
  rjmp 8f
  add r20, r18
  adc r21, r19
  rjmp 1b
8:sub r20, r18
  sbc r21, r19
  rjmp 1b

; int32_t sensor::count(uint16_t raw, bool failed)
  .global sensor_count
  .type sensor_count, @function
sensor_count:
  ldi r30, lo8(sensor_watched)
  ldi r31, hi8(sensor_watched)
  ldd r18, Z + WARY
  or r18, r22
  brne 1f
  ldd r18, Z + LOWEST
  ldd r19, Z + LOWEST + 1
  movw r20, r24
  sub r20, r18
  sbc r21, r19
  ldd r18, Z + SPAN
  ldd r19, Z + SPAN + 1
  cp r18, r20
  cpc r19, r21
  brlo 1f
  rcall follow
  brtc 2f
  ldi r22, 0          ; it did not fail
1:call sensor_consider
  ldi r30, lo8(sensor_watched)
  ldi r31, hi8(sensor_watched)
2:ldd r18, Z + SENSE
  sbrs r18, 7
  ret
  jmp __negsi2        ; of libgcc

#endif
