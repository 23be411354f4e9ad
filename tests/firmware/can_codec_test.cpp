#include "firmware/can_codec.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "firmware/little_endian.h"

using namespace tactus::firmware;

namespace {

constexpr std::uint32_t kPeriod_us = 1000;

using Fragments = std::array<CanFragment, kStateFragments + 1>;

std::uint64_t word_of(const CanFragment& fragment) { return get<std::uint64_t>(fragment.data, 0); }

// A device that runs: counts wander, the clock jitters, now and then a button.
struct RunningDevice {
  std::mt19937_64 random;
  StateFrame frame;
  std::uint32_t jitter_us;
  std::uint64_t nominal_us;

  explicit RunningDevice(std::uint64_t seed, std::uint32_t sequence, std::uint64_t time_us, std::uint32_t jitter = 300)
      : random(seed), jitter_us(jitter), nominal_us(time_us) {
    frame.sequence = sequence;
  }

  const StateFrame& next() {
    nominal_us += kPeriod_us;
    ++frame.sequence;
    frame.time_us = nominal_us + random() % jitter_us;
    for (auto& count : frame.counts)
      count = static_cast<std::int32_t>(random() % (2 * kMaxCanCount + 1)) - kMaxCanCount;
    frame.state = static_cast<State>(random() % 4);
    frame.fault = static_cast<std::uint16_t>(random() % 64);
    frame.limits = static_cast<std::uint16_t>(random());
    frame.missed_commands = static_cast<std::uint8_t>(random() % 15);
    if (random() % 37 == 0) frame.buttons = static_cast<std::uint8_t>(random());
    return frame;
  }
};

// All of one period; true if a frame came out.
bool deliver(StateAssembler& assembler, const Fragments& fragments, unsigned count, StateFrame& out) {
  bool whole = false;
  for (unsigned i = 0; i < count; ++i) whole |= assembler.accept(fragments[i].function, fragments[i].data, out);
  return whole;
}

CommandFrame command_of(std::uint32_t sequence, const std::array<float, kAxes>& effort) {
  CommandFrame command;
  command.wanted = State::kForce;
  command.sequence = sequence;
  command.effort = effort;
  return command;
}

}  // namespace

TEST_CASE("identifiers: function above node, commands win the bus over states and states over service") {
  CHECK(can_id(CanFunction::kCommand0, 1) == 0x081);
  CHECK(can_id(CanFunction::kServiceReply, 127) == 0x47f);
  std::uint32_t before = 0;
  for (unsigned function = 1; function <= 8; ++function) {
    for (const std::uint8_t node : {std::uint8_t{1}, kMaxCanNode}) {
      const auto id = can_id(static_cast<CanFunction>(function), node);
      CHECK((id > before && id < 0x800));
      CHECK(can_function(id) == static_cast<CanFunction>(function));
      before = id;
    }
  }
}

TEST_CASE("the bits of the fragments are at the positions of the table") {
  StateFrame s;
  s.state = State::kBrake;
  s.fault = 0x2a;
  s.limits = 0xbeef;
  s.buttons = 0x5a;
  s.missed_commands = 9;
  s.sequence = 0x12345670;
  s.echoed_sequence = 0xabcdef91;
  s.time_us = 0x1122334455667788ull;
  s.counts = {1, -1, 0x12345, -0x12345, kMaxCanCount, -kMaxCanCount};
  Fragments out;
  StateSplitter splitter;
  REQUIRE(splitter.split(s, out) == 4);
  const auto at = [&](unsigned fragment, unsigned first, unsigned bits) {
    return (word_of(out[fragment]) >> first) & ((1ull << bits) - 1);
  };
  CHECK((at(0, 0, 22) == 1 && at(0, 22, 22) == 0x3fffff));
  CHECK((at(1, 0, 22) == 0x12345 && at(1, 22, 22) == 0x400000 - 0x12345));
  CHECK((at(2, 0, 22) == 0x1fffff && at(2, 22, 22) == 0x200001));
  for (unsigned i = 0; i < 3; ++i) CHECK(at(i, 44, 4) == 0x0);
  CHECK((at(0, 48, 2) == 3 && at(0, 50, 6) == 0x2a && at(0, 56, 8) == ((0x788u >> 3) & 0xffu)));
  CHECK(at(1, 48, 16) == 0xbeef);
  CHECK((at(2, 48, 4) == 0x7 && at(2, 52, 4) == 9 && at(2, 56, 8) == 0x91));
  CHECK((at(3, 0, 16) == 0x5670 && at(3, 16, 32) == 0x55667788 && at(3, 48, 8) == 0x5a && at(3, 56, 8) == 9));

  CommandFrame c = command_of(0x12345abc, {0.5f, 0.0f, -0.5f, 0.0f, 0.0f, 0.0f});
  c.rearm = true;
  const auto command = split_command(c);
  const auto first = word_of(command[0]), second = word_of(command[1]);
  // 0.5 = 2^-1 needs m <= 32767: m 2^(e - 20) with e = 5 gives m = 2^14.
  CHECK(((first & 0xffff) == 0x4000 && ((first >> 16) & 0xffff) == 0 && ((first >> 32) & 0xffff) == 0xc000));
  CHECK((((first >> 48) & 0xf) == 5 && ((first >> 52) & 0xff) == 0xbc && first >> 60 == (2u | 4u)));
  CHECK(second == ((0xbcull << 52) | (0xaull << 60)));
}

