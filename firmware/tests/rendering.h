// What the tests of the board's own rendering share: scenes by name, a board that renders one.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "bench.h"
#include "check.h"
#include "render.h"

constexpr uint16_t kRest = 400;            // reading of a handle at rest, 8.3 mm to the right
constexpr int kFadeMs = 30;
constexpr double kQuantum = 20.742975e-6;  // m per count: pi * 0.090 * 0.005 / (0.074 * 921)

inline uint8_t number_of(const char* key) {
  protocol::LawName name{};
  for (uint8_t law = 0; render::describe(law, &name); ++law) {
    if (std::strncmp(name.key, key, sizeof(name.key)) == 0) return law;
  }
  CHECK(!"no such law");
  return 0;
}

template <class... Values>
protocol::Scene scene(const char* key, uint8_t generation, Values... values) {
  const float list[] = {static_cast<float>(values)...};
  protocol::Scene made{number_of(key), generation, {}};
  for (std::size_t i = 0; i < sizeof...(values); ++i) made.values[i] = list[i];
  return made;
}

// A board that renders a law with the handle at rest.
class Rendering : public Bench {
 public:
  explicit Rendering(const protocol::Scene& scene, uint16_t rate = 1000) {
    say(protocol::Loop{rate, protocol::kEstimatorDifference, 0.0f, 0.0f});
    say(protocol::Stream{1, 0});
    period(kRest);
    say(scene);
    period(kRest);
    period(kRest);
    fake::sent.clear();
  }

  // One period later, the computer alive; return what is told.
  protocol::Telemetry shown(uint16_t raw = kRest) {
    say(protocol::Alive{});
    fake::sent.clear();
    period(raw);
    return last<protocol::Telemetry>();
  }

  void alive(int periods, uint16_t raw = kRest) {
    while (periods--) {
      say(protocol::Alive{});
      period(raw);
    }
    fake::sent.clear();
  }
};

// The reading of a sensor that repeats every 921 counts, from 51 on.
inline uint16_t raw_of(int count) { return static_cast<uint16_t>(51 + (count - 51) % 921); }

// Force of a spring of so many N/m around zero at a reading: counts begin at the reading's nearest repeat.
inline double pull(double stiffness, int count) { return -stiffness * kQuantum * count; }
