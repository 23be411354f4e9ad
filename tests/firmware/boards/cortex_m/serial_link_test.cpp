#include "firmware/boards/cortex_m/serial_link.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace tactus::firmware;

namespace {

using Bytes = std::vector<std::byte>;

struct CountingPort {
  int calls{0};
  void transmit() noexcept { ++calls; }
};

Bytes stuffed(std::span<const std::byte> frame) {
  std::array<std::byte, kMaxStuffedSize> out{};
  const std::size_t size = stuff(frame, out);
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

Bytes bytes(std::initializer_list<unsigned> values) {
  Bytes out;
  for (const unsigned v : values) out.push_back(static_cast<std::byte>(v));
  return out;
}

// The frames that a reader finds on a line.
std::vector<Bytes> read_all(FrameReader& reader, std::span<const std::byte> line) {
  std::vector<Bytes> frames;
  for (const std::byte b : line)
    if (reader.accept(b)) frames.emplace_back(reader.frame().begin(), reader.frame().end());
  return frames;
}

Bytes random_frame(std::mt19937_64& random, std::size_t size) {
  Bytes frame(size);
  for (auto& b : frame) b = random() % 3 == 0 ? std::byte{0} : static_cast<std::byte>(random());
  return frame;
}

struct Bench {
  CountingPort port;
  SerialLink<CountingPort> link{port};
  std::array<std::byte, kMaxFrameSize> buffer{};

  void receive(std::span<const std::byte> line) {
    for (const std::byte b : line) link.received(b);
  }
  void receive_command(std::uint32_t sequence) {
    std::array<std::byte, kCommandFrameSize> frame{};
    encode_command({State::kIdle, false, sequence, {}}, frame);
    receive(stuffed(frame));
  }
  std::uint32_t taken_sequence() {
    CommandFrame frame;
    const std::size_t size = link.receive_command(buffer);
    REQUIRE(decode_command(std::span<const std::byte>(buffer).first(size), frame) == DecodeError::kNone);
    return frame.sequence;
  }
  Bytes sent() {
    Bytes out;
    std::byte b{};
    while (link.next_to_send(b)) out.push_back(b);
    return out;
  }
};

Bytes request(const ServiceMessage& message) {
  std::array<std::byte, kServiceFrameSize> frame{};
  encode_service(message, ServiceDirection::kRequest, frame);
  return stuffed(frame);
}

}  // namespace

TEST_CASE("stuffed frames have the form that the method's paper gives") {
  CHECK(stuffed(bytes({0})) == bytes({1, 1, 0}));
  CHECK(stuffed(bytes({0, 0})) == bytes({1, 1, 1, 0}));
  CHECK(stuffed(bytes({0x11, 0x22, 0, 0x33})) == bytes({3, 0x11, 0x22, 2, 0x33, 0}));
  CHECK(stuffed(bytes({0x11, 0, 0, 0})) == bytes({2, 0x11, 1, 1, 1, 0}));
  CHECK(stuffed(Bytes(kMaxFrameSize + 1, std::byte{1})).empty());
}

TEST_CASE("a frame comes through, has no zero but its last, and grows by two bytes") {
  std::mt19937_64 random(1);
  FrameReader reader;
  for (int i = 0; i < 20000; ++i) {
    const Bytes frame = random_frame(random, 1 + random() % kMaxFrameSize);
    const Bytes line = stuffed(frame);
    REQUIRE(line.size() == frame.size() + 2);
    REQUIRE(std::find(line.begin(), line.end(), std::byte{0}) == line.end() - 1);
    REQUIRE(read_all(reader, line) == std::vector<Bytes>{frame});
  }
  CHECK(reader.malformed() == 0);
}

TEST_CASE("after any damage the reader is right again from the second frame end on") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    FrameReader reader;
    for (std::size_t k = random() % 400; k > 0; --k) (void)reader.accept(static_cast<std::byte>(random()));
    (void)reader.accept(std::byte{0});  // the end of whatever that was
    const Bytes frame = random_frame(random, 1 + random() % kMaxFrameSize);
    REQUIRE(read_all(reader, stuffed(frame)) == std::vector<Bytes>{frame});
  }
}

TEST_CASE("a reader that starts in the middle of a frame loses that one frame only") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 5000; ++i) {
    Bytes line = stuffed(random_frame(random, kStateFrameSize));
    const Bytes second = random_frame(random, kStateFrameSize);
    const Bytes more = stuffed(second);
    line.erase(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(1 + random() % (line.size() - 1)));
    line.insert(line.end(), more.begin(), more.end());
    FrameReader reader;
    const std::vector<Bytes> frames = read_all(reader, line);
    REQUIRE_FALSE(frames.empty());
    REQUIRE(frames.back() == second);
    REQUIRE(frames.size() <= 2);  // the rest of the first may look like a shorter frame: its CRC fails
  }
}

