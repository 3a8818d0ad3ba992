// Framing is compared with an independent coder: every length, every byte, every damage of a single byte.
#include <cstddef>
#include <cstring>
#include <random>
#include <vector>

#include "check.h"
#include "fake_board.h"
#include "frame.h"

namespace {

using Bytes = std::vector<uint8_t>;

Bytes written(const Bytes& body, std::size_t first = 0) {
  Bytes out(body.size() + frame::kOverhead);
  frame::Writer writer(out.data());
  writer.put(body.data(), static_cast<uint8_t>(first));
  writer.put(body.data() + first, static_cast<uint8_t>(body.size() - first));
  out.resize(writer.finish() - out.data());
  return out;
}

// Return the bodies that a parser accepts.
std::vector<Bytes> parsed(frame::Parser& parser, const Bytes& bytes) {
  std::vector<Bytes> found;
  for (uint8_t byte : bytes) {
    const uint8_t size = parser.push(byte);
    if (size) found.emplace_back(parser.body(), parser.body() + size);
  }
  return found;
}

Bytes random_body(std::mt19937& random, std::size_t size) {
  Bytes body(size);
  for (uint8_t& byte : body) byte = random() % 3 ? static_cast<uint8_t>(random()) : 0;
  return body;
}

}  // namespace

TEST(crc_of_the_check_string) {
  uint16_t crc = crc::kStart;
  for (char c : {'1', '2', '3', '4', '5', '6', '7', '8', '9'}) crc = crc::update(crc, static_cast<uint8_t>(c));
  CHECK(crc == 0x29b1);  // catalogue value of CRC-16/CCITT-FALSE
}

TEST(the_writer_agrees_with_an_independent_coder) {
  std::mt19937 random(1);
  for (std::size_t size = 1; size <= frame::kLargestBody; ++size) {
    for (int i = 0; i < 50; ++i) {
      const Bytes body = random_body(random, size);
      CHECK(written(body, random() % (size + 1)) == fake::frame_of(body));
    }
  }
}

TEST(the_parser_accepts_every_body_up_to_the_largest) {
  std::mt19937 random(2);
  frame::Parser parser;
  for (std::size_t size = 1; size <= 1 + protocol::kLargestToBoard; ++size) {
    for (int i = 0; i < 200; ++i) {
      const Bytes body = random_body(random, size);
      CHECK(parsed(parser, fake::frame_of(body)) == std::vector<Bytes>{body});
    }
  }
  CHECK(parser.bad_frames() == 0);
}

TEST(every_single_damaged_byte_is_detected) {
  std::mt19937 random(3);
  const Bytes body = fake::body_of(protocol::Force{4660, 3, 1.5f});
  const Bytes good = fake::frame_of(body);
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (int value = 0; value < 256; ++value) {
      if (value == good[at]) continue;
      Bytes bad = good;
      bad[at] = static_cast<uint8_t>(value);
      frame::Parser parser;
      CHECK(parsed(parser, bad).empty());
      bad.push_back(0);
      bad.insert(bad.end(), good.begin(), good.end());
      // the parser is synchronised again at the next frame
      CHECK(parsed(parser, bad) == std::vector<Bytes>{body});
      CHECK(parser.bad_frames() >= 1);
    }
  }
}

TEST(a_truncated_frame_does_not_affect_the_next) {
  const Bytes body = fake::body_of(protocol::Force{1, 0, -2.0f});
  const Bytes good = fake::frame_of(body);
  for (std::size_t from = 1; from < good.size(); ++from) {
    Bytes stream(good.begin() + from, good.end());
    stream.insert(stream.end(), good.begin(), good.end());
    frame::Parser parser;
    const std::vector<Bytes> found = parsed(parser, stream);
    CHECK(!found.empty() && found.back() == body);
    CHECK(found.size() == 1);
  }
}

TEST(endless_garbage_does_not_overflow_the_buffer) {
  std::mt19937 random(4);
  frame::Parser parser;
  std::size_t found = 0;
  for (int i = 0; i < 200000; ++i) {
    // long runs without a delimiter, which include full blocks
    const uint8_t byte = random() % 50 ? static_cast<uint8_t>(random() | 1) : static_cast<uint8_t>(random() % 2 * 255);
    const uint8_t size = parser.push(byte);
    if (size) {
      ++found;
      CHECK(size <= 1 + protocol::kLargestToBoard);
    }
  }
  CHECK(found < 5);  // about 2000 frames, each with a CRC that is right by chance once in 65536
}

TEST(lone_delimiters_are_not_errors) {
  frame::Parser parser;
  CHECK(parsed(parser, Bytes(10, 0)).empty());
  CHECK(parser.bad_frames() == 0);
}

TEST(a_frame_that_is_too_long_is_rejected) {
  frame::Parser parser;
  const Bytes body(2 + protocol::kLargestToBoard, 7);
  CHECK(parsed(parser, fake::frame_of(body)).empty());
  CHECK(parser.bad_frames() == 1);
}