TEST_CASE("a running device's states arrive as they were, the time to its quantum") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RunningDevice device(seed, 0xffff'ff00u + static_cast<std::uint32_t>(seed * 13), 0xffff'0000u + seed * 7777);
    StateSplitter splitter;
    StateAssembler assembler(kPeriod_us);
    StateFrame out;
    Fragments fragments;
    std::uint32_t ahead = 0;
    std::uint64_t ahead_quanta = 0;
    for (unsigned period = 0; period < 3000; ++period) {
      const StateFrame& sent = device.next();
      const unsigned count = splitter.split(sent, fragments);
      assembler.look();
      REQUIRE(deliver(assembler, fragments, count, out));
      REQUIRE(out.counts == sent.counts);
      REQUIRE((out.state == sent.state && out.fault == sent.fault && out.limits == sent.limits));
      REQUIRE(out.missed_commands == sent.missed_commands);
      if (period == 0) continue;  // the first status comes behind the first state
      REQUIRE((out.sequence & 0xffffu) == (sent.sequence & 0xffffu));
      // What the first status could not tell is a constant: the upper halves.
      if (period == 1) {
        ahead = sent.sequence - out.sequence;
        ahead_quanta = (sent.time_us >> 3) - (out.time_us >> 3);
      }
      REQUIRE(sent.sequence - out.sequence == ahead);
      REQUIRE((sent.time_us >> 3) - (out.time_us >> 3) == ahead_quanta);
    }
    CHECK((assembler.incomplete() == 0 && assembler.malformed() == 0));
  }
}

TEST_CASE("buttons come with the status, one period after they changed at the latest") {
  RunningDevice device(5, 0, 0);
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame out;
  Fragments fragments;
  std::uint8_t before = 0;
  unsigned with_status = 0;
  for (unsigned period = 0; period < 5000; ++period) {
    const StateFrame& sent = device.next();
    const unsigned count = splitter.split(sent, fragments);
    with_status += count == 4 ? 1 : 0;
    if ((sent.buttons != before && period > 0) || sent.sequence % kStatusPeriods == 0) REQUIRE(count == 4);
    assembler.look();
    REQUIRE(deliver(assembler, fragments, count, out));
    REQUIRE(out.buttons == before);
    before = sent.buttons;
  }
  CHECK(with_status < 5000 / 10 + 5000 / 37 + 60);
}

TEST_CASE("lost fragments cost their own period and are counted, never mixed with another period's") {
  std::mt19937_64 random(11);
  RunningDevice device(12, 100, 5000);
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame out;
  Fragments fragments;
  std::uint32_t damaged = 0, vanished = 0, newest = 0;
  std::uint64_t newest_time = 0;
  for (unsigned period = 0; period < 20000; ++period) {
    const StateFrame& sent = device.next();
    const unsigned count = splitter.split(sent, fragments);
    const unsigned kept = random() % 4 == 0 ? random() % 8 : 7;  // bit i: fragment i arrives
    assembler.look();
    bool whole = false;
    for (unsigned i = 0; i < count; ++i)
      if (i == 3 || (kept >> i & 1u) != 0) whole |= assembler.accept(fragments[i].function, fragments[i].data, out);
    if (kept == 0) ++vanished;
    if (kept != 0 && kept != 7) ++damaged;
    REQUIRE(whole == (kept == 7));
    if (!whole) continue;
    REQUIRE((out.counts == sent.counts && out.limits == sent.limits && out.fault == sent.fault));
    REQUIRE(static_cast<std::int32_t>(out.sequence - newest) > 0);
    REQUIRE(out.time_us > newest_time);
    newest = out.sequence;
    newest_time = out.time_us;
  }
  for (unsigned i = 0; i < FragmentSet::kMaxLooks; ++i) assembler.look();
  CHECK(damaged > 1000);
  CHECK(vanished > 100);
  CHECK(assembler.incomplete() == damaged);
}

