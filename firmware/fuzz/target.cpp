// Fuzz target: the parser, the controller and everything they call, as on the board but without the chip.
//
// The first byte of an input selects the form of the rest. If bit 7 is set, the rest consists of bodies, each
// after its length, which get a valid frame here. Otherwise it consists of the bytes on the line. The
// number in bits 0 to 4, plus four, is the number of bytes until the next sample.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "check.h"
#include "controller.h"
#include "fake_board.h"
#include "fake_eeprom.h"
#include "limits.h"
#include "profile.h"
#include "reference.h"
#include "sensor.h"
#include "settings.h"

namespace {

using reference::Bytes;

constexpr std::size_t kLargest = 1 + protocol::kLargestToBoard;
constexpr uint32_t kSilence = 1000u * profile::kWatchdogMs;

// Return the motor's torque at a duty, by the settings; the table has its points at eighths of full duty.
float torque_of(const protocol::Board& kit, int pwm) {
  if (pwm <= kit.dead_band) return 0.0f;
  const float share = float(pwm - kit.dead_band) / float(profile::kPwmTop - kit.dead_band);
  if (kit.motor_map == protocol::kMotorMapSquare) return kit.motor_constant * share * share;
  if (kit.motor_map == protocol::kMotorMapLinear) return kit.motor_constant * share;
  const float place = share * 8.0f;
  const int cell = place >= 8.0f ? 7 : int(place);
  const float below = cell ? kit.table[cell - 1] : 0.0f, above = kit.table[cell];
  return kit.motor_constant * (below + (above - below) * (place - cell)) / 255.0f;
}

// Check that the duty is within the limit, up to one step, for any input.
void check_motor() {
  static int checked = 0;
  if (fake::pwm == checked) return;
  checked = fake::pwm;
  const protocol::Board& kit = settings::now();
  const int pwm = std::abs(fake::pwm);
  CHECK(pwm <= profile::kPwmTop);
  if (pwm <= kit.dead_band + 1) return;
  const float lever = kit.sector_radius / (kit.handle_radius * kit.pulley_radius);
  CHECK(torque_of(kit, pwm - 1) * lever <= kit.max_force * 1.001f + 1e-6f);
  CHECK(kit.max_force <= limits::kMostForce);
}

// Check that the board's output consists of frames with known messages.
void check_sent() {
  Bytes coded, body;
  for (uint8_t byte : fake::sent) {
    if (byte != 0) {
      coded.push_back(byte);
      continue;
    }
    if (coded.empty()) continue;  // a delimiter used as padding
    CHECK(reference::body_of(coded, 1 + protocol::kLargestFromBoard, &body));
    CHECK(body[0] & 0x80);
    coded.clear();
  }
  CHECK(coded.empty());
  fake::sent.clear();
}

class Board {
 public:
  Board() {
    static const protocol::Board usual = settings::now();
    while (settings::saving()) settings::poll();
    fake::reset();
    settings::accept(usual);
    fake::erase_eeprom();
    settings::load();
    sensor::start(settings::now());
    controller_.begin();
  }

  void receive(uint8_t byte) {
    controller_.receive(byte);
    check_motor();
  }

  void sample(uint16_t raw) {
    const uint16_t ticks = ticks_;  // a new period takes effect after the present one
    ticks_ = fake::ticks;
    const uint8_t missed = raw & 0x4000 ? 1 : 0;
    const bool failed = !missed && raw & 0x2000;
    seq_ = static_cast<uint16_t>(seq_ + 1 + missed);
    fake::now_us += (1u + missed) * ticks / 2u;
    fake::room = static_cast<uint8_t>(raw >> 4);
    controller_.sample({seq_, reading(raw), missed, ticks, failed});
    check_motor();
    if (raw & 0x1000) poll();
  }

  void poll() {
    controller_.poll();
    settings::poll();
    check_sent();
  }

  // Check that the motor is switched off in time after silence.
  void fall_silent() {
    for (uint32_t until = fake::now_us + kSilence; fake::now_us < until;) sample(500);
    CHECK(fake::pwm == 0);
  }

 private:
  // Return a reading that the configured sensor can have.
  static uint16_t reading(uint16_t raw) {
    const uint8_t sensor = settings::now().sensor;
    return sensor == protocol::kSensorQuadrature ? raw : raw & (sensor == protocol::kSensorAs5048A ? 16383 : 1023);
  }

  Controller controller_;
  uint16_t seq_ = 0;
  uint16_t ticks_ = board::kTicksPerMs;
};

Bytes framed(const uint8_t* data, std::size_t size) {
  Bytes line;
  while (size > 1) {
    std::size_t length = data[0] % (kLargest + 3);
    if (length > size - 1) length = size - 1;
    const Bytes frame = reference::frame_of(Bytes(data + 1, data + 1 + length));
    line.insert(line.end(), frame.begin(), frame.end());
    data += 1 + length;
    size -= 1 + length;
  }
  return line;
}

// Check that the parser accepts exactly the frames that the plain decoder accepts, and counts the others.
void compare(const Bytes& line) {
  frame::Parser parser;
  Bytes coded, body;
  uint8_t bad = 0;
  for (uint8_t byte : line) {
    const uint8_t size = parser.push(byte);
    if (byte != 0) {
      coded.push_back(byte);
      CHECK(size == 0);
      continue;
    }
    const bool valid = reference::body_of(coded, kLargest, &body);
    bad += !coded.empty() && !valid;
    CHECK(size == (valid ? body.size() : 0));
    CHECK(!valid || std::memcmp(parser.body(), body.data(), size) == 0);
    CHECK(parser.bad_frames() == bad);
    coded.clear();
  }
}

}  // namespace

void check::fail(const char* file, int line, const char* what) {
  std::fprintf(stderr, "%s:%d: %s\n", file, line, what);
  std::abort();
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const Bytes line = data[0] & 0x80 ? framed(data + 1, size - 1) : Bytes(data + 1, data + size);
  const std::size_t step = 4 + (data[0] & 31);
  compare(line);
  Board board;
  uint16_t raw = static_cast<uint16_t>(size);
  for (std::size_t at = 0; at < line.size(); ++at) {
    board.receive(line[at]);
    raw = static_cast<uint16_t>(raw * 31421u + line[at]);  // arbitrary but reproducible readings
    if (at % step == 0) board.sample(raw);
  }
  board.fall_silent();
  return 0;
}
