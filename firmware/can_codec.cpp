#include "firmware/can_codec.h"

#include <bit>

#include "firmware/little_endian.h"

namespace tactus::firmware {
namespace {

constexpr unsigned kCountBits = 22, kTimeShift = 3;
constexpr std::uint32_t kMaxMissed = 15;
constexpr std::int32_t kNotFinite = -32768, kMaxMantissa = 32767;
constexpr unsigned kMaxExponent = 15, kExponentBias = 20;

constexpr std::uint64_t field(std::uint64_t value, unsigned first, unsigned bits) noexcept {
  return (value & ((1ull << bits) - 1)) << first;
}
constexpr std::uint64_t taken(std::uint64_t word, unsigned first, unsigned bits) noexcept {
  return (word >> first) & ((1ull << bits) - 1);
}
constexpr std::int32_t signed_of(std::uint64_t value, unsigned bits) noexcept {
  const std::uint64_t sign = 1ull << (bits - 1);
  return static_cast<std::int32_t>(static_cast<std::int64_t>((value ^ sign)) - static_cast<std::int64_t>(sign));
}

CanFragment fragment(CanFunction function, std::uint64_t word) noexcept {
  CanFragment out{function, {}};
  put<std::uint64_t>(out.data, 0, word);
  return out;
}

std::uint64_t count_field(std::int32_t count, unsigned first) noexcept {
  if (count > kMaxCanCount) count = kMaxCanCount;
  if (count < -kMaxCanCount) count = -kMaxCanCount;
  return field(static_cast<std::uint32_t>(count), first, kCountBits);
}

// The number with the lowest `bits` bits `low` that is nearest to `expected`, or, forwards, the first at or after it.
std::uint32_t continued(std::uint32_t expected, std::uint32_t low, unsigned bits, bool forwards) noexcept {
  const std::uint32_t ahead = static_cast<std::uint32_t>(taken(low - expected, 0, bits));
  if (forwards) return expected + ahead;
  return expected + static_cast<std::uint32_t>(signed_of(ahead, bits));
}

bool is_finite(float x) noexcept { return (std::bit_cast<std::uint32_t>(x) & 0x7f800000u) != 0x7f800000u; }
float magnitude(float x) noexcept { return x < 0.0f ? -x : x; }
// 2^n, exact; -126 <= n <= 127.
float power_of_two(int n) noexcept { return std::bit_cast<float>(static_cast<std::uint32_t>(n + 127) << 23); }
float unit_of(unsigned exponent) noexcept {
  return power_of_two(static_cast<int>(exponent) - static_cast<int>(kExponentBias));
}

// Encodes three efforts with a common exponent.
std::uint64_t effort_fields(const float* effort) noexcept {
  float largest = 0.0f;
  for (unsigned i = 0; i < 3; ++i)
    if (is_finite(effort[i]) && magnitude(effort[i]) > largest) largest = magnitude(effort[i]);
  const float mantissa_limit = static_cast<float>(kMaxMantissa);
  unsigned exponent = 0;
  while (exponent < kMaxExponent && largest > mantissa_limit * unit_of(exponent)) ++exponent;
  const float holds = mantissa_limit * unit_of(exponent);
  const float shrink = largest > holds ? holds / largest : 1.0f;

  std::uint64_t word = field(exponent, 48, 4);
  for (unsigned i = 0; i < 3; ++i) {
    std::int32_t mantissa = kNotFinite;
    if (is_finite(effort[i])) {
      const float scaled = effort[i] * shrink / unit_of(exponent);
      mantissa = static_cast<std::int32_t>(scaled + (scaled < 0.0f ? -0.5f : 0.5f));
    }
    word |= field(static_cast<std::uint32_t>(mantissa), 16 * i, 16);
  }
  return word;
}

void take_efforts(std::uint64_t word, float* effort) noexcept {
  const float unit = unit_of(static_cast<unsigned>(taken(word, 48, 4)));
  for (unsigned i = 0; i < 3; ++i) {
    const std::int32_t mantissa = signed_of(taken(word, 16 * i, 16), 16);
    effort[i] = mantissa == kNotFinite ? std::bit_cast<float>(0x7fc00000u) : static_cast<float>(mantissa) * unit;
  }
}

}  // namespace

unsigned StateSplitter::split(const StateFrame& frame, std::array<CanFragment, kStateFragments + 1>& out) noexcept {
  constexpr std::array<CanFunction, kStateFragments> functions{CanFunction::kState0, CanFunction::kState1,
                                                               CanFunction::kState2};
  const std::uint32_t missed = frame.missed_commands < kMaxMissed ? frame.missed_commands : kMaxMissed;
  const std::array<std::uint64_t, kStateFragments> rest{
      field(static_cast<std::uint64_t>(frame.state), 48, 2) | field(frame.fault, 50, 6) |
          field(frame.time_us >> kTimeShift, 56, 8),
      field(frame.limits, 48, 16),
      field(frame.sequence >> 4, 48, 4) | field(missed, 52, 4) | field(frame.echoed_sequence, 56, 8),
  };
  for (unsigned i = 0; i < kStateFragments; ++i)
    out[i] =
        fragment(functions[i], count_field(frame.counts[2 * i], 0) | count_field(frame.counts[2 * i + 1], kCountBits) |
                                   field(frame.sequence, 44, 4) | rest[i]);

  if (status_sent_ && frame.buttons == buttons_ && frame.sequence % kStatusPeriods != 0) return kStateFragments;
  status_sent_ = true;
  buttons_ = frame.buttons;
  out[kStateFragments] =
      fragment(CanFunction::kStatus, field(frame.sequence, 0, 16) | field(frame.time_us, 16, 32) |
                                         field(frame.buttons, 48, 8) | field(frame.missed_commands, 56, 8));
  return kStateFragments + 1;
}

std::array<CanFragment, kCommandFragments> split_command(const CommandFrame& frame) noexcept {
  const std::uint64_t key = field(frame.sequence, 52, 8);
  return {fragment(CanFunction::kCommand0, effort_fields(frame.effort.data()) | key |
                                               field(static_cast<std::uint64_t>(frame.wanted), 60, 2) |
                                               field(frame.rearm ? 1u : 0u, 62, 1)),
          fragment(CanFunction::kCommand1,
                   effort_fields(frame.effort.data() + 3) | key | field(frame.sequence >> 8, 60, 4))};
}

bool FragmentSet::add(unsigned index, unsigned count, std::uint8_t key, const CanData& data) noexcept {
  const unsigned bit = 1u << index;
  if (present_ != 0 && (key != key_ || (present_ & bit) != 0)) forget();
  if (present_ == 0) looks_ = 0;
  key_ = key;
  present_ |= bit;
  words_[index] = get<std::uint64_t>(data, 0);
  if (present_ != (1u << count) - 1u) return false;
  present_ = 0;
  return true;
}

void FragmentSet::look() noexcept {
  if (present_ != 0 && ++looks_ >= kMaxLooks) forget();
}

void FragmentSet::forget() noexcept {
  if (present_ != 0) ++incomplete_;
  present_ = 0;
}

void StateAssembler::look() noexcept {
  set_.look();
  if (silent_looks_ < kGapLooks && ++silent_looks_ == kGapLooks) forget();
}

void StateAssembler::forget() noexcept {
  set_.forget();
  state_gap_ = status_gap_ = true;
}

bool StateAssembler::accept(CanFunction function, std::span<const std::byte> data, StateFrame& frame) noexcept {
  const unsigned index = static_cast<unsigned>(function) - static_cast<unsigned>(CanFunction::kState0);
  if (data.size() != kClassicSize || index > kStateFragments) {
    ++malformed_;
    return false;
  }
  CanData bytes{};
  for (std::size_t i = 0; i < kClassicSize; ++i) bytes[i] = data[i];
  const auto word = get<std::uint64_t>(bytes, 0);
  if (function == CanFunction::kStatus) {
    take_status(word);
    return false;
  }
  if (!set_.add(index, kStateFragments, static_cast<std::uint8_t>(taken(word, 44, 4)), bytes)) return false;
  rebuild(frame);
  return true;
}

void StateAssembler::take_status(std::uint64_t word) noexcept {
  // Older than the newest state by less than half the 16-bit range: a repeated status, or from a device that was reset.
  const std::uint32_t sequence = continued(sequence_, static_cast<std::uint32_t>(taken(word, 0, 16)), 16, status_gap_);
  if (is_newer(sequence_, sequence) && !follows_old_status(word)) return;
  const auto ahead = static_cast<std::uint32_t>(taken(word, 16, 32)) - static_cast<std::uint32_t>(time_us_);
  // Nearest to the rebuilt time, which it corrects; after a gap forwards only, by any amount.
  time_us_ += status_gap_ ? ahead : static_cast<std::uint64_t>(std::int64_t{static_cast<std::int32_t>(ahead)});
  sequence_ = sequence;
  buttons_ = static_cast<std::uint8_t>(taken(word, 48, 8));
  status_missed_ = static_cast<std::uint8_t>(taken(word, 56, 8));
  status_gap_ = state_gap_ = false;
  silent_looks_ = 0;
}

// True if two old statuses are apart in time as their sequences require, so they are not copies of one status: the
// device was reset, its time restarted, and the rebuilt states must show the step back.
bool StateAssembler::follows_old_status(std::uint64_t word) noexcept {
  const std::uint64_t before = old_status_;
  old_status_ = word;
  const auto periods = static_cast<std::uint32_t>(taken(word, 0, 16) - taken(before, 0, 16)) & 0xffffu;
  const auto elapsed_us = static_cast<std::uint32_t>(taken(word, 16, 32) - taken(before, 16, 32));
  const std::uint32_t expected_us = periods * period_us_;
  return before != 0 && periods >= 1 && periods <= 2 * kStatusPeriods && elapsed_us > expected_us / 2 &&
         elapsed_us < 2 * expected_us;
}

void StateAssembler::rebuild(StateFrame& frame) noexcept {
  for (unsigned i = 0; i < kStateFragments; ++i) {
    frame.counts[2 * i] = signed_of(taken(set_.word(i), 0, kCountBits), kCountBits);
    frame.counts[2 * i + 1] = signed_of(taken(set_.word(i), kCountBits, kCountBits), kCountBits);
  }
  frame.state = static_cast<State>(taken(set_.word(0), 48, 2));
  frame.fault = static_cast<std::uint16_t>(taken(set_.word(0), 50, 6));
  frame.limits = static_cast<std::uint16_t>(taken(set_.word(1), 48, 16));
  frame.buttons = buttons_;
  continue_sequence_and_time(frame);

  const auto missed = static_cast<std::uint8_t>(taken(set_.word(2), 52, 4));
  frame.missed_commands = missed < kMaxMissed || status_missed_ < kMaxMissed ? missed : status_missed_;
  // The echoed sequence is never newer than the last sent one. With `missed` saturated the byte may have wrapped.
  if (missed < kMaxMissed) echoed_ = sent_ - ((sent_ - static_cast<std::uint32_t>(taken(set_.word(2), 56, 8))) & 0xffu);
  frame.echoed_sequence = echoed_;
}

void StateAssembler::continue_sequence_and_time(StateFrame& frame) noexcept {
  const auto low = static_cast<std::uint32_t>(taken(set_.word(2), 44, 4) | (taken(set_.word(2), 48, 4) << 4));
  const auto quanta_low = static_cast<std::uint32_t>(taken(set_.word(0), 56, 8));
  std::uint64_t expected_quanta = (time_us_ >> kTimeShift) + 1;
  if (state_gap_) {
    frame.sequence = continued(sequence_ + 1, low, 8, true);
  } else {
    frame.sequence = continued(sequence_, low, 8, false);
    const auto step = static_cast<std::int32_t>(frame.sequence - sequence_);
    expected_quanta = (time_us_ + static_cast<std::uint64_t>(std::int64_t{step} * period_us_)) >> kTimeShift;
  }
  const auto expected_low = static_cast<std::uint32_t>(expected_quanta);
  const std::int32_t off = static_cast<std::int32_t>(continued(expected_low, quanta_low, 8, state_gap_) - expected_low);
  frame.time_us = (expected_quanta + static_cast<std::uint64_t>(std::int64_t{off})) << kTimeShift;
  // Also backwards: a stream that is sent again keeps its old sequence and time, whatever its length.
  sequence_ = frame.sequence;
  time_us_ = frame.time_us;
  state_gap_ = false;
  silent_looks_ = 0;
}

bool CommandAssembler::accept(CanFunction function, std::span<const std::byte> data, CommandFrame& frame) noexcept {
  const unsigned index = static_cast<unsigned>(function) - static_cast<unsigned>(CanFunction::kCommand0);
  if (data.size() != kClassicSize || index >= kCommandFragments) {
    ++malformed_;
    return false;
  }
  CanData bytes{};
  for (std::size_t i = 0; i < kClassicSize; ++i) bytes[i] = data[i];
  const auto word = get<std::uint64_t>(bytes, 0);
  if (function == CanFunction::kCommand0 && taken(word, 63, 1) != 0) {
    ++malformed_;
    return false;
  }
  if (!set_.add(index, kCommandFragments, static_cast<std::uint8_t>(taken(word, 52, 8)), bytes)) return false;

  // An invalid wanted state is passed on: the controller rejects and counts it, as on every link.
  frame.wanted = static_cast<State>(taken(set_.word(0), 60, 2));
  frame.rearm = taken(set_.word(0), 62, 1) != 0;
  const auto sequence_low = static_cast<std::uint32_t>(taken(set_.word(0), 52, 8) | (taken(set_.word(1), 60, 4) << 8));
  frame.sequence = sequence_ = continued(sequence_, sequence_low, 12, false);
  take_efforts(set_.word(0), frame.effort.data());
  take_efforts(set_.word(1), frame.effort.data() + 3);
  return true;
}

void pad_fd(std::span<const std::byte> frame, std::span<std::byte> out) noexcept {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = i < frame.size() ? frame[i] : std::byte{0};
}

std::span<const std::byte> unpad_fd(std::span<const std::byte> data, std::size_t padded, std::size_t size) noexcept {
  if (data.size() != padded || size > padded) return {};
  for (std::size_t i = size; i < padded; ++i)
    if (data[i] != std::byte{0}) return {};
  return data.first(size);
}

}  // namespace tactus::firmware
