// What the board renders by itself: scenes, ramps, fades, refusals, telemetry.
#include "rendering.h"

TEST(every_law_has_a_name_of_its_own) {
  std::string seen = "|";
  protocol::LawName name{};
  for (uint8_t law = 0; law < render::count(); ++law) {
    CHECK(render::describe(law, &name));
    const std::string key(name.key, strnlen(name.key, sizeof(name.key)));
    CHECK(!key.empty() && name.law == law && name.parameters <= protocol::kValues);
    CHECK(name.states <= protocol::kValues);
    CHECK(seen.find("|" + key + "|") == std::string::npos);
    seen += key + "|";
  }
  CHECK(!render::describe(render::count(), &name));
  CHECK(!render::describe(protocol::kNoLaw, &name));
}

TEST(law_names_are_told_over_the_wire) {
  Bench bench;
  bench.say(protocol::LawRequest{number_of("wall")});
  bench.poll();
  const auto name = bench.last<protocol::LawName>();
  CHECK(std::strncmp(name.key, "wall", sizeof(name.key)) == 0 && name.parameters == 5);
  bench.say(protocol::LawRequest{99});
  bench.poll();
  const auto none = bench.last<protocol::LawName>();
  CHECK(none.law == 99 && none.key[0] == 0);
}

TEST(a_scene_is_rendered_and_told) {
  Rendering board(scene("spring", 7, 100, 0, 0));
  board.alive(kFadeMs);
  const auto shown = board.shown(kRest + 100);
  CHECK(shown.generation == 7 && shown.seq == board.seq() && shown.time_us == fake::now_us);
  CHECK_NEAR(shown.asked, pull(100, shown.count), 1e-6);
  CHECK_NEAR(shown.velocity, 100 * kQuantum * 1000, 1e-6);
  CHECK(shown.flags == 0 && shown.pwm == fake::pwm && shown.overruns == 0);
  CHECK((shown.asked < 0) == (fake::pwm < 0));
}

TEST(the_force_fades_in_over_30_ms) {
  for (uint16_t rate : {500, 1000, 2000, 4000}) {
    Rendering board(scene("damping", 1, 0), rate);
    board.alive(200);
    board.say(scene("spring", 2, 400, 0, 0));
    const int ticks = kFadeMs * rate / 1000;
    for (int tick = 1; tick <= ticks; ++tick) {
      board.say(protocol::Alive{});
      board.tick(kRest);
      const double force = pull(400, kRest) * tick / ticks;
      const double pwm = 255.0 * std::sqrt(-force * 0.090 * 0.005 / 0.074 / 0.0183);
      CHECK_NEAR(-fake::pwm, std::fmin(pwm, 255.0), 1.0);
    }
  }
}

TEST(numbers_of_the_same_law_move_over_30_ms_every_other_one) {
  Rendering board(scene("spring", 1, 100, 0, 0));
  board.alive(2 * kFadeMs);
  const int count = board.shown().count;
  board.say(scene("spring", 2, 400, 0, 0));
  for (int ms = 0; ms < kFadeMs; ++ms) {
    const auto shown = board.shown();
    CHECK_NEAR(shown.asked, pull(100.0 + 300.0 * (ms - ms % 2) / kFadeMs, count), 1e-4);
    CHECK(shown.generation == 2);
  }
  CHECK_NEAR(board.shown().asked, pull(400, count), 1e-6);
  CHECK_NEAR(board.shown().asked, pull(400, count), 1e-6);
}

TEST(another_choice_begins_anew_from_zero) {
  Rendering board(scene("wall", 1, 200, 0, 0, 0, 0));
  board.alive(2 * kFadeMs);
  CHECK(fake::pwm < 0);
  board.say(scene("wall", 2, 200, 0, 0, 0, 1));
  board.tick(kRest);
  const int16_t faint = fake::pwm;
  board.alive(2 * kFadeMs);
  CHECK(faint <= 0 && -faint < -fake::pwm / 3);  // sqrt(1 / 30) of the duty, at most
}

TEST(state_stays_where_numbers_move_and_begins_anew_with_another_scene) {
  Rendering board(scene("button", 1, 1, 0.5, 0.004, 0.007, 500, 0.1, 0.0));
  board.alive(10);  // deeper than the middle of the snap
  float downs = -1.0f;
  const auto watch = [&](uint16_t raw) {
    for (int i = 0; i < 8; ++i) {
      const auto shown = board.shown(raw);
      if (shown.state_at == 3) downs = shown.state;
    }
  };
  watch(kRest);
  CHECK(downs == 1.0f);
  board.say(scene("button", 2, 1.2, 0.5, 0.004, 0.007, 500, 0.1, 0.0));
  watch(kRest);
  CHECK(downs == 1.0f);
  board.say(scene("free", 3));
  board.shown();
  board.say(scene("button", 4, 1, 0.5, 0.004, 0.007, 500, 0.1, 0.03));
  watch(kRest);
  CHECK(downs == 0.0f);
}

