// Record of the device's registers at the start of a run: identity, meaning of its counts, limits of its efforts.
//
// The registers must be unchanged before force is enabled again: a different device may be connected by then, or the
// same one after a power failure, without its unsaved configuration.
// Thread: [setup], [normal]; never the haptic thread. Bound: about forty requests of at most `patience` each; the first
// without a reply ends the read.
#pragma once

#include <bit>

#include "firmware/identity.h"
#include "hal/printable.h"
#include "hal/register_read.h"

namespace tactus::hal {

class DeviceRecord {
 public:
  template <FrameLink Link>
  static Result<DeviceRecord> read(Link& link, std::chrono::milliseconds patience) {
    DeviceRecord record;
    for (unsigned i = 0; i < kRegisters; ++i) {
      const auto value = read_register(link, number_of(i), static_cast<std::uint8_t>(i), patience);
      if (!value.ok()) return value.status();
      record.values_[i] = value.value();
    }
    return record;
  }

  // An error is one line: the first register that differs, both values, what to do; or why it cannot be read.
  template <FrameLink Link>
  Status compare(Link& link, std::chrono::milliseconds patience) const {
    const auto now = read(link, patience);
    if (!now.ok()) return now.status();
    for (unsigned i = 0; i < kRegisters; ++i)
      if (now.value().values_[i] != values_[i]) return difference(now.value(), i);
    return Status::good();
  }

  std::string serial() const {
    std::string text;
    for (unsigned k = 0; k < firmware::kSerialWords; ++k)
      for (unsigned i = 0; i < 4; ++i)
        if (const auto c = static_cast<char>(values_[k] >> (8 * i)); c != '\0') text += c;
    return printable(text);
  }

 private:
  struct Range {
    std::uint16_t first, count;
  };
  static constexpr std::array<Range, 13> kRanges{{{firmware::number::kSerial, firmware::kSerialWords},
                                                  {firmware::number::kProtocol, 1},
                                                  {firmware::number::kDeviceClass, 1},
                                                  {firmware::number::kQuantum, 6},
                                                  {firmware::number::kMaxEffort, 6},
                                                  {firmware::number::kMaxSpeed, 6},
                                                  {firmware::number::kMaxForce, 1},
                                                  {firmware::number::kMaxTorque, 1},
                                                  {firmware::number::kPeriod, 1},
                                                  {firmware::number::kFadeFrames, 1},
                                                  {firmware::number::kBrakeFrames, 1},
                                                  {firmware::number::kDirection, 6},
                                                  {firmware::number::kOffset, 6}}};
  static constexpr unsigned kRegisters = [] {
    unsigned count = 0;
    for (const Range& range : kRanges) count += range.count;
    return count;
  }();

  static constexpr std::uint16_t number_of(unsigned i) {
    unsigned range = 0;
    for (; i >= kRanges[range].count; ++range) i -= kRanges[range].count;
    return static_cast<std::uint16_t>(kRanges[range].first + i);
  }

  Status difference(const DeviceRecord& now, unsigned i) const {
    const std::uint16_t number = number_of(i);
    if (number >= firmware::number::kSerial && number < firmware::number::kSerial + firmware::kSerialWords)
      return Status::error(
          fmt::format("device: its serial number is '{}', this run began with '{}'; connect that one again, or end the "
                      "run and start it with this one",
                      now.serial(), serial()));
    const firmware::Register& row = *firmware::find_register(number);
    const std::string of = row.count > 1 ? fmt::format(" of axis {}", number - row.number) : "";
    return Status::error(
        fmt::format("device: its {}{} (register {:#06x}) is {}, this run began with {}; write it back, or end the run "
                    "and start it again",
                    row.name, of, number, value_text(row, now.values_[i]), value_text(row, values_[i])));
  }

  static std::string value_text(const firmware::Register& row, std::uint32_t bits) {
    switch (row.type) {
      case firmware::RegisterType::kF32:
        return fmt::format("{:.9g}", std::bit_cast<float>(bits));
      case firmware::RegisterType::kI32:
        return fmt::format("{}", static_cast<std::int32_t>(bits));
      case firmware::RegisterType::kU32:
        break;
    }
    return fmt::format("{}", bits);
  }

  std::array<std::uint32_t, kRegisters> values_{};  // the serial number's words first
};

}  // namespace tactus::hal
