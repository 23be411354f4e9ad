#include "firmware/protocol.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace tactus::firmware;

namespace {

StateFrame random_state(std::mt19937_64& random) {
  StateFrame f;
  f.state = static_cast<State>(random() % 4);
  f.buttons = static_cast<std::uint8_t>(random());
  f.missed_commands = static_cast<std::uint8_t>(random());
  f.fault = static_cast<std::uint16_t>(random());
  f.limits = static_cast<std::uint16_t>(random());
  f.sequence = static_cast<std::uint32_t>(random());
  f.echoed_sequence = static_cast<std::uint32_t>(random());
  f.time_us = random();
  for (auto& c : f.counts) c = static_cast<std::int32_t>(random());
  return f;
}

CommandFrame random_command(std::mt19937_64& random) {
  CommandFrame f;
  f.wanted = static_cast<State>(1 + random() % 3);
  f.rearm = (random() & 1u) != 0;
  f.sequence = static_cast<std::uint32_t>(random());
  std::uniform_real_distribution<float> effort(-50.0f, 50.0f);
  for (float& e : f.effort) e = effort(random);
  return f;
}

std::array<std::byte, kStateFrameSize> bytes_of(const StateFrame& f) {
  std::array<std::byte, kStateFrameSize> out{};
  encode_state(f, out);
  return out;
}

std::array<std::byte, kCommandFrameSize> bytes_of(const CommandFrame& f) {
  std::array<std::byte, kCommandFrameSize> out{};
  encode_command(f, out);
  return out;
}

template <std::size_t kSize>
void seal(std::array<std::byte, kSize>& frame) {
  const std::uint32_t crc = crc32c(std::span<const std::byte>(frame).first(kSize - 4));
  for (std::size_t i = 0; i < 4; ++i) frame[kSize - 4 + i] = static_cast<std::byte>(crc >> (8 * i));
}

// What the CRC of a frame changes by when one bit of it flips (for the CRC's own bits: the bit itself).
template <std::size_t kSize>
std::vector<std::uint32_t> syndromes() {
  std::array<std::byte, kSize - 4> zero{};
  const std::uint32_t base = crc32c(zero);
  std::vector<std::uint32_t> all;
  for (std::size_t bit = 0; bit < 8 * zero.size(); ++bit) {
    auto one = zero;
    one[bit / 8] = static_cast<std::byte>(1u << (bit % 8));
    all.push_back(crc32c(one) ^ base);
  }
  for (unsigned bit = 0; bit < 32; ++bit) all.push_back(1u << bit);
  return all;
}

}  // namespace

TEST_CASE("the CRC has the published values of CRC-32C") {
  std::array<std::byte, 9> digits{};
  for (std::size_t i = 0; i < digits.size(); ++i) digits[i] = static_cast<std::byte>('1' + i);
  CHECK(crc32c(digits) == 0xe3069283u);
  // RFC 3720, B.4: 32 bytes of zeros, of ones, incrementing, decrementing.
  std::array<std::byte, 32> b{};
  CHECK(crc32c(b) == 0x8a9136aau);
  b.fill(std::byte{0xff});
  CHECK(crc32c(b) == 0x62a8ab43u);
  for (std::size_t i = 0; i < 32; ++i) b[i] = static_cast<std::byte>(i);
  CHECK(crc32c(b) == 0x46dd794eu);
  std::reverse(b.begin(), b.end());
  CHECK(crc32c(b) == 0x113fdb5cu);
  CHECK(crc32c({}) == 0u);
}

TEST_CASE("a decoded frame is the frame that was encoded") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const StateFrame s = random_state(random);
    StateFrame s2;
    REQUIRE(decode_state(bytes_of(s), s2) == DecodeError::kNone);
    REQUIRE(s2 == s);
    const CommandFrame c = random_command(random);
    CommandFrame c2;
    REQUIRE(decode_command(bytes_of(c), c2) == DecodeError::kNone);
    REQUIRE(c2 == c);
  }
}

TEST_CASE("the bytes are at the offsets of the layout, little-endian") {
  StateFrame s;
  s.state = State::kForce;
  s.sequence = 0x04030201u;
  s.time_us = 0x1817161514131211ull;
  s.buttons = 0x51;
  s.counts = {0x24232221, -1, 0, 0, 0, 0x34333231};
  s.echoed_sequence = 0x44434241u;
  s.fault = 0x4645;
  s.limits = 0x4847;
  s.missed_commands = 0x52;
  const auto b = bytes_of(s);
  const auto at = [&](std::size_t i) { return std::to_integer<unsigned>(b[i]); };
  CHECK((at(0) == 0x74 && at(1) == 1 && at(2) == 1 && at(3) == 2));
  CHECK((at(4) == 1 && at(7) == 4));
  CHECK((at(8) == 0x11 && at(15) == 0x18));
  CHECK((at(16) == 0x21 && at(19) == 0x24 && at(20) == 0xff && at(36) == 0x31));
  CHECK((at(40) == 0x41 && at(44) == 0x45 && at(45) == 0x46 && at(46) == 0x47 && at(48) == 0x51 && at(49) == 0x52));
  CommandFrame c;
  c.wanted = State::kForce;
  c.rearm = true;
  c.sequence = 0x04030201u;
  c.effort[0] = 1.0f;  // 0x3f800000
  const auto d = bytes_of(c);
  const auto command_at = [&](std::size_t i) { return std::to_integer<unsigned>(d[i]); };
  CHECK((command_at(2) == 2 && command_at(3) == 2 && command_at(4) == 1 && command_at(8) == 1));
  CHECK((command_at(12) == 0 && command_at(14) == 0x80 && command_at(15) == 0x3f));
}