TEST_CASE("lines that are no frames are counted, empty ones are not") {
  FrameReader reader;
  CHECK(read_all(reader, bytes({0, 0, 0})).empty());
  CHECK(reader.malformed() == 0);
  CHECK(read_all(reader, bytes({5, 1, 2, 0})).empty());  // cut short
  CHECK(reader.malformed() == 1);
  Bytes longer(kMaxFrameSize + 2, std::byte{1});
  longer.front() = static_cast<std::byte>(longer.size());
  longer.push_back(std::byte{0});
  CHECK(read_all(reader, longer).empty());
  CHECK(reader.malformed() == 2);
  Bytes longest(kMaxFrameSize + 1, std::byte{1});
  longest.front() = static_cast<std::byte>(longest.size());
  longest.push_back(std::byte{0});
  CHECK(read_all(reader, longest).size() == 1);
  CHECK(reader.malformed() == 2);
}

TEST_CASE("commands are handed out once, oldest first, and what is none comes after them") {
  Bench b;
  CHECK(b.link.receive_command(b.buffer) == 0);
  b.receive(stuffed(bytes({1, 2, 3})));
  for (std::uint32_t i = 1; i <= 5; ++i) b.receive_command(i);
  for (std::uint32_t i = 1; i <= 5; ++i) CHECK(b.taken_sequence() == i);
  CHECK(b.link.receive_command(b.buffer) == 3);
  CHECK(b.link.receive_command(b.buffer) == 0);
  b.receive_command(6);
  CHECK(b.taken_sequence() == 6);
}

TEST_CASE("a frame whose bytes arrive over several periods is returned when it is complete") {
  Bench b;
  std::array<std::byte, kCommandFrameSize> frame{};
  encode_command({State::kIdle, false, 7, {}}, frame);
  const Bytes line = stuffed(frame);
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    b.link.received(line[i]);
    REQUIRE(b.link.receive_command(b.buffer) == 0);
  }
  b.link.received(line.back());
  CHECK(b.taken_sequence() == 7);
}

TEST_CASE("a request and a command on one line do not disturb each other") {
  Bench b;
  const ServiceMessage asked{
      .operation = Operation::kRead, .status = ServiceStatus::kGood, .tag = 9, .address = 0x123, .value = 0};
  b.receive_command(1);
  b.receive(request(asked));
  b.receive_command(2);
  ServiceMessage message;
  REQUIRE(b.link.receive_service(message));
  CHECK(message == asked);
  CHECK_FALSE(b.link.receive_service(message));
  CHECK(b.taken_sequence() == 1);
  CHECK(b.taken_sequence() == 2);
}

TEST_CASE("a broken request is refused and counted, a broken command is the controller's to refuse") {
  Bench b;
  Bytes line =
      request({.operation = Operation::kRead, .status = ServiceStatus::kGood, .tag = 9, .address = 0x123, .value = 0});
  line[line.size() - 2] ^= std::byte{0x80};
  b.receive(line);
  ServiceMessage message;
  CHECK_FALSE(b.link.receive_service(message));
  CHECK(b.link.requests_refused() == 1);
  b.receive(stuffed(bytes({1, 2, 3})));
  CHECK(b.link.receive_command(b.buffer) == 3);
}

TEST_CASE("states and replies are sent byte-stuffed and in order, and the port is started for each") {
  Bench b;
  std::array<std::byte, kStateFrameSize> state{};
  encode_state({}, state);
  const ServiceMessage reply{
      .operation = Operation::kRead, .status = ServiceStatus::kReadOnly, .tag = 4, .address = 5, .value = 6};
  std::array<std::byte, kServiceFrameSize> reply_frame{};
  encode_service(reply, ServiceDirection::kReply, reply_frame);
  b.link.send_state(state);
  b.link.reply_service(reply);
  CHECK(b.port.calls == 2);
  Bytes expected = stuffed(state);
  const Bytes second = stuffed(reply_frame);
  expected.insert(expected.end(), second.begin(), second.end());
  CHECK(b.sent() == expected);
}

TEST_CASE("what a full ring cannot hold is counted, and only complete frames are dropped") {
  Bench b;
  std::array<std::byte, kStateFrameSize> state{};
  encode_state({}, state);
  const std::size_t size = kStateFrameSize + 2, fit = SerialLink<CountingPort>::kRingSize / size;
  for (std::size_t i = 0; i < fit + 3; ++i) b.link.send_state(state);
  CHECK(b.link.frames_not_sent() == 3);
  CHECK(b.sent().size() == fit * size);

  for (std::size_t i = 0; i < SerialLink<CountingPort>::kRingSize + 10; ++i) b.link.received(std::byte{0x55});
  CHECK(b.link.bytes_lost() == 10);
  CHECK(b.link.receive_command(b.buffer) == 0);
  b.link.received(std::byte{0});
  b.receive_command(1);
  CHECK(b.taken_sequence() == 1);
}

TEST_CASE("rings keep their order over every wrap of their indices") {
  std::mt19937_64 random(4);
  ByteRing<8> ring;
  unsigned in = 0, out = 0;
  for (int i = 0; i < 100000; ++i) {
    if (random() % 2 == 0) {
      const bool taken = ring.push(static_cast<std::byte>(in));
      REQUIRE(taken == (in - out < 8));
      in += taken ? 1u : 0u;
    } else {
      std::byte b{};
      const bool had = ring.pop(b);
      REQUIRE(had == (in != out));
      if (had) REQUIRE(b == static_cast<std::byte>(out++));
    }
    REQUIRE(ring.size() == in - out);
  }
}
