// Settings: the values after a start, the values that are refused, and the effect of a change.
#include <cmath>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <limits>

#include "check.h"
#include "fake_board.h"
#include "fake_eeprom.h"
#include "kits.h"
#include "motor.h"
#include "sensor.h"
#include "settings.h"

namespace {

using fake::fresh_board;
using kits::named;
using kits::same;
using protocol::Board;

bool accepts(const std::function<void(Board&)>& change) {
  fresh_board();
  Board kit = kits::usual();
  change(kit);
  const Board before = settings::now();
  const bool taken = settings::accept(kit);
  CHECK(same(settings::now(), taken ? kit : before));
  CHECK(settings::origin() == (taken ? protocol::kOriginUnsaved : protocol::kOriginDefault));
  return taken;
}

// A float member with the lower and the upper limit of its range.
struct Number {
  float Board::*member;
  float low, high;
};

}  // namespace

TEST(a_new_board_has_the_default_kit) {
  fresh_board();
  CHECK(settings::origin() == protocol::kOriginDefault);
  const Board& kit = settings::now();
  CHECK(kit.pins == protocol::kPinsD5D8 && kit.sensor == 0 && kit.motor_map == 0);
  CHECK(kit.direction == 1 && kit.sense == 1 && kit.counts_per_flip == 921 && kit.zero == 0);
  CHECK_NEAR(kit.quantum, M_PI * 0.005 / 0.074 * 0.090 / 921.0, 1e-11);
  CHECK(kit.max_force == 3.0f && kit.motor_constant == 0.0183f && kit.dead_band == 0);
  CHECK(kit.handle_radius == 0.090f && kit.pulley_radius == 0.005f && kit.sector_radius == 0.074f);
  CHECK(fake::configurations == 1 && same(fake::configured, kit) && !fake::held);
  CHECK(fake::eeprom_writes == 0);
  // the settings are unchanged
  CHECK(settings::accept(kit) && settings::origin() == protocol::kOriginDefault);
}

TEST(accepted_settings_are_in_force_at_once) {
  fresh_board();
  fake::pwm = 99;
  Board kit = named("weak", 1.5f);
  kit.zero = 77;
  kit.sense = -1;
  CHECK(settings::accept(kit));
  CHECK(same(settings::now(), kit) && settings::origin() == protocol::kOriginUnsaved);
  CHECK(fake::configurations == 2 && same(fake::configured, kit) && !fake::held);
  CHECK(fake::pwm == 0);
  CHECK(motor::duty_of(9.0f).pwm == motor::duty_of(1.5f).pwm);
  CHECK(sensor::count(100, false) == -23);
}

TEST(every_number_has_its_limits) {
  const Number numbers[] = {
      {&Board::quantum, 1e-7f, 2e-3f},        {&Board::max_force, 0.0f, 5.0f},
      {&Board::motor_constant, 1e-4f, 0.2f},  {&Board::handle_radius, 0.02f, 0.3f},
      {&Board::pulley_radius, 1e-3f, 0.02f},  {&Board::sector_radius, 0.02f, 0.3f},
      {&Board::mass, 0.0f, 1.0f},             {&Board::viscous, 0.0f, 20.0f},
      {&Board::coulomb, 0.0f, 5.0f}};
  const float infinity = std::numeric_limits<float>::infinity();
  for (const Number& number : numbers) {
    const auto with = [&](float value) {
      return accepts([&](Board& kit) { std::memcpy(&(kit.*number.member), &value, sizeof(value)); });
    };
    CHECK(with(number.low) && with(number.high));
    CHECK(with(number.low * 1.01f + 1e-9f) && with(number.high * 0.99f));
    CHECK(!with(number.high * 1.01f) && !with(number.low == 0.0f ? -0.01f : number.low * 0.99f));
    CHECK(!with(infinity) && !with(-infinity) && !with(std::nanf("")) && !with(-number.high));
  }
}

TEST(choices_have_their_limits) {
  CHECK(!accepts([](Board& kit) { kit.pins = 2; }));
  CHECK(!accepts([](Board& kit) { kit.sensor = 3; }));
  CHECK(accepts([](Board& kit) { kit.motor_map = 2; }));
  CHECK(!accepts([](Board& kit) { kit.motor_map = 3; }));
  CHECK(accepts([](Board& kit) { kit.direction = -1; }));
  for (int sign : {0, 2, -2, 127, -128}) {
    CHECK(!accepts([&](Board& kit) { kit.direction = static_cast<int8_t>(sign); }));
    CHECK(!accepts([&](Board& kit) { kit.sense = static_cast<int8_t>(sign); }));
  }
  CHECK(accepts([](Board& kit) { kit.zero = -1000000; }) && !accepts([](Board& kit) { kit.zero = 1000001; }));
  CHECK(accepts([](Board& kit) { kit.dead_band = 200; }) && !accepts([](Board& kit) { kit.dead_band = 201; }));
}

TEST(motor_pins_must_not_be_needed_by_the_sensor) {
  for (uint8_t sensor : {0, 1, 2}) {
    const uint16_t counts[] = {921, 16384, 48};
    const auto with = [&](uint8_t pins) {
      return accepts([&](Board& kit) {
        kit.sensor = sensor;
        kit.counts_per_flip = counts[sensor];
        kit.pins = pins;
      });
    };
    CHECK(with(protocol::kPinsD5D8));
    CHECK(with(protocol::kPinsD3D12) == (sensor == protocol::kSensorMagnetoresistive));
  }
}

TEST(counts_must_suit_the_sensor) {
  const auto with = [](uint8_t sensor, uint16_t counts) {
    return accepts([&](Board& kit) { kit.sensor = sensor, kit.counts_per_flip = counts; });
  };
  CHECK(with(0, 100) && with(0, 1007) && !with(0, 99) && !with(0, 1008) && !with(0, 0));
  CHECK(with(1, 16384) && !with(1, 16383) && !with(1, 921));
  CHECK(with(2, 4) && with(2, 48) && with(2, 65535) && !with(2, 3));
}

TEST(tables_must_not_decrease_and_labels_must_be_text) {
  CHECK(!accepts([](Board& kit) { kit.table[3] = kit.table[2] - 1; }));
  CHECK(accepts([](Board& kit) { kit.table[3] = kit.table[2]; }));
  CHECK(!accepts([](Board& kit) { kit.table[7] = 254; }));  // the motor constant is defined at full duty
  CHECK(accepts([](Board& kit) { std::memset(kit.label, 'x', sizeof(kit.label)); }));
  CHECK(accepts([](Board& kit) { std::memset(kit.label, 0, sizeof(kit.label)); }));
  CHECK(!accepts([](Board& kit) { kit.label[0] = '\n'; }));
  CHECK(!accepts([](Board& kit) { kit.label[1] = '\x80'; }));
  CHECK(!accepts([](Board& kit) { kit.label[1] = 0; }));  // there is text after the terminating zero
}