TEST_CASE("a fragment that waits too long is given up before its key comes around again") {
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame frame, out;
  Fragments first, later;
  frame.sequence = 3;
  frame.counts.fill(1);
  splitter.split(frame, first);
  frame.sequence = 3 + 16;
  frame.counts.fill(2);  // the same low four bits
  splitter.split(frame, later);
  CHECK_FALSE(assembler.accept(first[0].function, first[0].data, out));
  for (unsigned i = 0; i < 15; ++i) assembler.look();  // one before the period of the other
  CHECK(assembler.incomplete() == 1);
  CHECK_FALSE(assembler.accept(later[1].function, later[1].data, out));
  CHECK_FALSE(assembler.accept(later[2].function, later[2].data, out));
  CHECK(assembler.accept(later[0].function, later[0].data, out));
  CHECK(out.counts == frame.counts);
}

TEST_CASE("a few looks between fragments are no loss") {
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame frame, out;
  Fragments fragments;
  splitter.split(frame, fragments);
  CHECK_FALSE(assembler.accept(fragments[0].function, fragments[0].data, out));
  for (unsigned i = 1; i < FragmentSet::kMaxLooks; ++i) assembler.look();
  CHECK_FALSE(assembler.accept(fragments[1].function, fragments[1].data, out));
  CHECK(assembler.accept(fragments[2].function, fragments[2].data, out));
  // Nor is it when the next one is cut as well.
  CHECK_FALSE(assembler.accept(fragments[0].function, fragments[0].data, out));
  for (unsigned i = 1; i < FragmentSet::kMaxLooks; ++i) assembler.look();
  CHECK_FALSE(assembler.accept(fragments[1].function, fragments[1].data, out));
  CHECK(assembler.accept(fragments[2].function, fragments[2].data, out));
  CHECK(assembler.incomplete() == 0);
}

TEST_CASE("sequence and time go on upwards over any gap and any restart of the device, and settle with the status") {
  std::mt19937_64 random(21);
  for (unsigned round = 0; round < 300; ++round) {
    StateSplitter splitter;
    StateAssembler assembler(kPeriod_us);
    StateFrame out, before;
    Fragments fragments;
    RunningDevice device(random(), static_cast<std::uint32_t>(random()), random() >> 8);
    for (unsigned i = 0; i < 25; ++i) {
      assembler.look();
      REQUIRE(deliver(assembler, fragments, splitter.split(device.next(), fragments), out));
      if (i > 0) {
        REQUIRE(is_newer(out.sequence, before.sequence));
        REQUIRE(out.time_us > before.time_us);
      }
      before = out;
    }
    const bool restarts = random() % 2 == 0;
    const std::uint32_t silent = StateAssembler::kGapLooks + static_cast<std::uint32_t>(random() % 5000);
    for (std::uint32_t i = 0; i < silent; ++i) assembler.look();
    if (restarts) {
      device = RunningDevice(random(), 0, 0);
      splitter = StateSplitter();
    } else {
      device.frame.sequence += silent;
      device.nominal_us += std::uint64_t{silent} * kPeriod_us;
    }
    for (unsigned i = 0; i < 25; ++i) {
      assembler.look();
      REQUIRE(deliver(assembler, fragments, splitter.split(device.next(), fragments), out));
      REQUIRE(is_newer(out.sequence, before.sequence));
      REQUIRE(out.time_us > before.time_us);
      before = out;
    }
    CHECK((out.sequence & 0xffffu) == (device.frame.sequence & 0xffffu));
    CHECK((out.time_us >> 3 & 0x1fffffffu) == (device.frame.time_us >> 3 & 0x1fffffffu));
  }
}

