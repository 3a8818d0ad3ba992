#include "answers.h"

#include <stddef.h>
#include <string.h>

#include "board.h"
#include "build.h"
#include "machine.h"
#include "profile.h"
#include "settings.h"

void Answers::send(Sender& sender) {
  if ((wanted_ & kHello) && send_hello(sender)) wanted_ &= ~kHello;
  if ((wanted_ & kSettings) && !settings::saving() && send_settings(sender)) wanted_ &= ~kSettings;
}

bool Answers::send_hello(Sender& sender) {
  const protocol::Board& kit = settings::now();
  protocol::Hello hello;
  hello.version = protocol::kVersion;
  constexpr uint8_t kNumbers = offsetof(protocol::Hello, tick_us) - offsetof(protocol::Hello, quantum);
  static_assert(kNumbers == offsetof(protocol::Board, mass) - offsetof(protocol::Board, quantum),
                "Hello tells quantum to sector radius as Board does");
  memcpy(reinterpret_cast<uint8_t*>(&hello) + offsetof(protocol::Hello, quantum),
         reinterpret_cast<const uint8_t*>(&kit) + offsetof(protocol::Board, quantum), kNumbers);
  hello.tick_us = board::kTickUs;
  hello.counts_per_flip = kit.counts_per_flip;
  hello.sample_rate = profile::kSampleRate;
  hello.watchdog_ms = profile::kWatchdogMs;
  hello.pwm_top = profile::kPwmTop;
  hello.profile = kit.profile;
  hello.arena = machine::kArena;
  hello.origin = settings::origin();
  hello.reset = board::reset_cause();
  memset(hello.build, 0, sizeof(hello.build));
  memcpy(hello.build, HAPKIT_BUILD, sizeof(HAPKIT_BUILD) - 1);
  static_assert(sizeof(HAPKIT_BUILD) - 1 <= sizeof(hello.build), "the build's name is too long");
  return sender.send(hello);
}

bool Answers::send_settings(Sender& sender) {
  const uint8_t rest[] = {settings::origin(), refused_};
  static_assert(offsetof(protocol::Settings, origin) == sizeof(protocol::Board), "Settings begins as Board");
  static_assert(offsetof(protocol::Settings, refused) == sizeof(protocol::Board) + 1, "and ends with these two");
  return sender.send<protocol::Settings>(settings::now(), rest);
}
