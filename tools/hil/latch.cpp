#include "tools/hil/latch.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/hil/bench.h"

namespace tactus::hil {

std::span<const Record> in_phases(std::span<const Record> records, std::uint32_t first, std::uint32_t last) {
  const auto from =
      std::partition_point(records.begin(), records.end(), [&](const Record& r) { return r.phase < first; });
  const auto to = std::partition_point(from, records.end(), [&](const Record& r) { return r.phase <= last; });
  return {from, to};
}

std::string never_forced(std::span<const Record> records, std::uint32_t phase) {
  const auto part = in_phases(records, phase, phase);
  const auto newest = std::find_if(part.rbegin(), part.rend(), [](const Record& r) { return r.got == Got::kFresh; });
  if (newest == part.rend()) return "no whole state frame came while FORCE was asked for";
  const firmware::StateFrame& frame = newest->state;
  if (frame.state == firmware::State::kForce) return {};
  const bool unhomed = (frame.limits & bit_of(firmware::Limit::kNotHomed)) != 0;
  return fmt::format("FORCE was asked for, and the device is in {}{}", describe(frame),
                     unhomed ? ": it is not homed" : "");
}

std::string latch_broken(std::span<const Record> records, std::uint32_t phase, firmware::Fault fault) {
  const auto part = in_phases(records, phase, phase);
  for (const Record& record : part.subspan(part.size() / 2)) {
    if (record.got != Got::kFresh) continue;
    const bool latched =
        record.state.state == firmware::State::kBrake && record.state.fault == static_cast<std::uint16_t>(fault);
    if (!latched)
      return fmt::format("without a re-arm it should stay in BRAKE with fault {}, it is in {}",
                         static_cast<unsigned>(fault), describe(record.state));
  }
  return {};
}

}  // namespace tactus::hil
