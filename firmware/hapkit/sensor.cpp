#include "sensor.h"

#include "flip.h"

namespace sensor {
namespace {

// Within 5..95 % of its supply a magnetoresistive sensor tells an angle; at the rails something is broken.
constexpr uint16_t kLowestReading = 8;
constexpr uint16_t kHighestReading = 1015;

// Doubt grows by 4 with a doubtful reading and shrinks by 1 with a good one: 8 in a row are a fault.
constexpr uint8_t kFault = 32;

FlipTracker flips;
uint8_t kind = protocol::kSensorMagnetoresistive;
uint16_t range = 0;       // counts from one repeat of the sensor to the next
int8_t sense = 1;
int32_t zero_number = 0;  // the zero as the settings write it
int32_t zero = 0;         // and its repeat that is in use
bool started = false;
volatile bool moved = true;  // the counts have, not the handle
int32_t position = 0;     // before sense and zero
uint8_t doubt = 0;
bool doubted = false;
bool at_fault = false;

// The repeat of the settings' zero that lies nearest to the first reading.
int32_t nearest_zero(int32_t first) {
  if (kind == protocol::kSensorQuadrature) return first;
  int32_t ahead = (first - zero_number) % range;
  if (ahead < 0) ahead += range;
  return ahead > range / 2 ? first - ahead + range : first - ahead;
}

void weigh(bool doubtful) {
  if (doubtful) {
    doubted = true;
    doubt = doubt < kFault - 4 ? doubt + 4 : kFault;
  } else if (doubt) {
    --doubt;
  }
  if (doubt == kFault) at_fault = true;
  if (!doubt) at_fault = false;
}

bool broken(uint16_t raw) {
  if (kind != protocol::kSensorMagnetoresistive) return false;
  return raw < kLowestReading || raw > kHighestReading;
}

}  // namespace

void start(const protocol::Board& kit) {
  kind = kit.sensor;
  range = kit.counts_per_flip;
  sense = kit.sense;
  zero_number = kit.zero;
  flips.start(kind == protocol::kSensorQuadrature ? 0 : range);
  started = false;
  moved = true;
  position = 0;
  zero = 0;
  doubt = 0;
  doubted = at_fault = false;
}

void change(const protocol::Board& kit) {
  if (kit.sensor != kind || kit.counts_per_flip != range) return start(kit);
  zero += kit.zero - zero_number;
  zero_number = kit.zero;
  sense = kit.sense;
  moved = true;
}

int32_t count(uint16_t raw, bool failed) {
  const bool counted = kind == protocol::kSensorQuadrature;  // a slip of its counter does not spoil the rest
  const bool useless = (failed && !counted) || broken(raw);
  if (!useless) {
    position = flips.update(raw);
    if (!started) {
      zero = nearest_zero(position);
      moved = started = true;
    }
  }
  weigh(useless || failed || flips.doubtful());
  const int32_t from_zero = position - zero;
  return sense < 0 ? -from_zero : from_zero;
}

bool take_moved() {
  const bool taken = moved;
  moved = false;
  return taken;
}

bool take_doubt() {
  const bool taken = doubted;
  doubted = false;
  return taken;
}

bool faulty() { return at_fault; }

}  // namespace sensor
