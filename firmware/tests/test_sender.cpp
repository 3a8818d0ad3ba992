// Padded frames: whole packets on the wire, with unchanged messages.
#include <cstring>
#include <random>

#include "bench.h"
#include "check.h"
#include "fake_board.h"
#include "sender.h"

namespace {

constexpr std::size_t kQueue = board::kQueue;  // a padded frame that would not fit is sent without padding

// Return the size of a frame on the wire, which is the next multiple of the packet length.
std::size_t filled(std::size_t plain, unsigned multiple) {
  if (multiple == 0) return plain;
  const std::size_t packets = (plain + multiple - 1) / multiple;
  return packets * multiple <= kQueue ? packets * multiple : plain;
}

// Return the bodies of the frames sent; delimiters used as padding have no body.
std::vector<fake::Body> bodies() {
  std::vector<fake::Body> found;
  for (const fake::Body& body : fake::take_bodies()) {
    if (!body.empty()) found.push_back(body);
  }
  return found;
}

template <class Message>
Message random_message(std::mt19937& random) {
  uint8_t bytes[sizeof(Message)];
  for (uint8_t& byte : bytes) byte = random() % 3 ? static_cast<uint8_t>(random()) : 0;
  Message message;
  std::memcpy(&message, bytes, sizeof(message));
  return message;
}

template <class Message>
void check_all_multiples() {
  std::mt19937 random(6);
  for (unsigned multiple = 0; multiple < 256; ++multiple) {
    fake::reset();
    const auto message = random_message<Message>(random);
    const fake::Body body = fake::body_of(message);
    const auto plain = fake::frame_of(body);
    const std::size_t size = filled(plain.size(), multiple);
    Sender sender;
    sender.pad(static_cast<uint8_t>(multiple));
    fake::room = static_cast<uint8_t>(size - 1);
    CHECK(!sender.send(message) && fake::sent.empty());
    fake::room = static_cast<uint8_t>(size);
    CHECK(sender.send(message));
    auto wanted = plain;
    wanted.resize(size, 0);
    CHECK(fake::sent == wanted);
    CHECK(bodies() == std::vector<fake::Body>{body});
  }
}

}  // namespace

TEST(every_message_is_padded_to_every_multiple_that_fits) {
  check_all_multiples<protocol::Sample>();
  check_all_multiples<protocol::Telemetry>();
  check_all_multiples<protocol::Hello>();
  check_all_multiples<protocol::Settings>();
}

TEST(the_stream_message_switches_padding) {
  Bench bench;
  for (const uint8_t multiple : {62, 0, 61}) {
    bench.receive(protocol::Stream{1, multiple});
    bench.receive(protocol::HelloRequest{});
    fake::sent.clear();
    bench.period();
    const std::size_t sample = fake::frame_of(fake::body_of(protocol::Sample{})).size();
    const std::size_t hello = fake::frame_of(fake::body_of(protocol::Hello{})).size();
    CHECK(fake::sent.size() == filled(sample, multiple) + filled(hello, multiple));
    const auto found = bodies();
    CHECK(found.size() == 2 && found[0][0] == protocol::Hello::kId && found[1][0] == protocol::Sample::kId);
  }
}