TEST_CASE("a device that is reset shows itself by its time or its sequence within three statuses, without any gap") {
  std::mt19937_64 random(22);
  for (unsigned round = 0; round < 300; ++round) {
    const bool same_splitter = round % 2 == 0;  // the status after a reset waits for its turn
    StateSplitter splitter;
    StateAssembler assembler(kPeriod_us);
    StateFrame out, newest;
    Fragments fragments;
    RunningDevice device(random(), 1000 + static_cast<std::uint32_t>(random() % 1000000),
                         3000000 + random() % (1u << 30));
    bool seen = false;
    for (unsigned i = 0; i < 60; ++i) {
      if (i == 30) {
        device = RunningDevice(random(), 0, 0);
        if (!same_splitter) splitter = StateSplitter();
      }
      assembler.look();
      REQUIRE(deliver(assembler, fragments, splitter.split(device.next(), fragments), out));
      const bool advances = i == 0 || (is_newer(out.sequence, newest.sequence) && out.time_us > newest.time_us);
      if (i < 30) REQUIRE(advances);
      seen = seen || !advances;
      if (advances) newest = out;
    }
    CAPTURE(round);
    CHECK(seen);
  }
}

TEST_CASE("states that are sent again come out as old ones, however many, and an old status changes nothing") {
  RunningDevice device(31, 50000, 1000000);
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame out;
  std::vector<std::pair<Fragments, unsigned>> sent;
  std::vector<std::uint32_t> sequences;
  const auto take = [&](unsigned i) {
    assembler.look();
    REQUIRE(deliver(assembler, sent[i].first, sent[i].second, out));
  };
  for (unsigned i = 0; i < 600; ++i) {
    Fragments fragments;
    const unsigned count = splitter.split(device.next(), fragments);
    sent.emplace_back(fragments, count);
    take(i);
    sequences.push_back(out.sequence);
  }
  const CanFragment old_status = sent[99].first[kStateFragments];
  const std::uint8_t buttons = out.buttons;
  REQUIRE((sent[99].second == 4 && old_status.data[6] != std::byte{buttons}));
  CHECK_FALSE(assembler.accept(old_status.function, old_status.data, out));
  take(599);
  CHECK((out.buttons == buttons && out.sequence == sequences[599]));

  for (unsigned from = 520; from > 0; from -= 40) {
    for (unsigned i = 0; i < 80; ++i) {
      take(from + i);
      REQUIRE(out.sequence == sequences[from + i]);
    }
  }
}

TEST_CASE("a clock that stands still is seen to stand still") {
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame frame, out;
  Fragments fragments;
  frame.time_us = 123456;
  std::uint64_t before = 0;
  for (frame.sequence = 1; frame.sequence < 50; ++frame.sequence) {
    assembler.look();
    REQUIRE(deliver(assembler, fragments, splitter.split(frame, fragments), out));
    if (frame.sequence > 2) REQUIRE(out.time_us <= before);
    before = (out.time_us | 7u);  // to its quantum
  }
}

TEST_CASE("the echo is rebuilt from the sent commands, and does not change while the device receives none") {
  std::mt19937_64 random(41);
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame frame, out;
  Fragments fragments;
  std::uint32_t sent = 0xffff'ff80u;
  for (unsigned i = 0; i < 2000; ++i) {
    assembler.sent(++sent);
    ++frame.sequence;
    frame.time_us += kPeriod_us;
    frame.echoed_sequence = sent - static_cast<std::uint32_t>(random() % 15);
    frame.missed_commands = 2;
    assembler.look();
    REQUIRE(deliver(assembler, fragments, splitter.split(frame, fragments), out));
    REQUIRE(out.echoed_sequence == frame.echoed_sequence);
  }
  const std::uint32_t last = frame.echoed_sequence;
  frame.missed_commands = 15;
  for (unsigned i = 0; i < 1000; ++i) {
    assembler.sent(++sent);
    ++frame.sequence;
    frame.time_us += kPeriod_us;
    assembler.look();
    REQUIRE(deliver(assembler, fragments, splitter.split(frame, fragments), out));
    REQUIRE(out.echoed_sequence == last);
  }
}

TEST_CASE("missed commands beyond fifteen come with the status") {
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame frame, out;
  Fragments fragments;
  for (unsigned missed = 0; missed < 400; ++missed) {
    ++frame.sequence;
    frame.time_us += kPeriod_us;
    frame.missed_commands = static_cast<std::uint8_t>(missed < 255 ? missed : 255);
    assembler.look();
    REQUIRE(deliver(assembler, fragments, splitter.split(frame, fragments), out));
    if (missed < 15) CHECK(out.missed_commands == missed);
    if (missed >= 30)
      CHECK((out.missed_commands <= frame.missed_commands && out.missed_commands + 11 > frame.missed_commands));
  }
}

