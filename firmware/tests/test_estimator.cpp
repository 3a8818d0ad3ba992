// The velocity filter with coefficients and readings that only a fault can cause.
#include <random>

#include "check.h"
#include "estimator.h"
#include "protocol.h"

namespace {

constexpr float kCount = 20e-6f, kFastest = 5.0f;
constexpr int kMost = estimator::kMostCounts;

estimator::Design design(uint8_t method, float first, float second) {
  estimator::Design made{};
  CHECK(estimator::design({board::kTicksPerMs, method, first, second}, kCount, kFastest, &made));
  return made;
}

}  // namespace

// Run this with sanitizers: an unstable filter doubles its state within a few readings.
TEST(an_unstable_filter_has_no_undefined_behaviour) {
  std::mt19937 random(7);
  for (const float first : {0.0f, 1e-4f, 0.35f, 1.0f}) {
    for (const float second : {0.0f, 0.1f, 500.0f, 1990.0f}) {
      estimator::Design made = design(protocol::kEstimatorKalman, first, second);
      estimator::Estimator filter;
      int32_t count = 0;
      for (int k = 0; k < 2000; ++k) {
        count += static_cast<int>(random() % (2 * kMost + 1)) - kMost;
        filter.update(made, count);
        if (k % 100 == 0) filter.change();
      }
      filter.restart(count);
      made = design(protocol::kEstimatorDifference, 0.0f, 0.0f);
      CHECK(filter.update(made, count + 50));
      CHECK_NEAR(filter.velocity(made), 50 * kCount / 1e-3f, 1e-6f);
    }
  }
}
