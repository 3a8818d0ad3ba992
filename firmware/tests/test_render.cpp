// Rendering on the board: ramps, fades, refusals, telemetry.
#include "rendering.h"

TEST(a_law_is_rendered_and_reported_by_telemetry) {
  Rendering board(spring(100));
  board.alive(kFadeMs);
  const auto shown = board.shown(kStill + 100);
  CHECK(shown.generation == 1 && shown.seq == board.seq() && shown.time_us == fake::now_us);
  CHECK_NEAR(shown.asked, pull(100, shown.count), 1e-6);
  CHECK_NEAR(shown.velocity, 100 * kQuantum * 1000, 1e-6);
  CHECK(shown.flags == 0 && shown.pwm == fake::pwm && shown.overruns == 0);
  CHECK((shown.asked < 0) == (fake::pwm < 0));
}

TEST(the_force_fades_in_over_30_ms) {
  for (int rate : {500, 900, 1000, 1600, 2000, 3400, 4000}) {
    Rendering board;
    board.change(spring(400), 2, at(rate));
    board.period(kStill);  // this period still takes a millisecond
    const int ticks = kFadeMs * 2000 / at(rate).period;
    for (int tick = rate == 1000 ? 2 : 1; tick <= ticks; ++tick) {
      board.receive(protocol::Alive{});
      board.tick(kStill);
      const double force = pull(400, kStill) * tick * at(rate).period / (kFadeMs * 2000.0);
      const double pwm = 255.0 * std::sqrt(-force * 0.090 * 0.005 / 0.074 / 0.0183);
      CHECK_NEAR(-fake::pwm, std::fmin(pwm, 255.0), 1.0);
    }
  }
}

// A law uses its period, so it must not be called in a tick with a different length.
TEST(a_law_is_first_called_after_a_period_of_its_own_length) {
  for (int rate : {500, 900, 1000, 1600, 2000, 3400, 4000}) {
    Rendering board;
    board.change(counter(0), 2, at(rate));
    CHECK(machine::slots()[kFirst] == 0.0f);
    board.tick(kStill);  // the last period of a millisecond
    CHECK(machine::slots()[kFirst] == (rate == 1000 ? 1.0f : 0.0f));
    board.tick(kStill);
    CHECK(machine::slots()[kFirst] == (rate == 1000 ? 2.0f : 1.0f));
  }
}

TEST(a_law_fades_out_before_the_next_one_starts) {
  Rendering board(spring(200));
  board.alive(2 * kFadeMs);
  const int16_t full = fake::pwm;
  board.receive(head_of(spring(-200), 2, at(2000)));
  int before = std::abs(full);
  for (int ms = 1; ms <= kFadeMs; ++ms) {
    const auto shown = board.shown();
    CHECK(shown.generation == 1 && fake::pwm <= 0 && std::abs(fake::pwm) <= before);
    before = std::abs(fake::pwm);
  }
  CHECK(fake::pwm == 0);
  const auto sample = board.sample(kStill);
  CHECK(sample.generation == 2 && sample.received == 0 && sample.refusal == 0);
  board.send(spring(-200), 2);
  board.alive(4 * kFadeMs);
  CHECK(fake::pwm == -full);
}

TEST(constants_ramp_over_30_ms_in_steps_of_2_ms) {
  Rendering board(spring(100));
  board.alive(2 * kFadeMs);
  const int count = board.shown().count;
  board.receive(tune(1, 2, {{kFirst, -400.0f}}));
  for (int ms = 0; ms < kFadeMs; ++ms) {
    const auto shown = board.shown();
    CHECK_NEAR(shown.asked, pull(100.0 + 300.0 * (ms - ms % 2) / kFadeMs, count), 1e-4);
    CHECK(shown.generation == 2);
  }
  for (int ms = 0; ms < 5; ++ms) CHECK(board.shown().asked == static_cast<float>(count * 20.742975e-6f) * -400.0f);
}

TEST(constants_ramp_as_fast_at_a_slow_rate) {
  Rendering board(spring(100), 500);
  board.alive(2 * kFadeMs);
  board.receive(tune(1, 2, {{kFirst, -400.0f}}));
  for (int periods = 0; periods < kFadeMs / 2; ++periods) {
    CHECK_NEAR(machine::slots()[kFirst], -100.0 - 300.0 * periods / (kFadeMs / 2), 1e-3);
    board.shown();
  }
  CHECK(machine::slots()[kFirst] == -400.0f);
}

