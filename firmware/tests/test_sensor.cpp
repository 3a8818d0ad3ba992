// Counts of every sensor against where the handle is: flips, gaps, noise, faults, zero, sense.
#include <cmath>
#include <initializer_list>

#include "check.h"
#include "flip.h"
#include "profile.h"
#include "sensor.h"

namespace {

constexpr int kCounts = 921;

// What the sensor reads at a handle position in counts: 5..95 % of its supply, again every half motor turn.
uint16_t reading(double counts) { return static_cast<uint16_t>(51.0 + counts - 921.0 * std::floor(counts / 921.0)); }

FlipTracker fresh() {
  FlipTracker flips;
  flips.start(kCounts);
  return flips;
}

}  // namespace

TEST(flips_are_followed_across_the_whole_range) {
  // 40 mm at 2 Hz is 0.5 m/s; the error must not grow with the number of flips
  FlipTracker flips = fresh();
  const int32_t start = flips.update(reading(0.0));
  for (int i = 1; i < 3000; ++i) {
    const double counts = 0.040 * std::sin(2.0 * M_PI * 2.0 * i * 1e-3) / profile::kQuantum;
    CHECK_NEAR(flips.update(reading(counts)) - start, std::floor(counts), 1.0);
  }
}

TEST(first_reading_counts_no_flip) {
  FlipTracker flips = fresh();
  CHECK(flips.update(971) == 971);
  CHECK(flips.update(52) == 52 + 921);
  CHECK(flips.update(971) == 971);
}
