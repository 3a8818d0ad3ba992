// Messages go in, and motor commands and frames come out; the test sets the clock.
#include <cmath>
#include <initializer_list>
#include <cstring>

#include "bench.h"
#include "check.h"
#include "fake_board.h"
#include "profile.h"
#include "settings.h"
#include "ring.h"

namespace {

constexpr int kWatchdogPeriods = 25;

// Return a force that answers the newest sample.
protocol::Force force(const Bench& bench, float newtons) { return {bench.seq(), 0, newtons}; }

}  // namespace

TEST(no_frame_is_sent_without_a_request) {
  Bench bench;
  bench.periods(100);
  CHECK(fake::sent.empty());
  CHECK(fake::pwm == 0);
}

TEST(hello_contains_the_constants) {
  Bench bench;
  bench.receive(protocol::HelloRequest{});
  bench.period();
  const auto hello = bench.last<protocol::Hello>();
  CHECK(hello.version == protocol::kVersion);
  CHECK(hello.quantum == profile::kQuantum);
  CHECK(hello.max_force == 3.0f);
  CHECK(hello.sample_rate == 1000 && hello.watchdog_ms == 25 && hello.pwm_top == 255);
  CHECK(std::strncmp(hello.build, "test", sizeof(hello.build)) == 0);
  bench.period();
  CHECK(fake::sent.empty());  // one reply is enough
}

TEST(hello_is_sent_when_the_queue_has_room) {
  Bench bench;
  fake::room = 10;
  bench.receive(protocol::HelloRequest{});
  bench.period();
  CHECK(fake::sent.empty());
  fake::room = 127;
  bench.period();
  bench.last<protocol::Hello>();
}

TEST(samples_while_the_stream_is_on) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  const auto sample = bench.sample(60);
  CHECK(sample.seq == bench.seq() && sample.time_us == fake::now_us && sample.count == 60);
  CHECK(sample.flags == protocol::kFlagWatchdog && sample.pwm == 0 && sample.delay_us == 0);
  CHECK(bench.sample(970).count == 970 - 921);
  bench.receive(protocol::Stream{0, 0});
  fake::sent.clear();
  bench.period();
  CHECK(fake::sent.empty());
}

TEST(force_drives_the_motor_and_measures_its_delay) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.periods(5);
  const uint16_t answered = static_cast<uint16_t>(bench.seq() - 2);
  fake::now_us += 700;
  bench.receive(protocol::Force{static_cast<uint16_t>(bench.seq() - 1), 1, -1.0f});
  const double expected = -255.0 * std::sqrt(0.090 * 0.005 / 0.074 / 0.0183);
  CHECK_NEAR(fake::pwm, expected, 0.75);
  const auto sample = bench.sample();
  CHECK(sample.answered == answered && sample.delay_us == 2700);
  CHECK(sample.pwm == fake::pwm && sample.flags == 0);
}

TEST(an_unknown_delay_is_the_largest_value) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.period();
  bench.receive(protocol::Force{bench.seq(), 100, 0.5f});
  CHECK(bench.sample().delay_us == 65535);
}

TEST(a_force_older_than_the_watchdogs_time_is_refused_and_counted) {
  for (int age : {-1, 0, kWatchdogPeriods, kWatchdogPeriods + 1, 300, 3000}) {
    Bench bench;
    bench.receive(protocol::Stream{1, 0});
    bench.periods(5);
    bench.receive(force(bench, 1.0f));
    const int16_t before = fake::pwm;
    const bool stale = age < 0 || age > kWatchdogPeriods;
    for (uint8_t count = 1; count <= 10; ++count) {
      bench.receive(protocol::Force{static_cast<uint16_t>(bench.seq() - age), 0, -2.0f});
      CHECK((fake::pwm == before) == stale);
      const auto sample = bench.sample();
      CHECK(sample.stale == (stale ? count : 0) && (sample.delay_us == 65535 || !stale || sample.delay_us == 0));
    }
    bench.periods(kWatchdogPeriods - 10);
    CHECK((fake::pwm == 0) == stale);  // a stale force does not count as a message of the computer
  }
}

TEST(a_zero_force_is_never_too_old) {
  for (float nothing : {0.0f, -0.0f}) {
    Bench bench;
    bench.receive(protocol::Stream{1, 0});
    bench.receive(force(bench, 1.0f));
    CHECK(fake::pwm > 0);
    bench.receive(protocol::Force{static_cast<uint16_t>(bench.seq() - 3000), 0, nothing});
    CHECK(fake::pwm == 0 && bench.sample().stale == 0);
  }
}

TEST(a_clamped_force_sets_the_flag) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.receive(force(bench, 99.0f));
  CHECK(fake::pwm == 255);
  CHECK(bench.sample().flags == protocol::kFlagClamped);
  bench.receive(force(bench, 1.0f));
  CHECK(bench.sample().flags == 0);
}

