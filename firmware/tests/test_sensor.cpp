// Conversion of each sensor's readings to counts from the zero: repeats, sense, changes while running,
// faults.
#include <cstdint>
#include <initializer_list>

#include "as5048a.h"
#include "check.h"
#include "kits.h"
#include "quadrature.h"
#include "sensor.h"

namespace {

constexpr uint8_t kMr = protocol::kSensorMagnetoresistive;
constexpr uint8_t kHall = protocol::kSensorAs5048A;
constexpr uint8_t kEncoder = protocol::kSensorQuadrature;

protocol::Board with_zero(int32_t zero, int8_t sense = 1) {
  protocol::Board kit = kits::usual();
  kit.zero = zero;
  kit.sense = sense;
  return kit;
}

// Compute the even parity bit by bit, as the datasheet describes it.
uint16_t framed(uint16_t low) {
  int ones = 0;
  for (int bit = 0; bit < 15; ++bit) ones += low >> bit & 1;
  return static_cast<uint16_t>(low | (ones % 2) << 15);
}

constexpr uint16_t kHealthy = 0x0180;

}  // namespace

TEST(after_a_start_the_nearest_repeat_is_the_zero) {
  for (int32_t zero : {-100000, -460, 0, 300, 700, 99999}) {
    for (uint16_t raw : {51, 200, 460, 511, 512, 971}) {
      sensor::start(with_zero(zero));
      const int32_t count = sensor::count(raw, false);
      CHECK((count - (raw - zero)) % 921 == 0);
      CHECK(-460 <= count && count <= 460);
      sensor::start(with_zero(zero, -1));
      CHECK(sensor::count(raw, false) == -count);
    }
  }
}

TEST(a_changed_zero_shifts_the_counts_by_the_difference) {
  sensor::start(with_zero(300));
  sensor::count(300, false);
  for (int raw = 350; raw < 972; raw += 50) sensor::count(raw, false);
  for (int raw = 79; raw < 300; raw += 50) sensor::count(raw, false);
  const int32_t far = sensor::count(300, false);
  CHECK(far == 921);
  sensor::change(with_zero(350));
  CHECK(sensor::count(300, false) == far - 50);
  sensor::change(with_zero(350));
  CHECK(sensor::count(300, false) == far - 50);
  sensor::change(with_zero(350, -1));
  CHECK(sensor::count(300, false) == 50 - far);
  sensor::change(with_zero(300 + 921));
  CHECK(sensor::count(300, false) == 0);
}

TEST(a_different_sensor_restarts) {
  sensor::start(with_zero(0));
  sensor::count(100, false);
  sensor::change(kits::with_sensor(kHall, 16384));
  CHECK(sensor::count(16000, false) == 16000 - 16384);
  sensor::change(kits::with_sensor(kEncoder, 48));
  CHECK(sensor::count(1234, false) == 0);
}

TEST(an_encoder_starts_at_zero_and_counts_beyond_65536) {
  sensor::start(kits::with_sensor(kEncoder, 48));
  CHECK(sensor::count(65530, false) == 0);
  CHECK(sensor::count(10, false) == 16);
  CHECK(sensor::count(30000, false) == 30006);
  CHECK(sensor::count(60000, false) == 60006);
  CHECK(sensor::count(20000, false) == 60006 + 25536);
  CHECK(sensor::count(60000, true) == 60006);  // a reading with a slip still counts
  CHECK(sensor::take_doubt() && !sensor::take_doubt());
}

TEST(a_failed_reading_repeats_the_last_count) {
  sensor::start(kits::with_sensor(kHall, 16384));
  CHECK(sensor::count(77, true) == 0);  // the count has not started yet
  CHECK(sensor::take_doubt());
  CHECK(sensor::count(100, false) == 100);
  CHECK(!sensor::take_doubt());
  CHECK(sensor::count(5000, true) == 100);
  CHECK(sensor::take_doubt());
  CHECK(sensor::count(120, false) == 120);
}

TEST(readings_at_the_rails_are_invalid) {
  for (uint16_t raw : {0, 7, 1016, 1023}) {
    sensor::start(with_zero(0));
    sensor::count(100, false);
    CHECK(sensor::count(raw, false) == 100);
    CHECK(sensor::take_doubt());
  }
  for (uint16_t raw : {8, 1015}) {
    sensor::start(with_zero(0));
    sensor::count(raw, false);
    CHECK(!sensor::take_doubt());
  }
}

TEST(eight_doubtful_readings_are_a_fault_until_32_good_ones) {
  sensor::start(with_zero(0));
  sensor::count(100, false);
  for (int i = 0; i < 7; ++i) sensor::count(1023, false);
  CHECK(!sensor::faulty());
  sensor::count(1023, false);
  CHECK(sensor::faulty());
  for (int i = 0; i < 31; ++i) sensor::count(100, false);
  CHECK(sensor::faulty());
  sensor::count(100, false);
  CHECK(!sensor::faulty());
}