TEST(what_is_no_scene_is_refused) {
  for (int which = 0; which < 4; ++which) {
    Rendering board(scene("spring", 1, 200, 0, 0));
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm != 0);
    auto bad = scene("spring", 2, 200, 0, 0);
    if (which == 0) bad.law = render::count();
    if (which == 1) bad.values[1] = NAN;
    if (which == 2) bad.values[2] = INFINITY;
    if (which == 3) bad.values[0] = -INFINITY;
    board.say(bad);
    CHECK(fake::pwm == 0);
    const auto shown = board.shown();
    CHECK((shown.flags & protocol::kFlagRefused) && shown.generation == 1 && shown.asked == 0.0f);
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm == 0);
    board.say(scene("spring", 3, 200, 0, 0));
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm != 0 && board.shown().flags == 0);
  }
}

TEST(values_behind_the_laws_own_are_not_looked_at) {
  Rendering board(scene("spring", 1, 200, 0, 0));
  auto good = scene("spring", 2, 200, 0, 0);
  good.values[3] = NAN;
  board.say(good);
  CHECK(board.shown().flags == 0);
}

TEST(a_force_that_is_not_finite_ends_the_scene) {
  Rendering board(scene("free", 1));
  board.say(scene("spring", 1, 3e38, 0, -1e6));
  const auto shown = board.shown();
  CHECK(!std::isfinite(shown.asked) && (shown.flags & protocol::kFlagRefused) && fake::pwm == 0);
  CHECK(board.shown().asked == 0.0f);
  board.say(scene("spring", 2, 100, 0, 0));
  board.alive(2 * kFadeMs);
  CHECK(fake::pwm != 0);
}

TEST(leaving_the_rendering_to_the_computer_switches_off_until_its_force) {
  Rendering board(scene("spring", 1, 300, 0, 0), 4000);
  board.alive(200);
  board.say(protocol::Scene{protocol::kNoLaw, 9, {}});
  board.alive((kFadeMs + 3) * 4);
  CHECK(fake::pwm == 0 && fake::quarters == 4);
  board.say(protocol::Alive{});
  board.period(kRest);
  CHECK(fake::pwm == 0);
  board.say(protocol::Force{0, 1.0f});
  CHECK(fake::pwm > 0);
  board.sample(kRest);
}

TEST(telemetry_comes_every_millisecond_and_its_states_take_turns) {
  for (uint16_t rate : {1000, 2000, 4000}) {
    Rendering board(scene("friction", 1, 0, 1, 0.5, 0.01, 0.01, 800, 0), rate);
    board.alive(10 * rate / 1000);
    for (int i = 0; i < 10 * rate / 1000; ++i) board.period(kRest);
    const auto bodies = fake::take_bodies();
    CHECK(bodies.size() == 10);
    uint8_t at = 255;
    for (const auto& body : bodies) {
      protocol::Telemetry shown{};
      std::memcpy(&shown, body.data() + 1, sizeof(shown));
      if (at != 255) CHECK(shown.state_at == (at + 1) % 4);
      at = shown.state_at;
    }
  }
}

TEST(skipped_ticks_and_the_mean_delay_are_told) {
  Rendering board(scene("spring", 1, 100, 0, 0), 4000);
  fake::age_us = 100;
  board.alive(200);
  board.tick(kRest, 2);  // two were skipped
  board.poll();
  fake::sent.clear();
  uint16_t longest = 0;
  uint8_t overruns = 0;
  for (int i = 0; i < 8; ++i) {
    fake::age_us = i == 1 ? 333 : 100;
    board.period(kRest);
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

TEST(a_frame_that_the_main_program_missed_is_told) {
  Rendering board(scene("spring", 1, 100, 0, 0));
  board.alive(40);
  board.say(protocol::Alive{});
  board.tick(kRest);
  board.tick(kRest);
  fake::sent.clear();
  board.poll();
  CHECK(board.last<protocol::Telemetry>().flags & protocol::kFlagOverrun);
  CHECK(!(board.shown().flags & protocol::kFlagOverrun));
}

TEST(a_loop_that_no_board_has_is_refused) {
  Rendering board(scene("spring", 1, 300, 0, 0));
  board.alive(60);
  for (const auto& bad : {protocol::Loop{999, 0, 0, 0}, protocol::Loop{1000, 3, 0, 0},
                          protocol::Loop{1000, 1, NAN, 0}, protocol::Loop{1000, 1, 1.01f, 0},
                          protocol::Loop{1000, 2, 0.5f, 2000}, protocol::Loop{1000, 2, -0.1f, 0}}) {
    board.say(bad);
    CHECK(fake::pwm == 0 && (board.shown().flags & protocol::kFlagRefused));
    board.say(scene("spring", 1, 300, 0, 0));
    board.alive(60);
    CHECK(fake::pwm != 0);
  }
}

TEST(another_rate_changes_the_velocity_by_no_jump) {
  Rendering board(scene("damping", 1, 10));
  int raw = 100;
  for (int i = 0; i < 60; ++i) board.shown(static_cast<uint16_t>(raw += 4));
  const float before = board.shown(static_cast<uint16_t>(raw += 4)).velocity;
  board.say(protocol::Loop{2000, protocol::kEstimatorIir, 0.1f, 0.0f});
  board.tick(static_cast<uint16_t>(raw += 4));  // the last one a millisecond after the one before
  for (int i = 0; i < 8; ++i) {
    board.poll();
    fake::sent.clear();
    board.tick(static_cast<uint16_t>(raw += 2));
    board.poll();
    for (const auto& body : fake::take_bodies()) {
      protocol::Telemetry shown{};
      std::memcpy(&shown, body.data() + 1, sizeof(shown));
      CHECK_NEAR(shown.velocity, before, 1e-5);
    }
  }
}
