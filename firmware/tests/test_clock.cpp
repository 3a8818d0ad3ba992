// The board's clock over every wrap of what it counts.
#include <random>

#include "check.h"
#include "clock.h"

namespace {

constexpr int64_t kQuarterUs = 250, kPerUs = 2;

uint32_t stamp(int64_t quarters, uint16_t ticks) { return static_cast<uint32_t>(quarters) << 16 | ticks; }

}  // namespace

TEST(the_clock_goes_on_over_every_wrap) {
  std::mt19937 random(3);
  Clock clock;
  int64_t quarters = 0;
  for (int i = 0; i < 20000; ++i) {
    // after each sample, after a pause of up to 8 s, for an older sample than was asked for last
    quarters += i % 10 ? 4 : i % 20 ? static_cast<int64_t>(random() % 32768) : -static_cast<int64_t>(random() % 32769);
    if (quarters < 0) quarters = 0;
    const auto ticks = static_cast<uint16_t>(random() % 8000);
    CHECK(clock.us_of(stamp(quarters, ticks)) == static_cast<uint32_t>(quarters * kQuarterUs + ticks / kPerUs));
  }
}

TEST(the_clock_wraps_at_32_bits) {
  Clock clock;
  int64_t quarters = 0;
  for (; quarters * kQuarterUs < INT64_C(3) << 32; quarters += 30000) {
    CHECK(clock.us_of(stamp(quarters, 7999)) == static_cast<uint32_t>(quarters * kQuarterUs + 7999 / kPerUs));
  }
}
