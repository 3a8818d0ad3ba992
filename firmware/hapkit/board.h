// What the program needs from the hardware. The files *_avr.cpp are the Hapkit; the tests bring their own.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace board {

constexpr uint32_t kCpu = 16000000;  // cycles in a second
constexpr float kTickUs = 0.5f;  // resolution of the clock [us]
constexpr uint16_t kTicksPerMs = 2000;
constexpr uint16_t kShortest = 500, kLongest = 4000;  // sample period: 4 kHz to 500 Hz [ticks]
constexpr uint8_t kQueue = 112;  // bytes that can wait to be sent

// One reading of the sensor.
struct Sampling {
  uint16_t seq;      // counts every sample period, also those that had to be skipped
  uint16_t raw;      // the sensor's reading itself
  uint8_t missed;    // sample periods that were skipped just before this one
  uint16_t ticks;    // of the clock in the period that ended with this one
  bool failed;       // the sensor's own check says that the reading is wrong
};

// Set up clock and serial port; the motor is off. The hardware watchdog resets the board from now on.
void begin();

// Motor off; then pins, timers and sensor as the kit needs them. Main program only.
void configure(const protocol::Board& kit);

// While on, no reading is handled: what the sample interrupt uses may change. Main program only.
void hold(bool on);

// Take a sample every so many ticks, from the next one on.
void set_period(uint16_t ticks);

// Called once per sample period, from an interrupt that lets other interrupts through.
void on_sample(const Sampling& sampling);

// When the sample was taken that on_sample() is handling, for us_of().
uint32_t stamp();

// Board clock at a stamp [us]. Main program only, and at least every 17 minutes.
uint32_t us_of(uint32_t stamp);

// How long ago that was [us].
uint16_t age_us();

// Take the next received byte; false if there is none.
bool read(uint8_t* byte);

// Return a place in the queue for so many bytes, or nothing if there is no room now; send() hands over what was
// written there. Main program only.
uint8_t* room_for(uint8_t size);
void send(uint8_t* end);

// From now on a byte that is received, or wake() in an interrupt, ends the next sleep(), also before it has begun;
// and it does not begin while there is something to read.
void may_sleep();
void wake();
void sleep();

// Tell the hardware watchdog that all is well; a pause of 15 ms resets the board.
void pat();

// Why the board started: 1 power, 2 reset, 4 brown-out, 8 watchdog; 0 where the bootloader does not tell.
uint8_t reset_cause();

// Set the signed duty of the motor, -profile::kPwmTop..profile::kPwmTop, positive to the right.
void set_motor(int16_t pwm);

// Board clock in us.
uint32_t now_us();

// Received bytes that were lost or damaged so far; wraps.
uint8_t lost_bytes();

}  // namespace board
