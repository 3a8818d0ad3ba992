// Decides what the motor may do: emergency stop, watchdog, refused commands.
#pragma once

#include <stdint.h>

#include "profile.h"
#include "protocol.h"

class Safety {
 public:
  // Note a force command with its flags from motor::limit; return whether the motor may follow it.
  bool command(uint8_t flags) {
    command_flags_ = flags;
    if (flags & protocol::kFlagRefused) return false;
    silence_ = 0;
    return !stopped_;
  }

  // Count one sample period; return whether the silence has just become too long.
  bool period() {
    if (silence_ >= kPatience) return false;
    return ++silence_ == kPatience;
  }

  // Take the right to drive away until the next valid command.
  void expire() { silence_ = kPatience; }

  void stop() { stopped_ = true; }
  void release() { stopped_ = false; }

  uint8_t flags() const {
    return command_flags_ | (silence_ >= kPatience ? protocol::kFlagWatchdog : 0) |
           (stopped_ ? protocol::kFlagStopped : 0);
  }

 private:
  // A command falls somewhere into its first period, so the motor is off before the full time is over.
  static constexpr uint8_t kPatience = profile::kWatchdogMs * 1000UL / profile::kPeriodUs;

  uint8_t command_flags_ = 0;
  uint8_t silence_ = kPatience;
  bool stopped_ = false;
};
