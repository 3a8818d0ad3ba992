// Helpers for tests of rendering on the board: small laws in machine code, and a board that receives a law.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "bench.h"
#include "check.h"
#include "crc.h"
#include "machine.h"

constexpr uint16_t kStill = 400;            // reading of a handle that rests 8.3 mm to the right
constexpr int kFadeMs = 30;
constexpr double kQuantum = 20.742975e-6;  // m per count: pi * 0.090 * 0.005 / (0.074 * 921)

// The first slot of a law after position and velocity.
constexpr uint8_t kFirst = machine::kFirstGiven;

struct Law {
  std::vector<float> given;  // state, then constants
  std::vector<uint8_t> code;
  uint8_t states = 0;
  uint8_t slots = 0;  // 0 means that there are no temporaries

  std::vector<uint8_t> bytes() const {
    const auto* values = reinterpret_cast<const uint8_t*>(given.data());
    std::vector<uint8_t> all(values, values + 4 * given.size());
    all.insert(all.end(), code.begin(), code.end());
    return all;
  }
};

// Return a law whose force is one slot times the first constant.
inline Law product(uint8_t slot, double constant) {
  return {{static_cast<float>(constant)}, {machine::kMain, machine::kLoad, slot, machine::kMultiply, kFirst,
                                           machine::kReturn}};
}

inline Law spring(double stiffness) { return product(0, -stiffness); }
inline Law damper(double damping) { return product(1, -damping); }

// Return a law with two state variables that count up and down from a start; it renders no force.
inline Law counter(double start) {
  using namespace machine;
  const float first = static_cast<float>(start);
  return {{first, first, 1.0f, 0.0f},
          {kMain, kLoad, kFirst, kAdd, kFirst + 2, kStore, kFirst, kLoad, kFirst + 1, kSubtract, kFirst + 2, kStore,
           kFirst + 1, kLoad, kFirst + 3, kReturn},
          2};
}

// Return the settings of the difference estimator at this rate in Hz.
inline estimator::Loop at(int rate) {
  return {static_cast<uint16_t>(std::lround(2e6 / rate)), protocol::kEstimatorDifference, 0.0f, 0.0f};
}

inline protocol::Law head_of(const Law& law, uint8_t generation, const estimator::Loop& loop) {
  const std::vector<uint8_t> all = law.bytes();
  uint16_t check = crc::kStart;
  for (uint8_t byte : all) check = crc::update(check, byte);
  const auto given = static_cast<uint8_t>(law.given.size());
  const auto slots = static_cast<uint8_t>(law.slots ? law.slots : kFirst + given);
  return {generation, loop.period, loop.estimator, loop.first, loop.second, law.states, given, slots,
          static_cast<uint16_t>(law.code.size()), check};
}

inline protocol::Piece piece_of(const Law& law, uint8_t generation, std::size_t from) {
  const std::vector<uint8_t> all = law.bytes();
  protocol::Piece piece{generation, static_cast<uint16_t>(from), {}};
  for (std::size_t i = 0; i < protocol::kPiece && from + i < all.size(); ++i) piece.data[i] = all[from + i];
  return piece;
}

inline protocol::Tune tune(uint8_t law, uint8_t generation, std::vector<std::pair<uint8_t, float>> moves) {
  protocol::Tune made{law, generation, static_cast<uint8_t>(moves.size()), {}, {}};
  for (std::size_t i = 0; i < moves.size(); ++i) {
    made.slots[i] = moves[i].first;
    made.values[i] = moves[i].second;
  }
  return made;
}

// A board with streaming on, and with the handle at rest.
class Rendering : public Bench {
 public:
  Rendering() {
    receive(protocol::Stream{1, 0});
    period(kStill);
  }

  // Create a board that renders a law at a rate in Hz.
  explicit Rendering(const Law& law, int rate = 1000) : Rendering() {
    change(law, 1, at(rate));
    period(kStill);
    period(kStill);
    fake::sent.clear();
  }

  void send(const Law& law, uint8_t generation) {
    for (std::size_t from = 0; from < law.bytes().size(); from += protocol::kPiece) {
      receive(piece_of(law, generation, from));
    }
  }

  // Send a law; the present law fades out first.
  void change(const Law& law, uint8_t generation, const estimator::Loop& loop = at(1000)) {
    receive(head_of(law, generation, loop));
    alive((kFadeMs + 2) * 4);  // no period is shorter than a quarter of a millisecond
    send(law, generation);
  }

  // Advance by one period with keep-alive messages; return the telemetry.
  protocol::Telemetry shown(uint16_t raw = kStill) {
    receive(protocol::Alive{});
    fake::sent.clear();
    period(raw);
    return last<protocol::Telemetry>();
  }

  void alive(int periods, uint16_t raw = kStill) {
    while (periods--) {
      receive(protocol::Alive{});
      period(raw);
    }
    fake::sent.clear();
  }
};

// Return the reading at a count of a sensor that repeats every 921 counts, starting at 51.
inline uint16_t raw_of(int count) { return static_cast<uint16_t>(51 + (count - 51) % 921); }

// Return the force at a count of a spring with its centre at 0; stiffness is in N/m.
inline double pull(double stiffness, int count) { return -stiffness * kQuantum * count; }
