#include "sensor.h"

#include "flip.h"

namespace sensor {
namespace {

// Within 5..95 % of the supply, a magnetoresistive reading is an angle. A reading at the rails means that the
// sensor is broken.
constexpr uint16_t kLowestReading = 8;
constexpr uint16_t kHighestReading = 1015;
constexpr uint16_t kAnyReading = 65535;

// The doubt increases by 4 with a doubtful reading and decreases by 1 with a good one; 8 doubtful readings in
// a row are a fault.
constexpr uint8_t kFault = 32;

uint8_t kind = protocol::kSensorMagnetoresistive;
uint16_t range = 0;       // range of the sensor in counts
int32_t zero = 0;     // count at the handle's zero, from the settings; a start uses it modulo range
bool started = false;
uint8_t doubt = 0;

FlipTracker flips;
uint16_t lowest = 0;          // smallest valid reading
uint16_t span = kAnyReading;  // range of the valid readings above lowest
bool wary = true;             // true before the start, or while in doubt
int8_t sense = 1;

// Return the distance in counts from the nearest position whose reading is that of the zero to the first
// reading.
int32_t ahead_of_zero(int32_t first) {
  if (kind == protocol::kSensorQuadrature) return 0;
  int32_t ahead = (first - zero) % range;
  if (ahead < 0) ahead += range;
  return ahead > range / 2 ? ahead - range : ahead;
}

void weigh(bool doubtful) {
  if (doubtful) {
    news = news | kDoubt;
    doubt = doubt < kFault - 4 ? doubt + 4 : kFault;
  } else {
    doubt -= doubt != 0;
  }
  if (doubt == kFault) news = news | kFaulty;
  if (!doubt) news = news & ~kFaulty;
  wary = doubt;
}

inline bool possible(uint16_t raw) { return static_cast<uint16_t>(raw - lowest) <= span; }

}  // namespace

volatile uint8_t news = kMoved;

void start(const protocol::Board& kit) {
  kind = kit.sensor;
  range = kit.counts_per_flip;
  sense = kit.sense;
  zero = kit.zero;
  const bool rails = kind == protocol::kSensorMagnetoresistive;
  lowest = rails ? kLowestReading : 0;
  span = rails ? kHighestReading - kLowestReading : kAnyReading;
  flips.start(kind == protocol::kSensorQuadrature ? 0 : range);
  started = false;
  doubt = 0;
  wary = true;
  news = kMoved;
}

void change(const protocol::Board& kit) {
  if (kit.sensor != kind || kit.counts_per_flip != range) return start(kit);
  flips.shift(zero - kit.zero);
  zero = kit.zero;
  sense = kit.sense;
  news = news | kMoved;
}

// Process a reading that does not continue the motion, or comes while in doubt; return the position before
// the sense is applied.
static int32_t consider(uint16_t raw, bool failed) {
  // a slip of an encoder's counter does not invalidate later readings
  const bool counted = kind == protocol::kSensorQuadrature;
  bool doubtful = true;
  if (possible(raw) && (!failed || counted)) {
    if (started) {
      flips.update(raw);
    } else {
      started = true;
      flips.begin(raw, ahead_of_zero(raw));
      news = news | kMoved;
    }
    doubtful = failed | flips.doubtful();
  }
  weigh(doubtful);
  return flips.position();
}

int32_t count(uint16_t raw, bool failed) {
  const bool plain = !failed && !wary && possible(raw) && flips.follow(raw);
  const int32_t position = plain ? flips.position() : consider(raw, failed);
  return sense < 0 ? -position : position;
}

}  // namespace sensor
