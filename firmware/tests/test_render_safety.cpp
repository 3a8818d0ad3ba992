// The motor of a rendering board is switched off in time, and its force fades in again.
#include <cmath>
#include <functional>

#include "kits.h"
#include "motor.h"
#include "rendering.h"
#include "settings.h"

TEST(silence_switches_the_motor_off_within_25_ms_and_a_message_fades_it_in) {
  for (int rate : {500, 900, 1000, 1600, 2000, 3400, 4000}) {
    for (int words = 0; words < 2; ++words) {
      Rendering board(spring(300), rate);
      board.alive(60 * rate / 1000);
      if (words == 0) board.receive(protocol::Alive{});
      if (words == 1) board.receive(protocol::Force{0, 0, 1.0f});
      int ticks = 0;
      for (; fake::pwm != 0 && ticks < 1000; ++ticks) board.tick(kStill);
      // the message arrived at some time in the period before the first of these ticks
      CHECK(ticks * 1000.0 / rate <= 25.0 && (ticks - 1) * 1000.0 / rate >= 21.0);
      board.poll();
      fake::sent.clear();
      board.period(kStill);
      for (int wait = 0; fake::sent.empty() && wait < 4; ++wait) board.period(kStill);
      board.receive(protocol::Alive{});
      board.tick(kStill);
      const int16_t faint = fake::pwm;
      board.alive(60 * rate / 1000);
      CHECK(faint != 0 && std::abs(faint) * 2 < std::abs(fake::pwm));
    }
  }
}

TEST(the_force_fades_in_after_stop_and_release) {
  Rendering board(spring(300));
  board.alive(60);
  const int16_t full = fake::pwm;
  board.receive(protocol::Stop{});
  CHECK(fake::pwm == 0);
  board.alive(60);
  CHECK(fake::pwm == 0 && (board.shown().flags & protocol::kFlagStopped));
  board.receive(protocol::Release{});
  board.receive(protocol::Alive{});  // sent before the first tick after the end of the stop
  board.tick(kStill);
  CHECK(fake::pwm != 0 && std::abs(fake::pwm) * 2 < std::abs(full));
  board.alive(60);
  CHECK(fake::pwm == full);
}

TEST(over_speed_latches_until_release) {
  for (bool over : {false, true}) {
    Rendering board(spring(20));
    board.alive(60);
    const int fastest = static_cast<int>(5.0 / kQuantum / 1000.0 * (over ? 1.01 : 0.99));  // counts in a ms
    int count = kStill;
    bool reported = false;
    for (int tenths = 0; tenths <= 10; ++tenths) {
      const int step = fastest * tenths / 10;
      count += step;
      reported = reported || (board.shown(raw_of(count)).flags & protocol::kFlagOverSpeed);
      if (step < fastest * 0.95) CHECK(!reported);
    }
    CHECK(reported == over);
    for (int step = fastest; step > 0; step -= fastest / 10) board.shown(raw_of(count += step));
    board.alive(60, raw_of(count));
    CHECK((fake::pwm == 0) == over);
    board.receive(protocol::Release{});
    board.alive(60, raw_of(count));
    CHECK(fake::pwm != 0 && !(board.shown(raw_of(count)).flags & protocol::kFlagOverSpeed));
  }
}

TEST(a_clamped_force_is_reported) {
  Rendering board(spring(1000));
  board.alive(60);
  const auto shown = board.shown();
  CHECK(shown.asked < -3.0f && shown.flags == protocol::kFlagClamped);
  CHECK(fake::pwm == motor::duty_of(-3.0f).pwm && fake::pwm < 0);
}

// The counts jump by far more than a handle can move in a tick, and a tick may come at once.
TEST(a_change_of_zero_or_sense_is_not_measured_as_speed) {
  const std::function<void(protocol::Board&)> changes[] = {
      [](protocol::Board& kit) { kit.zero = 5000; },
      [](protocol::Board& kit) { kit.zero = -5000; },
      [](protocol::Board& kit) { kit.zero = 5000, kit.sense = -1; },
      [](protocol::Board& kit) { kit.counts_per_flip = 500; },
  };
  for (const auto& change : changes) {
    for (int ticks : {0, 1, 3}) {
      Rendering board(spring(20));
      board.alive(60);
      protocol::Board kit = settings::now();
      change(kit);
      fake::let_go = [&] {
        for (int i = 0; i < ticks; ++i) board.tick(kStill);
      };
      board.receive(kit);
      board.periods(3, kStill);
      board.change(spring(20), 2);
      board.alive(60);
      CHECK(!(board.shown().flags & protocol::kFlagOverSpeed));
      CHECK(fake::pwm != 0);
    }
  }
}
