// One of the board's own laws: chosen and tuned by the main program, asked for its force by the tick.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace render {

// How many laws there are.
uint8_t count();

// Fill the name of a law; false if there is none of this number.
bool describe(uint8_t law, protocol::LawName* name);

// A force that comes in over 30 ms, and may go out again.
class Fade {
 public:
  void restart() { gone_ = 0; }

  // The force goes out, or comes in after all.
  void leave() { leaving_ = true; }
  void stay() { leaving_ = false; }
  bool leaving() const { return leaving_; }
  bool out() const { return leaving_ && gone_ == 0; }

  // Whether a force is felt as it is.
  bool whole() const { return gone_ >= kQuarters && !leaving_; }

  // Return the force, weighted, one period later.
  float weighted(float force, uint8_t quarters);

 private:
  static constexpr uint8_t kQuarters = 4 * 30;  // of a millisecond

  volatile uint8_t gone_ = 0;
  volatile bool leaving_ = false;
};

class Renderer {
 public:
  // Main program.

  // Put a scene in force; false, and nothing is changed, if it cannot be rendered. The same law with the same
  // choices goes on, and its numbers move over 30 ms; anew: it does not go on.
  bool accept(const protocol::Scene& scene, bool anew);

  // Leave the rendering to the computer.
  void leave();

  // Let the numbers move on by a millisecond.
  void move();

  bool active() const { return active_; }

  // The number that came with the scene in force.
  uint8_t generation() const { return generation_; }

  // The tick, which the main program never interrupts.

  // Return the force that the law asks for in N, positive to the right; a law that begins fades in. It gets to see
  // the period, the place and the velocity.
  float force(const float* seen, Fade* fade) {
    if (fresh_) begin(fade);
    return force_(banks_[bank_], state_, seen[1], seen[2], seen[0]);
  }

  // Fill one value of the law's state and its place; they take turns.
  void show_state(protocol::Telemetry* shown);

 private:
  typedef float Force(const float*, float*, float, float, float);

  void begin(Fade* fade);
  void move_to(const protocol::Scene& scene);
  bool goes_on(const protocol::Scene& scene) const;

  // A law reckons anew what its numbers alone decide: at every second call, so that fewer ticks take longer.
  static constexpr uint8_t kSteps = 15, kCalls = 2 * kSteps;

  volatile bool active_ = false;
  volatile bool fresh_ = false;  // the next tick starts the law
  volatile uint8_t bank_ = 0;
  Force* force_ = nullptr;
  float state_[protocol::kValues] = {};
  float banks_[2][protocol::kValues] = {};  // parameters: one for the tick, the other to be written
  float goal_[protocol::kValues] = {};
  float step_[protocol::kValues] = {};
  void (*start_)(float*) = nullptr;
  uint16_t discrete_ = 0;  // bit i: parameter i is a choice
  uint8_t parameters_ = 0;
  uint8_t states_ = 0;
  uint8_t turn_ = 0;        // which state is shown next
  uint8_t calls_left_ = 0;  // until the numbers are at their goal
  uint8_t generation_ = 0;
  uint8_t law_ = 0;
};

}  // namespace render