TEST(a_ramp_changes_to_the_newest_target) {
  Rendering board(spring(100));
  board.receive(tune(1, 2, {{kFirst, -400.0f}}));
  board.alive(10);
  const float there = machine::slots()[kFirst];
  CHECK_NEAR(there, -200.0f, 1e-3);
  board.receive(tune(1, 2, {{kFirst, -400.0f}}));  // the change is sent again, and the ramp continues
  board.alive(2);
  CHECK_NEAR(machine::slots()[kFirst], -220.0f, 1e-3);
  board.receive(tune(1, 3, {{kFirst, 80.0f}}));
  board.alive(kFadeMs / 2);
  CHECK_NEAR(machine::slots()[kFirst], (-220.0f + 80.0f) / 2, 15.0f);
  board.alive(kFadeMs / 2);
  CHECK(machine::slots()[kFirst] == 80.0f);
}

TEST(a_change_without_free_ramps_is_not_acknowledged) {
  constexpr uint8_t kMoving = 30;
  Law law{std::vector<float>(kMoving, 1.0f), {machine::kMain, machine::kLoad, kFirst, machine::kReturn}};
  // this leaves the smallest memory for ramps
  law.slots = (machine::kArena - 4 - machine::kRamps * machine::kRamp) / 4;
  const int room = (machine::kArena - 4 * law.slots - 4) / machine::kRamp;
  Rendering board;
  board.change(law, 1);
  board.alive(4);
  uint8_t generation = 1;
  int moving = 0;
  for (uint8_t first = 0; first < kMoving; first += 6) {
    protocol::Tune one = tune(1, static_cast<uint8_t>(generation + 1), {});
    for (uint8_t i = 0; i < 6; ++i) {
      one.slots[one.count] = kFirst + first + i;
      one.values[one.count++] = 2.0f;
    }
    board.receive(one);
    if (moving + one.count > room) break;
    moving += one.count;
    CHECK(board.shown().generation == ++generation);
  }
  CHECK(moving >= 6 && moving < kMoving);
  CHECK(board.shown().generation == generation);  // the message is ignored as a whole
  board.alive(kFadeMs + 2);
  for (int i = 0; i < kMoving; ++i) CHECK(machine::slots()[kFirst + i] == (i < moving ? 2.0f : 1.0f));
  board.receive(tune(1, static_cast<uint8_t>(generation + 1), {{static_cast<uint8_t>(kFirst + moving), 2.0f}}));
  CHECK(board.shown().generation == generation + 1);
}

TEST(changes_of_a_different_law_are_ignored) {
  Rendering board(spring(100));
  board.receive(tune(2, 3, {{kFirst, -400.0f}}));
  CHECK(board.shown().generation == 1);
  board.receive(protocol::Leave{});
  board.alive(2 * kFadeMs);
  board.receive(tune(1, 2, {{kFirst, -400.0f}}));
  board.alive(2 * kFadeMs);
  CHECK(machine::slots()[kFirst] == -100.0f);
}

TEST(ramps_end_with_their_law) {
  Rendering board(spring(100));
  board.receive(tune(1, 2, {{kFirst, -400.0f}}));
  board.alive(4);
  board.receive(protocol::Leave{});
  board.receive(protocol::Leave{});
  std::memset(machine::arena, 0xa5, sizeof(machine::arena));
  board.alive(2 * kFadeMs);
  for (uint8_t byte : machine::arena) CHECK(byte == 0xa5);
}

TEST(an_invalid_change_switches_the_motor_off_until_the_next_law) {
  const std::pair<uint8_t, float> wrong[] = {{0, 1.0f}, {1, 1.0f}, {kFirst, 1.0f}, {kFirst + 4, 1.0f}, {255, 1.0f},
                                             {kFirst + 2, NAN}, {kFirst + 2, INFINITY}};
  for (const auto& [slot, value] : wrong) {
    Law law = counter(0);
    law.given[3] = 1.0f;  // force in N
    Rendering board(law);
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm > 0);
    board.receive(tune(1, 2, {{kFirst + 3, 2.0f}, {slot, value}}));
    CHECK(fake::pwm == 0 && machine::slots()[kFirst + 3] == 1.0f);
    const auto shown = board.shown();
    CHECK((shown.flags & protocol::kFlagRefused) && shown.generation == 1 && shown.asked == 0.0f);
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm == 0);
    board.change(law, 3);
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm > 0 && board.shown().flags == 0);
  }
}

TEST(a_non_finite_force_ends_the_law) {
  Law law = spring(3e38);
  law.code.insert(law.code.end() - 1, {machine::kMultiply, kFirst});
  Rendering board;
  board.receive(head_of(law, 1, at(1000)));
  board.send(law, 1);
  const auto shown = board.shown();
  CHECK(!std::isfinite(shown.asked) && (shown.flags & protocol::kFlagRefused) && fake::pwm == 0);
  CHECK(board.shown().asked == 0.0f);
  board.change(spring(100), 2);
  board.alive(2 * kFadeMs);
  CHECK(fake::pwm != 0);
}

