// Decides whether the motor may run. It must be off after an emergency stop, over-speed, a force that is not
// a finite number, a sensor fault, or silence of the computer.
#pragma once

#include <stdint.h>

#include "board.h"
#include "lock.h"
#include "protocol.h"

class Safety {
 public:
  // Record a force command with its flags from motor::duty_of; return true if the motor may apply it.
  bool command(uint8_t flags) {
    command_flags_ = flags;
    if (flags & protocol::kFlagRefused) return false;
    alive();
    return !(latched_ | sensor_);
  }

  // Record the flags of a force of the board's law; a force that is not finite ends the rendering.
  void rendered(uint8_t flags) {
    command_flags_ = flags & protocol::kFlagClamped;
    latched_ |= flags & protocol::kFlagRefused;
  }

  // Record that the computer has sent a message.
  void alive() {
    const Lock lock;
    patience_ = kPatience;
  }

  // Count a sample period in ticks of the clock. A message arrives at some time in its first period, so the
  // motor is switched off before the full time is over.
  void period(uint16_t ticks) {
    patience_ = patience_ < 2 * ticks ? 0 : patience_ - ticks;
  }

  // Forbid the motor to run until the next message.
  void expire() { patience_ = 0; }

  void stop() { latched_ |= protocol::kFlagStopped; }
  void over_speed() { latched_ |= protocol::kFlagOverSpeed; }
  void sensor(uint8_t flag) { sensor_ = flag; }  // protocol::kFlagSensor, or 0
  void refuse() { latched_ |= protocol::kFlagRefused; }
  void release() { latched_ &= protocol::kFlagRefused; }
  void accept() {
    latched_ &= ~protocol::kFlagRefused;
    command_flags_ = 0;
  }

  bool refused() const { return latched_ & protocol::kFlagRefused; }
  __attribute__((always_inline)) bool off() const { return (latched_ | sensor_) || !patience_; }

  uint8_t flags() const {
    return command_flags_ | latched_ | sensor_ | (!patience_ ? protocol::kFlagWatchdog : 0);
  }

 private:
  static constexpr uint16_t kPatience = 25 * board::kTicksPerMs;

  uint8_t command_flags_ = 0;
  uint8_t latched_ = 0;
  uint8_t sensor_ = 0;
  uint16_t patience_ = 0;  // remaining ticks until the motor is switched off
};
