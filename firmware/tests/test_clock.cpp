// The board's clock is tested over every wrap of its counters.
#include <random>

#include "check.h"
#include "clock.h"

TEST(the_clock_is_monotonic_over_every_wrap) {
  std::mt19937 random(3);
  Clock clock;
  int64_t ticks = 0;
  for (int i = 0; i < 20000; ++i) {
    // The clock is read after each sample, after a pause of up to 17 minutes, and for a sample older than the
    // last query.
    const auto far = static_cast<int64_t>(random() % 0x7fffffff);
    ticks += i % 10 ? 2001 : i % 20 ? far : -far;
    if (ticks < 0) ticks = 0;
    CHECK(clock.us_of(static_cast<uint32_t>(ticks)) == static_cast<uint32_t>(ticks / 2));
  }
}

TEST(the_clock_wraps_at_32_bits) {
  Clock clock;
  for (int64_t ticks = 0; ticks < INT64_C(6) << 32; ticks += 1999999999) {
    CHECK(clock.us_of(static_cast<uint32_t>(ticks)) == static_cast<uint32_t>(ticks / 2));
  }
}
