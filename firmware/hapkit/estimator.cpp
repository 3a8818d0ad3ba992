#include "estimator.h"

#include "protocol.h"

namespace estimator {
namespace {

constexpr uint32_t kWhole = 0x80000000;
constexpr uint32_t kNone = 0xffffffff;

// A coefficient as Design has it; kNone unless 0 <= value < 2.
uint32_t half(float value) {
  return value >= 0.0f && value < 2.0f ? static_cast<uint32_t>(value * 2147483648.0f) : kNone;
}

// Of a millisecond in a period; 0 for a rate that no loop has.
uint8_t quarters_of(uint16_t rate) {
  uint16_t fitting = 4000;
  for (uint8_t quarters = 1; quarters <= 8; quarters <<= 1, fitting >>= 1) {
    if (rate == fitting) return quarters;
  }
  return 0;
}

}  // namespace

bool design(const Loop& loop, float quantum, float fastest, Design* made) {
  const uint8_t quarters = quarters_of(loop.rate);
  const float period = quarters * 0.25e-3f;
  if (quarters == 0 || loop.estimator > protocol::kEstimatorKalman) return false;
  uint32_t first = kWhole, second = kWhole;
  if (loop.estimator != protocol::kEstimatorDifference) {
    first = second = half(loop.first);
    if (first > kWhole) return false;
    if (loop.estimator == protocol::kEstimatorKalman) second = half(loop.second * period);
    else first = kWhole;
    if (second == kNone) return false;
  }
  made->quarters = quarters;
  made->first = first;
  made->second = second;
  made->scale = quantum / (period * kOne);
  made->quantum = quantum;
  const float limit = fastest * period / quantum;
  made->fastest = limit < kMostCounts ? static_cast<int16_t>(limit) + 1 : kMostCounts;
  return true;
}

}  // namespace estimator
