#include "fake_board.h"

#include <cstddef>

namespace fake {

uint32_t now_us = 0;
int16_t pwm = 0;
uint8_t room = 127;
uint8_t lost = 0;
bool held = false;
std::function<void()> let_go;
protocol::Board configured = {};
int configurations = 0;
uint16_t ticks = board::kTicksPerMs;
uint16_t age_us = 0;
int pats = 0;
std::vector<uint8_t> sent;
static uint8_t queue[256];

void reset() {
  now_us = 0;
  ticks = board::kTicksPerMs;
  age_us = 0;
  pats = 0;
  pwm = 0;
  room = 127;
  lost = 0;
  held = false;
  let_go = nullptr;
  configured = {};
  configurations = 0;
  sent.clear();
}

uint16_t crc_of(const Body& body) {
  uint32_t crc = 0xffff;
  for (uint8_t byte : body) {
    for (int bit = 7; bit >= 0; --bit) {
      const bool feedback = ((crc >> 15) & 1) != ((byte >> bit) & 1u);
      crc = (crc << 1) & 0xffff;
      if (feedback) crc ^= 0x1021;
    }
  }
  return static_cast<uint16_t>(crc);
}

std::vector<uint8_t> frame_of(const Body& body) {
  Body raw = body;
  const uint16_t crc = crc_of(body);
  raw.push_back(crc >> 8);
  raw.push_back(crc & 0xff);
  raw.push_back(0);  // COBS encodes as if a zero followed
  std::vector<uint8_t> coded;
  std::vector<uint8_t> block;
  for (uint8_t byte : raw) {
    if (byte != 0) {
      block.push_back(byte);
      continue;
    }
    coded.push_back(static_cast<uint8_t>(block.size() + 1));
    coded.insert(coded.end(), block.begin(), block.end());
    block.clear();
  }
  coded.push_back(0);
  return coded;
}

static Body decoded(const std::vector<uint8_t>& coded) {
  Body raw;
  for (std::size_t at = 0; at < coded.size();) {
    const std::size_t code = coded[at];
    for (std::size_t i = 1; i < code && at + i < coded.size(); ++i) raw.push_back(coded[at + i]);
    at += code;
    if (at < coded.size()) raw.push_back(0);
  }
  if (raw.size() < 3) return {};
  const uint16_t crc = static_cast<uint16_t>(raw[raw.size() - 2] << 8 | raw.back());
  raw.resize(raw.size() - 2);
  return crc == crc_of(raw) ? raw : Body{};
}

std::vector<Body> take_bodies() {
  std::vector<Body> bodies;
  std::vector<uint8_t> coded;
  for (uint8_t byte : sent) {
    if (byte != 0) {
      coded.push_back(byte);
      continue;
    }
    bodies.push_back(decoded(coded));
    coded.clear();
  }
  sent.clear();
  return bodies;
}

}  // namespace fake

void board::begin() {}
void board::configure(const protocol::Board& kit) {
  fake::pwm = 0;
  fake::configured = kit;
  ++fake::configurations;
}
void board::hold(bool on) {
  fake::held = on;
  if (on || !fake::let_go) return;
  const auto happening = fake::let_go;
  fake::let_go = nullptr;
  happening();
}
bool board::read(uint8_t*) { return false; }
uint8_t* board::room_for(uint8_t size) { return fake::room < size ? nullptr : fake::queue; }
void board::send(uint8_t* end) { fake::sent.insert(fake::sent.end(), fake::queue, end); }
void board::wake() {}
void board::set_motor(int16_t pwm) { fake::pwm = pwm; }
uint32_t board::now_us() { return fake::now_us; }
uint8_t board::lost_bytes() { return fake::lost; }
void board::set_period(uint16_t ticks) { fake::ticks = ticks; }
uint32_t board::stamp() { return fake::now_us; }

uint32_t board::us_of(uint32_t stamp) { return stamp; }
uint16_t board::age_us() { return fake::age_us; }
void board::pat() { ++fake::pats; }
uint8_t board::reset_cause() { return 8; }
