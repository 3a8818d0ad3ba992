// The hardware interface of the program. The files *_avr.cpp implement it for the Hapkit; tests have their
// own implementation.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace board {

constexpr uint32_t kCpu = 16000000;  // cycles per second
constexpr float kTickUs = 0.5f;  // resolution of the clock [us]
constexpr uint16_t kTicksPerMs = 2000;
constexpr uint16_t kShortest = 500, kLongest = 4000;  // sample periods at 4 kHz and at 500 Hz [ticks]
constexpr uint8_t kQueue = 112;  // bytes in the send queue

// One sensor reading.
struct Sampling {
  uint16_t seq;      // counts every sample period, also the skipped ones
  uint16_t raw;      // raw reading of the sensor
  uint8_t missed;    // number of sample periods skipped just before this sample
  uint16_t ticks;    // duration of the period that ended with this sample, in ticks of the clock
  bool failed;       // the sensor itself reports that the reading is invalid
};

// Initialise clock and serial port with the motor off. The hardware watchdog is active from here on.
void begin();

// Turn the motor off, then set up pins, timers and sensor for a kit. Call it only in the main program.
void configure(const protocol::Board& kit);

// While this is on, no reading is processed, so data of the sample interrupt may be changed. Call it only in
// the main program.
void hold(bool on);

// Set the sample period in ticks; it applies from the next sample on.
void set_period(uint16_t ticks);

// The board calls this once per sample period, from an interrupt during which other interrupts are enabled.
void on_sample(const Sampling& sampling);

// Return the time stamp of the sample that on_sample() is processing, for us_of().
uint32_t stamp();

// Return the board's clock at a stamp [us]. Call it only in the main program, and at least every 17 minutes.
uint32_t us_of(uint32_t stamp);

// Return the time since the present sample's stamp [us].
uint16_t age_us();

// Take the next received byte; return false if no byte is waiting.
bool read(uint8_t* byte);

// Reserve bytes in the queue, and return their address, or nullptr if the queue is too full. send() transmits
// what was written there. Call both only in the main program.
uint8_t* room_for(uint8_t size);
void send(uint8_t* end);

// From here on, a received byte, or wake() in an interrupt, ends the next sleep(), even if it comes before
// sleep(). sleep() also returns at once while there is data to read.
void may_sleep();
void wake();
void sleep();

// Feed the hardware watchdog; a pause of 15 ms resets the board.
void pat();

// Return the cause of the last reset: 1 power, 2 reset, 4 brown-out, 8 watchdog; 0 if the boot loader does
// not pass it on.
uint8_t reset_cause();

// Set the signed duty of the motor, from -profile::kPwmTop to profile::kPwmTop, positive to the right.
void set_motor(int16_t pwm);

// Return the board's clock in us.
uint32_t now_us();

// Return the number of received bytes that were lost or damaged so far; it wraps.
uint8_t lost_bytes();

}  // namespace board
