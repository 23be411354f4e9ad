// Messages to a page and from it, without a socket.
#include <catch2/catch.hpp>
#include <cstring>

#include "tools/view/admission.h"
#include "tools/view/page_messages.h"
#include "tools/view/page_stream.h"
#include "tools/view/server.h"

using namespace tactus;
using namespace tactus::view;
using Catch::Matchers::Contains;

namespace {

publication::Frame frame_of(std::size_t bodies, std::size_t contacts = 0) {
  publication::Frame frame;
  frame.head.time_s = 1.5;
  frame.head.bodies = static_cast<std::uint32_t>(bodies);
  frame.positions.resize(bodies);
  frame.rotations.resize(bodies);
  frame.roles.resize(bodies, publication::kIsMember);
  frame.contacts.resize(contacts);
  for (std::size_t i = 0; i < bodies; ++i) frame.positions[i].x = static_cast<float>(i);
  return frame;
}

WireHeader header_of(const std::string& message) {
  WireHeader header;
  REQUIRE(message.size() >= sizeof header);
  std::memcpy(&header, message.data(), sizeof header);
  return header;
}

std::uint32_t word_at(const std::string& message, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, message.data() + at, sizeof word);
  return word;
}

std::string next(PageStream& stream, const publication::Frame& frame) {
  stream.offer_frame();
  REQUIRE(stream.ready());
  const std::string message = stream.take(frame, 0);
  stream.acknowledge(header_of(message).number);
  return message;
}

std::vector<publication::TickEntry> ticks_of(std::size_t count) {
  std::vector<publication::TickEntry> ticks(count);
  for (std::size_t i = 0; i < count; ++i) {
    ticks[i].tick.out.tick = i;
    ticks[i].tick.out.command.wrench.force = {0.1 * static_cast<double>(i), 0, 0};
  }
  return ticks;
}

}  // namespace

TEST_CASE("a message has exactly the bytes of the format, full at first and of what moved afterwards") {
  PageStream stream;
  publication::Frame frame = frame_of(5000, 200);
  const std::string first = next(stream, frame);
  CHECK((header_of(first).flags & kIsFull) != 0);
  CHECK(header_of(first).bodies == 5000);
  CHECK(first.size() == 64 + 5000 * (12 + 8) + 5000 * 4 + 200 * 32);
  CHECK(next(stream, frame).size() == 64 + 200 * 32);  // nothing moved
  for (auto& position : frame.positions) position.y += 1;
  CHECK(next(stream, frame).size() == 64 + 5000 * (12 + 8) + 200 * 32);  // all moved: without indices
  frame.positions[7].z = 0.001f;
  frame.rotations[4000].x = 50;
  frame.roles[9] = publication::kIsAsleep;
  const std::string delta = next(stream, frame);
  CHECK(delta.size() == 64 + 2 * (4 + 12 + 8) + 4 + 200 * 32);
  CHECK((header_of(delta).flags & kIsFull) == 0);
  CHECK(word_at(delta, 64) == 7);
  CHECK(word_at(delta, 68) == 4000);
  CHECK(word_at(delta, 64 + 2 * 24) == ((std::uint32_t{publication::kIsAsleep} << 24) | 9));
}

TEST_CASE("moves too small to see are not sent, and add up until they are") {
  PageStream stream;
  publication::Frame frame = frame_of(10);
  (void)next(stream, frame);
  frame.positions[3].z = 6e-6f;
  CHECK(header_of(next(stream, frame)).bodies == 0);
  frame.positions[3].z = 12e-6f;
  CHECK(header_of(next(stream, frame)).bodies == 1);
}

TEST_CASE("at most two messages are unacknowledged, the newest frame follows, and the dropped ones are counted") {
  PageStream stream;
  publication::Frame frame = frame_of(3);
  for (std::uint32_t i = 1; i <= 2; ++i) {
    stream.offer_frame();
    REQUIRE(stream.ready());
    CHECK(header_of(stream.take(frame, 0)).number == i);
  }
  for (int i = 0; i < 5; ++i) stream.offer_frame();
  CHECK_FALSE(stream.ready());
  stream.acknowledge(7);  // of no message that was sent
  CHECK_FALSE(stream.ready());
  stream.acknowledge(1);
  REQUIRE(stream.ready());
  frame.positions[0].x = 42;
  const std::string message = stream.take(frame, 0);
  CHECK(header_of(message).number == 3);
  CHECK(header_of(message).dropped == 4);
  CHECK(header_of(message).bodies == 1);
}

TEST_CASE(
    "every tick is sent, as float32, while frames are dropped, and beyond the bound the oldest are lost and counted") {
  PageStream stream;
  const publication::Frame frame = frame_of(1);
  (void)next(stream, frame);
  stream.offer_ticks(ticks_of(17), 3);
  std::string message = stream.take(frame, 0);
  WireHeader header = header_of(message);
  CHECK(header.ticks == 17);
  CHECK(header.lost_ticks == 3);
  CHECK((header.flags & kHasFrame) == 0);
  CHECK(message.size() == 64 + 17 * 4 * kChannels.size());
  float force = 0;
  std::memcpy(&force, message.data() + 64 + 4 * (16 * kChannels.size() + 1), sizeof force);
  CHECK(force == static_cast<float>(0.1 * 16));
  stream.acknowledge(header.number);
  stream.offer_ticks(ticks_of(kMaxTicks + 100), 0);
  header = header_of(stream.take(frame, 0));
  CHECK(header.ticks == kMaxTicks);
  CHECK(header.lost_ticks == 103);
}

