// The flip tracker is compared with the true handle position: speed, noise, gaps at the sensor's wrap,
// impacts.
#include <cmath>
#include <initializer_list>
#include <random>

#include "check.h"
#include "flip.h"
#include "profile.h"

namespace {

constexpr int kCounts = 921;
constexpr double kHalf = kCounts / 2.0;

// Return the sensor's reading at a handle position in counts. It spans 5..95 % of the supply and repeats
// every half turn of the motor.
uint16_t reading(double counts) {
  return static_cast<uint16_t>(51.0 + counts - kCounts * std::floor(counts / kCounts));
}

FlipTracker begun(uint16_t first) {
  FlipTracker flips;
  flips.start(kCounts);
  flips.begin(first, first);
  return flips;
}

// Return the error in counts after a slow acceleration to a speed in counts per sample, followed by motion at
// this speed.
double error_at(double speed) {
  FlipTracker flips = begun(reading(0.5));
  const int32_t start = flips.position();
  double counts = 0.5;
  double now = 0.0;
  int32_t found = 0;
  for (int i = 0; i < 200; ++i) {
    now = std::fabs(speed) - std::fabs(now) > 10.0 ? now + std::copysign(10.0, speed) : speed;
    counts += now;
    found = flips.update(reading(counts)) - start;
  }
  return found - std::floor(counts);
}

// Records the errors over a sequence of readings, each with its true count.
class Judge {
 public:
  explicit Judge(double counts) : flips_(begun(reading(counts))), start_(flips_.position() - std::floor(counts)) {}

  void see(double counts, uint16_t raw) {
    last = std::fabs(flips_.update(raw) - start_ - std::floor(counts));
    worst = std::fmax(worst, last);
  }

  double worst = 0.0;
  double last = 0.0;

 private:
  FlipTracker flips_;
  double start_;
};

}  // namespace

TEST(flips_are_unwrapped_over_the_whole_range) {
  // 40 mm at 2 Hz are 0.5 m/s; the error must not grow with the number of wraps
  for (double rate : {230.0, 500.0, 1000.0, 4000.0}) {
    Judge judge(0.0);
    for (int i = 1; i < 3 * rate; ++i) {
      const double counts = 0.040 * std::sin(2.0 * M_PI * 2.0 * i / rate) / profile::kQuantum;
      judge.see(counts, reading(counts));
    }
    CHECK(judge.worst <= 1.0);
  }
}

TEST(half_the_range_per_sample_is_the_limit) {
  for (double sign : {-1.0, 1.0}) {
    CHECK_NEAR(error_at(sign * 0.99 * kHalf), 0.0, 1.0);
    CHECK(std::fabs(error_at(sign * 1.01 * kHalf)) > 100.0 * kCounts);
  }
}

TEST(the_first_reading_is_not_a_flip) {
  FlipTracker flips = begun(971);
  CHECK(flips.update(52) == 52 + kCounts);
  CHECK(flips.update(971) == 971);
}

TEST(noise_at_the_wrap_does_not_accumulate) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-3.0, 3.0);
  Judge judge(0.0);
  for (int i = 0; i < 200000; ++i) judge.see(0.0, reading(noise(random)));
  CHECK(judge.worst <= 4.0);
}

TEST(readings_in_the_gap_do_not_accumulate) {
  // The handle rests at the wrap, where the readings lie anywhere between both ends.
  for (double share : {0.01, 0.1}) {
    std::mt19937 random(2);
    std::uniform_int_distribution<int> gap(51, 971);
    std::bernoulli_distribution falls(share);
    std::uniform_real_distribution<double> noise(-2.0, 2.0);
    Judge judge(0.0);
    for (int i = 0; i < 100000; ++i) {
      const double counts = noise(random);
      judge.see(counts, falls(random) ? gap(random) : reading(counts));
      judge.see(counts, reading(counts));  // two readings in the gap never follow each other
    }
    judge.see(0.0, reading(0.0));
    CHECK(judge.last <= 4.0);
    CHECK(judge.worst <= kCounts / 4);
  }
}

TEST(every_reading_in_the_gap_at_every_speed_is_bridged) {
  for (int speed = -300; speed <= 300; speed += 25) {
    for (int gap = 51; gap <= 971; ++gap) {
      Judge judge(-60.0 * speed);
      for (int i = -59; i < 0; ++i) judge.see(i * speed, reading(i * speed));
      if (speed && judge.worst > 1.0) break;  // another test covers a start that is too fast
      judge.see(0.0, gap);
      for (int i = 1; i < 10; ++i) judge.see(i * speed, reading(i * speed));
      CHECK(judge.last <= 1.0);
      CHECK(judge.worst <= kCounts / 8 + std::abs(speed) + 1.0);
    }
  }
}

TEST(impacts_and_rebounds_are_followed) {
  // speed before the impact in counts per sample (48 are 1 m/s at 1 kHz), and the ratio of the speed after it
  for (double before : {50.0, 100.0, 150.0, 200.0}) {
    for (double after : {0.0, -0.2, -0.5}) {
      for (double at = 0.0; at < 1.0; at += 0.05) {
        double counts = 0.0;
        Judge judge(counts);
        for (int i = 1; i <= 60; ++i) {
          counts += before * (i < 40 ? i / 40.0 : i < 50 ? 1.0 : i == 50 ? at + (1.0 - at) * after : after);
          judge.see(counts, reading(counts));
        }
        CHECK(judge.last <= 1.0);
      }
    }
  }
}

TEST(an_impact_is_accepted_at_the_second_reading) {
  for (double speed : {-400.0, -200.0, 200.0, 400.0}) {
    Judge judge(0.5);
    for (int i = 1; i < 20; ++i) {
      judge.see(0.5 + i * speed, reading(0.5 + i * speed));
      if (i > 1) CHECK(judge.last <= 1.0);
    }
  }
}

TEST(the_ninth_doubtful_reading_is_accepted) {
  FlipTracker flips = begun(300);
  for (int i = 0; i < 8; ++i) {
    CHECK(flips.update(i % 2 ? 700 : 900) == 300);
    CHECK(flips.doubtful());
  }
  CHECK(flips.update(900) != 300);
  CHECK(!flips.doubtful());
}