TEST_CASE("every flipped bit is found, and a refused frame changes nothing") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20; ++i) {
    auto s = bytes_of(random_state(random));
    for (std::size_t bit = 0; bit < 8 * s.size(); ++bit) {
      s[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
      StateFrame out;
      REQUIRE(decode_state(s, out) != DecodeError::kNone);
      REQUIRE(out == StateFrame{});
      s[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
    }
    auto c = bytes_of(random_command(random));
    for (std::size_t bit = 0; bit < 8 * c.size(); ++bit) {
      c[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
      CommandFrame out;
      REQUIRE(decode_command(c, out) != DecodeError::kNone);
      REQUIRE(out == CommandFrame{});
      c[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
    }
  }
}

TEST_CASE("every error of up to five bits changes the CRC") {
  // The CRC is linear: an error stays hidden if the syndromes of its bits cancel. Up to four bits cannot, if the sums
  // of two syndromes are all different, and different from 0. Five (and every odd number) cannot, if every syndrome
  // has one and the same value of a linear parity; the polynomial's factor x + 1 is such a parity.
  std::vector<std::uint32_t> bits = syndromes<kStateFrameSize>();
  REQUIRE(bits.size() == 8 * kStateFrameSize);
  std::vector<std::uint32_t> sums;
  for (std::size_t i = 0; i < bits.size(); ++i)
    for (std::size_t k = i + 1; k < bits.size(); ++k) sums.push_back(bits[i] ^ bits[k]);
  std::sort(sums.begin(), sums.end());
  CHECK(std::adjacent_find(sums.begin(), sums.end()) == sums.end());
  CHECK(sums.front() != 0);
  for (const std::uint32_t bit : bits) REQUIRE(std::popcount(bit) % 2 == 1);
}

TEST_CASE("each way of being wrong has its own number") {
  const auto good = bytes_of(StateFrame{});
  const auto good_command = bytes_of(CommandFrame{});
  StateFrame s;
  CommandFrame c;
  const auto changed = [&](std::size_t offset, unsigned value) {
    auto b = good;
    b[offset] = static_cast<std::byte>(value);
    seal(b);
    return decode_state(b, s);
  };
  const auto changed_command = [&](std::size_t offset, unsigned value) {
    auto b = good_command;
    b[offset] = static_cast<std::byte>(value);
    seal(b);
    return decode_command(b, c);
  };
  CHECK(decode_state({}, s) == DecodeError::kWrongSize);
  CHECK(decode_state(std::span(good).first(kStateFrameSize - 1), s) == DecodeError::kWrongSize);
  CHECK(decode_state(good_command, s) == DecodeError::kWrongSize);
  std::array<std::byte, kStateFrameSize + 1> longer{};
  std::copy(good.begin(), good.end(), longer.begin());
  CHECK(decode_state(longer, s) == DecodeError::kWrongSize);
  CHECK(changed(0, 0x75) == DecodeError::kWrongMagic);
  CHECK(changed(1, 2) == DecodeError::kWrongVersion);
  CHECK(changed(2, 2) == DecodeError::kWrongType);
  CHECK(changed(3, 4) == DecodeError::kWrongState);
  CHECK(changed(50, 1) == DecodeError::kReservedNotZero);
  CHECK(changed(51, 1) == DecodeError::kReservedNotZero);
  auto unsealed = good;
  unsealed[20] ^= std::byte{1};
  CHECK(decode_state(unsealed, s) == DecodeError::kWrongCrc);
  CHECK(changed_command(2, 1) == DecodeError::kWrongType);
  CHECK(changed_command(3, 0) == DecodeError::kWrongState);
  CHECK(changed_command(3, 4) == DecodeError::kWrongState);
  CHECK(changed_command(8, 3) == DecodeError::kReservedNotZero);
  CHECK(changed_command(11, 1) == DecodeError::kReservedNotZero);
  CHECK(changed_command(8, 1) == DecodeError::kNone);
}

TEST_CASE("random bytes of any length are refused and change nothing") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100000; ++i) {
    std::array<std::byte, 80> noise{};
    for (auto& b : noise) b = static_cast<std::byte>(random());
    if (i % 2 == 0) {
      noise[0] = std::byte{kMagic};
      noise[1] = std::byte{kProtocolVersion};
    }
    const std::size_t size = i % 3 == 0 ? kStateFrameSize : i % 3 == 1 ? kCommandFrameSize : random() % 81;
    StateFrame s;
    CommandFrame c;
    REQUIRE(decode_state(std::span(noise).first(size), s) != DecodeError::kNone);
    REQUIRE(decode_command(std::span(noise).first(size), c) != DecodeError::kNone);
    REQUIRE((s == StateFrame{} && c == CommandFrame{}));
  }
}

TEST_CASE("sequences are ordered over their wrap") {
  CHECK(is_newer(1, 0));
  CHECK_FALSE(is_newer(0, 0));
  CHECK_FALSE(is_newer(0, 1));
  CHECK(is_newer(0, 0xffffffffu));
  CHECK_FALSE(is_newer(0xffffffffu, 0));
}