TEST_CASE("ticks of another time drop those that wait, and the page is notified once") {
  PageStream stream;
  const publication::Frame frame = frame_of(1);
  stream.offer_ticks(ticks_of(9), 0);
  stream.restart();
  stream.offer_ticks(ticks_of(4), 0);
  std::string message = stream.take(frame, 0);
  CHECK(header_of(message).ticks == 4);
  CHECK(header_of(message).flags == kRestarts);
  stream.acknowledge(header_of(message).number);
  stream.offer_ticks(ticks_of(1), 0);
  CHECK(header_of(stream.take(frame, 0)).flags == 0);
}

TEST_CASE("a page is admitted from this machine, from its own origin, with the token, and no other") {
  const std::string token = make_token();
  REQUIRE(token.size() == 32);
  CHECK(make_token() != token);
  const std::string protocols = "tactus, " + token;
  for (const std::string host : {"localhost:80", "127.0.0.1:4000", "[::1]:65535", "localhost"})
    CHECK(refuse(host, "http://" + host, protocols, token) == Refusal::kNone);
  for (const std::string host : {"example.org", "127.0.0.1.example.org", "localhost:", "localhost:8a", "127.0.0.2:80",
                                 "", "[::1]x", "localhost:123456"})
    CHECK(refuse(host, "http://" + host, protocols, token) == Refusal::kHost);
  for (const std::string origin : {"", "null", "http://localhost:81", "https://localhost:80", "http://example.org"})
    CHECK(refuse("localhost:80", origin, protocols, token) == Refusal::kOrigin);
  std::string wrong = token;
  wrong.back() = wrong.back() == '0' ? '1' : '0';
  for (const std::string& given :
       {std::string(), std::string("tactus"), "tactus, " + wrong, token, "tactus, " + token + "0", "tactus," + token})
    CHECK(refuse("localhost:80", "http://localhost:80", given, token) == Refusal::kToken);
  CHECK(refuse("localhost:80", "http://localhost:80", "tactus, ", "") == Refusal::kToken);
}

TEST_CASE("a page says what it has taken or asks for, anything else is refused and says what is accepted") {
  CHECK(parse_message(R"({"ack": 7})").value().acknowledged == 7);
  CHECK(parse_message(R"({"ask": "disarm"})").value().ask == "disarm");
  CHECK(parse_message(R"({"ask": "seek", "value": 2.5})").value().value == 2.5);
  CHECK(parse_message(R"({"hand": [0.1, 0, -0.2, 0, 0, 1]})").value().hand->at(2) == -0.2);
  CHECK(parse_message(R"({"ask": "pace", "value": 0})").value().ask == "pace");
  for (const std::string text : {"",
                                 "7",
                                 "{}",
                                 R"({"ack": 0})",
                                 R"({"ack": -1})",
                                 R"({"ack": 1.5})",
                                 R"({"ack": 99999999999})",
                                 R"({"ack": "1"})",
                                 R"({"ask": "fly"})",
                                 R"({"ask": 3})",
                                 R"({"ask": "stop", "ack": 1})",
                                 R"({"ask": "seek"})",
                                 R"({"hand": [1, 2, 3]})",
                                 R"({"hand": [1, 2, 3, 4, 5, "6"]})",
                                 R"({"hand": [1e3, 0, 0, 0, 0, 0]})",
                                 R"({"hand": [0, 0, 0, 0, 0, 0], "ack": 1})",
                                 R"({"ask": "seek", "value": -1})",
                                 R"({"ask": "seek", "value": "1"})",
                                 R"({"ask": "pace", "value": 0.001})",
                                 R"({"ask": "pace", "value": 1e9})",
                                 R"({"ask": "play", "value": 1})",
                                 R"({"ack": 1, "value": 1})",
                                 R"({"ask": "seek", "value": 1, "x": 1})",
                                 R"({"go": 1})",
                                 "[1",
                                 "{\"ack\": 1}x",
                                 "\xff\xfe"}) {
    const auto refused = parse_message(text);
    INFO(text);
    REQUIRE_FALSE(refused.ok());
    CHECK_THAT(refused.message(), Contains("; accepted: {\"ack\": N}"));
    CHECK(refused.message().find('\n') == std::string::npos);
  }
  CHECK_FALSE(parse_message(R"({"ask": "disarm)" + std::string(300, ' ') + "\"}").ok());
}

TEST_CASE("requests that enable force are distinguished from those that end it, and the rate of messages is bounded") {
  for (const char* ask : {"arm", "rearm", "reset"}) CHECK(gives_force(ask));
  for (const char* ask : {"disarm", "stop"}) CHECK_FALSE(gives_force(ask));
  MessageRate rate;
  for (std::uint32_t i = 0; i < kMaxMessages; ++i) CHECK(rate.admits(5'000'000'000));
  CHECK_FALSE(rate.admits(5'999'999'999));
  CHECK(rate.admits(6'000'000'000));
}

TEST_CASE("a build without the page says what is missing") {
  const auto files = load_files("/nowhere/view");
  REQUIRE_FALSE(files.ok());
  CHECK_THAT(files.message(), Contains("/nowhere/view: no page there: this build had no node or no npm") &&
                                  Contains("; accepted: build again with both"));
}