TEST(one_doubtful_reading_in_ten_is_not_a_fault) {
  sensor::start(with_zero(0));
  for (int i = 0; i < 1000; ++i) {
    sensor::count(i % 10 ? 100 : 1023, false);
    CHECK(!sensor::faulty());
  }
}

TEST(frames_of_the_as5048a_are_checked) {
  CHECK(framed(0x7fff) == As5048A::kReadAngle && framed(0x7ffd) == As5048A::kReadHealth);
  CHECK(framed(0x4001) == As5048A::kClearError);
  for (int angle = 0; angle < 16384; angle += 7) {
    CHECK(As5048A::whole(framed(angle)));
    CHECK(!As5048A::whole(framed(angle) ^ 0x8000));
    CHECK(!As5048A::whole(framed(angle | 0x4000)));
    CHECK(!As5048A::whole(framed(angle) ^ (1 << angle % 14)));
  }
}

TEST(an_as5048a_is_valid_after_its_diagnostics_report_ready) {
  As5048A angle;
  CHECK(angle.next() == As5048A::kReadHealth);
  CHECK(!angle.take(framed(0), framed(1000)));  // the first frame does not answer a request
  CHECK(angle.next() == As5048A::kReadHealth);
  CHECK(angle.take(framed(kHealthy), framed(1001)) && angle.reading() == 1001);
  angle.next();
  CHECK(!angle.take(framed(0), framed(1002)) && angle.reading() == 1001);       // the sensor is not ready
  angle.next();
  CHECK(!angle.take(framed(0x0300), framed(1003)) && angle.reading() == 1001);  // the angle is invalid
  angle.next();
  CHECK(!angle.take(framed(kHealthy), framed(1004) ^ 4) && angle.reading() == 1001);
  angle.next();
  CHECK(angle.take(framed(kHealthy), framed(1005)) && angle.reading() == 1005);
}

TEST(an_error_of_the_as5048a_is_cleared) {
  As5048A angle;
  angle.next();
  angle.take(framed(0), framed(1));
  angle.next();
  CHECK(!angle.take(framed(kHealthy), framed(0x4000 | 2)));
  CHECK(angle.next() == As5048A::kClearError);
  CHECK(!angle.take(framed(kHealthy | 0x4000), framed(0x4000 | 3)));
  CHECK(angle.next() == As5048A::kClearError);
  // this is the reply of the error register
  CHECK(angle.take(framed(0x0001), framed(4)) && angle.reading() == 4);
  CHECK(angle.next() == As5048A::kReadHealth);
}

TEST(a_missing_as5048a_is_never_valid) {
  for (uint16_t line : {0x0000, 0xffff}) {
    As5048A angle;
    for (int i = 0; i < 50; ++i) {
      angle.next();
      CHECK(!angle.take(line, line));
    }
  }
}

TEST(an_encoder_counts_every_edge_both_ways) {
  Quadrature encoder;
  const uint8_t turn[] = {0x00, 0x04, 0x0c, 0x08};
  encoder.start(0x00);
  for (int i = 1; i <= 100; ++i) encoder.edge(turn[i % 4]);
  CHECK(encoder.steps() == 100);
  for (int i = 99; i >= -100; --i) encoder.edge(turn[(i + 400) % 4]);
  CHECK(static_cast<int16_t>(encoder.steps()) == -100);
  CHECK(!encoder.take_slip());
  encoder.edge(turn[0]);  // there was no motion
  CHECK(static_cast<int16_t>(encoder.steps()) == -100);
}

TEST(a_missed_edge_counts_in_the_last_direction_and_is_reported) {
  Quadrature encoder;
  encoder.start(0x00);
  encoder.edge(0x04);
  encoder.edge(0x08);  // both channels have an edge
  CHECK(encoder.steps() == 3);
  CHECK(encoder.take_slip() && !encoder.take_slip());
  encoder.edge(0x0c);
  encoder.edge(0x00);
  CHECK(encoder.steps() == 0);
  CHECK(encoder.take_slip());
}

TEST(a_change_in_the_meaning_of_counts_is_reported_once) {
  sensor::start(with_zero(300));
  CHECK(sensor::take_moved() && !sensor::take_moved());
  sensor::count(0, false);  // this angle is invalid; the first valid one determines the zero
  CHECK(!sensor::take_moved());
  sensor::count(500, false);
  CHECK(sensor::take_moved() && !sensor::take_moved());
  sensor::count(520, false);
  CHECK(!sensor::take_moved());
  sensor::change(with_zero(310, -1));
  CHECK(sensor::take_moved() && !sensor::take_moved());
}