TEST(a_nan_force_switches_the_motor_off_at_once) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.receive(force(bench, 1.0f));
  bench.receive(force(bench, std::nanf("")));
  CHECK(fake::pwm == 0);
  CHECK(bench.sample().flags == protocol::kFlagRefused);
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm > 0);
}

TEST(silence_switches_the_motor_off_within_the_watchdog_time) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.receive(force(bench, 1.0f));
  bench.periods(kWatchdogPeriods - 1);
  CHECK(fake::pwm > 0);
  CHECK(bench.sample().flags == protocol::kFlagWatchdog);
  CHECK(fake::pwm == 0);
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm > 0);  // the force continues without a further command
  CHECK(bench.sample().flags == 0);
}

TEST(refused_and_damaged_commands_do_not_feed_the_watchdog) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm > 0);
  std::vector<uint8_t> damaged = fake::frame_of(fake::body_of(force(bench, 1.5f)));
  damaged[2] ^= 0x40;
  const int16_t before = fake::pwm;
  for (int i = 0; i < kWatchdogPeriods - 1; ++i) {
    bench.say_bytes(damaged);
    bench.period();
    CHECK(fake::pwm == before);
  }
  bench.period();
  CHECK(fake::pwm == 0);
  CHECK(bench.sample().rx_errors == kWatchdogPeriods - 1);
}

TEST(commands_in_time_keep_the_motor_on) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  for (int i = 0; i < 10; ++i) {
    bench.receive(force(bench, 1.0f));
    bench.periods(kWatchdogPeriods - 1);
    CHECK(fake::pwm > 0);
  }
}

TEST(stop_latches_until_release) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.receive(force(bench, 1.0f));
  bench.receive(protocol::Stop{});
  CHECK(fake::pwm == 0);
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm == 0);
  CHECK(bench.sample().flags & protocol::kFlagStopped);
  bench.receive(protocol::Release{});
  CHECK(fake::pwm == 0);  // only a new command switches the motor on
  CHECK(bench.sample().flags == protocol::kFlagWatchdog);
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm > 0);
}

TEST(a_command_before_the_stream_starts_is_ignored) {
  Bench bench;
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm == 0);
  bench.receive(protocol::Stream{1, 0});
  CHECK(bench.sample().flags == protocol::kFlagWatchdog);
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm > 0);
}

TEST(stream_off_switches_the_motor_off) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  bench.receive(force(bench, 1.0f));
  CHECK(fake::pwm > 0);
  bench.receive(protocol::Stream{0, 0});
  CHECK(fake::pwm == 0);
}

TEST(messages_of_wrong_size_or_id_are_ignored) {
  Bench bench;
  bench.receive(force(bench, 1.0f));
  const int16_t before = fake::pwm;
  bench.say_bytes(fake::frame_of({protocol::Force::kId, 1, 2, 3}));
  bench.say_bytes(fake::frame_of({protocol::Stream::kId}));
  bench.say_bytes(fake::frame_of({protocol::Stop::kId, 0}));
  bench.say_bytes(fake::frame_of({0x77, 1, 2, 3, 4, 5, 6}));
  bench.say_bytes(fake::frame_of({0}));
  CHECK(fake::pwm == before);
}

TEST(an_overrun_is_reported_once) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  CHECK(bench.sample(500, true).flags & protocol::kFlagOverrun);
  CHECK(!(bench.sample().flags & protocol::kFlagOverrun));
  fake::room = 5;
  bench.period();
  CHECK(fake::sent.empty());
  fake::room = 127;
  CHECK(bench.sample().flags & protocol::kFlagOverrun);
  CHECK(!(bench.sample().flags & protocol::kFlagOverrun));
}

TEST(lost_bytes_are_reported) {
  Bench bench;
  bench.receive(protocol::Stream{1, 0});
  fake::lost = 7;
  CHECK(bench.sample().rx_errors == 7);
}

TEST(ring_keeps_order_and_refuses_when_full) {
  Ring<8> ring;
  uint8_t next_in = 0;
  uint8_t next_out = 0;
  for (int turn = 0; turn < 100; ++turn) {
    while (ring.push(next_in)) ++next_in;
    CHECK(!ring.push(99));
    uint8_t byte;
    CHECK(ring.pop(&byte) && byte == next_out++);
    CHECK(ring.pop(&byte) && byte == next_out++);
    CHECK(ring.push(next_in++) && ring.push(next_in++));
    for (int i = 0; i < 1 + turn % 7; ++i) CHECK(ring.pop(&byte) && byte == next_out++);
  }
  uint8_t byte;
  while (ring.pop(&byte)) CHECK(byte == next_out++);
  CHECK(next_in == next_out && ring.empty());
}
