// What the program needs from the hardware. board_avr.cpp is the Hapkit; the tests bring their own.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace board {

constexpr float kTickUs = 0.5f;  // resolution of the clock [us]

// One reading of the sensor.
struct Sampling {
  uint16_t seq;      // counts every sample period, also those that had to be skipped
  uint32_t time_us;  // board clock when the sensor was sampled
  uint16_t raw;      // the sensor's reading itself
  bool overrun;      // sample periods were skipped just before this one
  bool failed;       // the sensor's own check says that the reading is wrong
};

// Set up pins, clock, sensor and serial port; the motor is off.
void begin();

// Motor off; then pins, timers and sensor as the kit needs them. Main program only.
void configure(const protocol::Board& kit);

// While on, no reading is handled: what the sample interrupt uses may change. Main program only.
void hold(bool on);

// Called once per sample period, from an interrupt that lets other interrupts through.
void on_sample(const Sampling& sampling);

// Take the next received byte; false if there is none.
bool read(uint8_t* byte);

// How many bytes can be queued for sending now.
uint8_t room();

// Queue bytes for sending, for which room was found. Only for the sample interrupt.
void send(const uint8_t* bytes, uint8_t size);

// Set the signed duty of the motor, -profile::kPwmTop..profile::kPwmTop, positive to the right.
void set_motor(int16_t pwm);

// Board clock in us.
uint32_t now_us();

// Received bytes that were lost or damaged so far; wraps.
uint8_t lost_bytes();

}  // namespace board