TEST_CASE("counts beyond the fragment's range stop at its ends") {
  StateSplitter splitter;
  StateAssembler assembler(kPeriod_us);
  StateFrame frame, out;
  Fragments fragments;
  frame.counts = {kMaxCount, -kMaxCount, kMaxCanCount + 1, -kMaxCanCount - 1, kMaxCanCount, -kMaxCanCount};
  REQUIRE(deliver(assembler, fragments, splitter.split(frame, fragments), out));
  CHECK(out.counts ==
        AxisCounts{kMaxCanCount, -kMaxCanCount, kMaxCanCount, -kMaxCanCount, kMaxCanCount, -kMaxCanCount});
}

TEST_CASE("what is of another length, function or has its zero bit set is malformed and changes nothing") {
  CommandAssembler commands;
  StateAssembler states(kPeriod_us);
  CommandFrame command;
  StateFrame state;
  const std::array<std::byte, 64> bytes{};
  for (std::size_t size = 0; size <= 64; ++size) {
    if (size == kClassicSize) continue;
    CHECK_FALSE(commands.accept(CanFunction::kCommand0, std::span(bytes).first(size), command));
    CHECK_FALSE(states.accept(CanFunction::kState0, std::span(bytes).first(size), state));
  }
  const auto eight = std::span(bytes).first(kClassicSize);
  CHECK_FALSE(commands.accept(CanFunction::kState0, eight, command));
  CHECK_FALSE(states.accept(CanFunction::kCommand1, eight, state));
  CHECK_FALSE(states.accept(CanFunction::kServiceReply, eight, state));
  auto reserved = split_command(command_of(1, {}))[0];
  reserved.data[7] |= std::byte{0x80};
  CHECK_FALSE(commands.accept(reserved.function, reserved.data, command));
  CHECK(commands.malformed() == 66);
  CHECK(states.malformed() == 66);
  CHECK((commands.incomplete() == 0 && states.incomplete() == 0));
  CHECK(command == CommandFrame{});
  CHECK(state == StateFrame{});
}

TEST_CASE("any fragments whatever give frames that encode, within their ranges") {
  std::mt19937_64 random(71);
  StateAssembler states(kPeriod_us);
  CommandAssembler commands;
  unsigned whole_states = 0, whole_commands = 0;
  for (unsigned i = 0; i < 200000; ++i) {
    CanData data;
    for (auto& b : data) b = static_cast<std::byte>(random());
    if (random() % 8 != 0) {  // often one key
      data[5] = std::byte{0};
      data[6] = std::byte{0x50};
    }
    StateFrame state;
    CommandFrame command;
    if (random() % 4 == 0) {
      states.look();
      commands.look();
    }
    if (states.accept(static_cast<CanFunction>(3 + random() % 4), data, state)) {
      ++whole_states;
      for (const auto count : state.counts) REQUIRE((count >= -kMaxCanCount - 1 && count <= kMaxCanCount));
      REQUIRE((state.fault < 64 && static_cast<unsigned>(state.state) < 4));
    }
    if (commands.accept(static_cast<CanFunction>(1 + random() % 2), data, command)) {
      ++whole_commands;
      for (const float e : command.effort) REQUIRE((!std::isfinite(e) || std::abs(e) <= 32768.0f / 32.0f));
    }
  }
  CHECK((whole_states > 1000 && whole_commands > 1000));
}

TEST_CASE("frames fit CAN FD's lengths and come back, with zeros behind them and nothing else") {
  std::array<std::byte, kStateFrameSize> frame;
  frame.fill(std::byte{0xa5});
  std::array<std::byte, kFdStateSize> padded;
  padded.fill(std::byte{0xff});
  pad_fd(frame, padded);
  const auto back = unpad_fd(padded, kFdStateSize, kStateFrameSize);
  REQUIRE(back.size() == kStateFrameSize);
  CHECK(std::equal(back.begin(), back.end(), frame.begin()));
  CHECK(unpad_fd(std::span(padded).first(63), kFdStateSize, kStateFrameSize).empty());
  for (std::size_t i = kStateFrameSize; i < kFdStateSize; ++i) {
    auto changed = padded;
    changed[i] = std::byte{1};
    CHECK(unpad_fd(changed, kFdStateSize, kStateFrameSize).empty());
  }
}
