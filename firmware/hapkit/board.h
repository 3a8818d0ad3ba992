// Hardware interface of the program. The files *_avr.cpp implement it for the Hapkit; tests have their own.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace board {

constexpr uint32_t kCpu = 16000000;  // cycles per second
constexpr float kTickUs = 0.5f;  // resolution of the clock [us]
constexpr uint16_t kTicksPerMs = 2000;
constexpr uint16_t kShortest = 500, kLongest = 4000;  // sample period: 4 kHz to 500 Hz [ticks]
constexpr uint8_t kQueue = 112;  // bytes in the send queue

// One sensor reading.
struct Sampling {
  uint16_t seq;      // counts every sample period, including skipped ones
  uint16_t raw;      // raw reading of the sensor
  uint8_t missed;    // sample periods skipped just before this one
  uint16_t ticks;    // of the clock, duration of the period that ended with this sample
  bool failed;       // the sensor's own check reports an invalid reading
};

// Initialise clock and serial port with the motor off. The hardware watchdog is active from now on.
void begin();

// Turn the motor off; then set up pins, timers and sensor for a kit. Main program only.
void configure(const protocol::Board& kit);

// While on, no reading is processed, so data of the sample interrupt may be changed. Main program only.
void hold(bool on);

// Set the sample period in ticks, from the next sample on.
void set_period(uint16_t ticks);

// Called once per sample period, from an interrupt that lets other interrupts through.
void on_sample(const Sampling& sampling);

// Time stamp of the sample that on_sample() is processing, for us_of().
uint32_t stamp();

// Board clock at a stamp [us]. Main program only, and at least every 17 minutes.
uint32_t us_of(uint32_t stamp);

// Time since a stamp [us].
uint16_t age_us();

// Take the next received byte; false if there is none.
bool read(uint8_t* byte);

// Reserve bytes in the queue; nullptr if there is no room now; send() transmits what was written
// there. Main program only.
uint8_t* room_for(uint8_t size);
void send(uint8_t* end);

// From now on a received byte, or wake() in an interrupt, ends the next sleep(), even if it comes before sleep();
// and sleep() returns at once while there is data to read.
void may_sleep();
void wake();
void sleep();

// Feed the hardware watchdog; a pause of 15 ms resets the board.
void pat();

// Reset cause: 1 power, 2 reset, 4 brown-out, 8 watchdog; 0 if the bootloader does not pass it on.
uint8_t reset_cause();

// Set the signed duty of the motor, -profile::kPwmTop..profile::kPwmTop, positive to the right.
void set_motor(int16_t pwm);

// Board clock in us.
uint32_t now_us();

// Received bytes that were lost or damaged so far; wraps.
uint8_t lost_bytes();

}  // namespace board
