#include "estimator.h"

namespace estimator {
namespace {

// A coefficient as Design has it; 0 <= value < 2.
uint32_t half(float value) { return static_cast<uint32_t>(value * 2147483648.0f); }

// Of a millisecond in a period; 0 for a rate that no loop has.
uint8_t quarters_of(uint16_t rate) {
  return rate == 4000 ? 1 : rate == 2000 ? 2 : rate == 1000 ? 4 : rate == 500 ? 8 : 0;
}

}  // namespace

bool design(const protocol::Loop& loop, float quantum, float fastest, Design* made) {
  const uint8_t quarters = quarters_of(loop.rate);
  const float period = quarters * 0.25e-3f;
  const bool kalman = loop.estimator == protocol::kEstimatorKalman;
  const float first = loop.estimator == protocol::kEstimatorDifference ? 1.0f : loop.first;
  const float second = kalman ? loop.second * period : first;
  const bool sane = first >= 0.0f && first <= 1.0f && second >= 0.0f && second < 2.0f;
  if (!sane || quarters == 0 || loop.estimator > protocol::kEstimatorKalman) return false;
  made->quarters = quarters;
  made->first = half(kalman ? first : 1.0f);
  made->second = half(second);
  made->scale = quantum / (period * kOne);
  made->quantum = quantum;
  const float limit = fastest * period / quantum;
  made->fastest = limit < kMostCounts ? static_cast<int16_t>(limit) + 1 : kMostCounts;
  return true;
}

}  // namespace estimator