TEST(after_leave_the_motor_is_off_until_the_computers_first_force) {
  Rendering board(spring(300), 4000);
  board.alive(200);
  const int16_t full = fake::pwm;
  board.receive(protocol::Leave{});
  board.alive(kFadeMs * 2);
  CHECK(fake::pwm != 0 && std::abs(fake::pwm) < std::abs(full));
  board.alive(kFadeMs * 2 + 3);
  CHECK(fake::pwm == 0 && fake::ticks == board::kTicksPerMs);
  board.receive(protocol::Alive{});
  board.period(kStill);
  CHECK(fake::pwm == 0);
  board.receive(protocol::Force{board.seq(), 0, 1.0f});
  CHECK(fake::pwm > 0);
  board.sample(kStill);
}

TEST(a_second_leave_switches_the_motor_off_at_once) {
  Rendering board(spring(300));
  board.alive(200);
  board.receive(protocol::Leave{});
  board.shown();
  CHECK(fake::pwm != 0);
  board.receive(protocol::Leave{});
  CHECK(fake::pwm == 0);
  board.sample(kStill);
}

TEST(telemetry_is_sent_every_nth_tick_with_all_states_in_turn) {
  const std::pair<int, int> cases[] = {{500, 1},  {900, 1},  {1000, 1}, {1100, 2}, {1900, 2},
                                       {2000, 2}, {2100, 3}, {3000, 3}, {3400, 4}, {4000, 4}};
  for (const auto& [rate, ticks] : cases) {
    Rendering board(counter(0), rate);
    board.alive(10 * ticks);
    for (int i = 0; i < 10 * ticks; ++i) board.period(kStill);
    const auto bodies = fake::take_bodies();
    CHECK(bodies.size() == 10);
    uint8_t at = 255;
    for (const auto& body : bodies) {
      protocol::Telemetry shown{};
      std::memcpy(&shown, body.data() + 1, sizeof(shown));
      if (at != 255) CHECK(shown.state_at == (at + 1) % 2);
      at = shown.state_at;
      CHECK((shown.state > 0.0f) == (at == 0 || shown.state == 0.0f));
    }
  }
}

TEST(the_velocity_is_in_metres_per_second_at_every_rate_and_after_a_change) {
  for (int rate : {500, 900, 1600, 3400, 4000}) {
    Rendering board(counter(0), rate);
    int count = kStill;
    for (int i = 0; i < 40; ++i) {
      count += 3;
      board.receive(protocol::Alive{});
      board.period(raw_of(count));
    }
    protocol::Telemetry shown{};
    const auto bodies = fake::take_bodies();
    std::memcpy(&shown, bodies.back().data() + 1, sizeof(shown));
    CHECK_NEAR(shown.velocity, 3 * kQuantum * 2e6 / at(rate).period, 1e-5);
  }
}

TEST(ramps_take_20_to_45_ms_at_every_rate) {
  for (int rate : {500, 700, 900, 1000, 1100, 1600, 3400, 4000}) {
    Rendering board(spring(100), rate);
    board.alive(60 * rate / 1000);
    board.receive(tune(1, 9, {{kFirst, -300.0f}}));
    board.alive(20 * rate / 1000);
    CHECK(machine::slots()[kFirst] < -120.0f && machine::slots()[kFirst] > -300.0f);
    board.alive(25 * rate / 1000 + 4);
    CHECK(machine::slots()[kFirst] == -300.0f);
  }
}

TEST(skipped_ticks_and_the_mean_delay_are_reported) {
  Rendering board(spring(100), 4000);
  fake::age_us = 100;
  board.alive(200);
  board.tick(kStill, 2);  // two ticks were skipped
  board.poll();
  fake::sent.clear();
  uint16_t longest = 0;
  uint8_t overruns = 0;
  for (int i = 0; i < 8; ++i) {
    fake::age_us = i == 1 ? 333 : 100;
    board.period(kStill);
  }
  for (const auto& body : fake::take_bodies()) {
    protocol::Telemetry shown{};
    std::memcpy(&shown, body.data() + 1, sizeof(shown));
    longest = std::max(longest, shown.delay_us);
    overruns = shown.overruns;
  }
  CHECK(overruns == 2);
  CHECK(longest == (333 + 3 * 100) / 4);
}

TEST(a_frame_missed_by_the_main_program_is_reported) {
  Rendering board(spring(100));
  board.alive(40);
  board.receive(protocol::Alive{});
  board.tick(kStill);
  board.tick(kStill);
  fake::sent.clear();
  board.poll();
  CHECK(board.last<protocol::Telemetry>().flags & protocol::kFlagOverrun);
  CHECK(!(board.shown().flags & protocol::kFlagOverrun));
}
