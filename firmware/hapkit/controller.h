// Replies to the computer and moves the motor. receive() and poll() run in the main program. sample() is the
// tick: it runs in the interrupt, and the main program never interrupts it.
#pragma once

#include <stdint.h>

#include "answers.h"
#include "board.h"
#include "estimator.h"
#include "frame.h"
#include "loading.h"
#include "protocol.h"
#include "render.h"
#include "safety.h"
#include "sender.h"

class Controller {
 public:
  // Start after the settings are known.
  void begin();

  // Process one received byte, and the message that this byte completes.
  void receive(uint8_t byte);

  // Send the report of the last tick and the pending replies; ramp the constants of the law.
  void poll();

  // Return true while the report of a tick waits for poll(); there is a report about every millisecond.
  bool due() const { return due_; }

  // Handle one sensor reading: compute position and velocity, check safety, and render the board's law.
  void sample(const board::Sampling& sampling);

 private:
  static constexpr float kFastest = 5.0f;  // [m/s] a faster motion is a fault
  static constexpr uint8_t kVouched = 50;  // [ms] time for which the ticks may feed the watchdog

  // These functions belong to the main program.
  void dispatch(const uint8_t* body, uint8_t size);
  void ask(const uint8_t* body, uint8_t size);
  void command(const protocol::Force& force);
  void announce(const protocol::Law& law);
  void take_pieces();
  void take(const protocol::Piece& piece);
  void tune(const protocol::Tune& tune);
  void leave();
  void set_kit(const protocol::Board& kit);
  void set_stream(const protocol::Stream& stream);
  void leave_law();
  void off();
  void redesign(const estimator::Loop& loop);
  void start_law();
  void report(uint32_t time_us);
  uint8_t overrun_flag();

  // Both sides call this; the main program does so under a Lock.
  void drive(int16_t pwm) {
    board::set_motor(pwm);
    pwm_ = pwm;
  }

  // These functions belong to the tick (tick.cpp).
  void adopt();
  void miss(const board::Sampling& sampling, int32_t count);
  void watch(const board::Sampling& sampling, int32_t count);
  void render(int32_t count);
  void follow();
  void vouch();
  void show(const board::Sampling& sampling, int32_t count, bool rendered);
  void show_now(const board::Sampling& sampling, int32_t count, bool rendered);
  void show_sample(const board::Sampling& sampling, int32_t count);
  void show_law(const board::Sampling& sampling, int32_t count);

  // The tick's data come first, because the chip addresses the first 64 bytes directly.
  estimator::Estimator estimator_;
  estimator::Design design_ = {};  // there is no period until a design is set
  float asked_ = 0.0f;
  uint16_t delays_us_ = 0;  // sum since the last report
  int16_t pwm_ = 0;
  uint8_t since_shown_ = 0;  // ticks of the loop since the last report
  volatile bool next_ready_ = false;
  Safety safety_;
  render::Fade fade_;
  render::Renderer renderer_;
  uint16_t last_seq_ = 0;
  uint32_t last_stamp_ = 0;
  volatile uint8_t overruns_ = 0;
  volatile bool due_ = false;   // set while a tick's report is used by the main program
  volatile bool late_ = false;  // set if a tick had a report while due_ was set
  volatile uint8_t vouched_ = 0;  // [ms] remaining time for which the ticks feed the watchdog

  frame::Parser parser_;
  Sender sender_;
  Answers answers_;
  Loading loading_;
  bool streaming_ = false;
  bool lost_frame_ = false;  // true if the last frame did not fit into the queue
  uint8_t told_overruns_ = 0;
  volatile uint16_t answered_ = 0;
  volatile uint16_t delay_us_ = 0;
  uint8_t stale_ = 0;

  // The main program passes this design to the tick, which applies it after the first period of the new
  // length.
  estimator::Design next_ = {};

  // The report of a tick: a sample, or telemetry of a law.
  uint32_t stamp_ = 0;
  bool shows_law_ = false;
  union Shown {
    protocol::Telemetry law;
    protocol::Sample sample;
  };
  Shown shown_ = {};
};
