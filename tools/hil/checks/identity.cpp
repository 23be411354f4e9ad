// Checks the device's identity and that its registers answer according to the table.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "firmware/identity.h"
#include "hal/identity_check.h"
#include "rt/base/clock.h"
#include "tools/hil/check.h"

namespace tactus::hil {
namespace {

namespace number = firmware::number;
using firmware::Access;
using firmware::Operation;
using firmware::Register;
using firmware::RegisterType;
using firmware::ServiceStatus;

std::string serial_of(Bench& bench) {
  std::string serial;
  for (unsigned k = 0; k < firmware::kSerialWords; ++k) {
    const auto word = bench.read(static_cast<std::uint16_t>(number::kSerial + k));
    for (unsigned i = 0; i < 4 && word.ok(); ++i) {
      const auto letter = static_cast<char>((word.value() >> (8 * i)) & 0xffu);
      if (letter >= 33 && letter < 127) serial.push_back(letter);
    }
  }
  return serial.empty() ? "without a serial number" : serial;
}

// Requests that must be refused, and the expected reason.
std::string refusals(Bench& bench) {
  struct Case {
    Operation operation;
    std::uint16_t address;
    std::uint32_t value;
    ServiceStatus answer;
    const char* what;
  };
  const Case cases[] = {
      {Operation::kRead, 0xffff, 0, ServiceStatus::kNoSuchRegister, "a register that does not exist was answered"},
      {Operation::kWrite, number::kProtocol, 7, ServiceStatus::kReadOnly, "a read-only register took a value"},
      {Operation::kWrite, number::kMaxForce, std::bit_cast<std::uint32_t>(-1.0f), ServiceStatus::kOutOfRange,
       "a negative force limit was taken"},
      {Operation::kWrite, number::kMaxForce, 0x7fc00000u, ServiceStatus::kOutOfRange, "NaN was taken as a force limit"},
      {static_cast<Operation>(9), number::kMaxForce, 0, ServiceStatus::kNoSuchOperation,
       "an operation that does not exist was answered"},
  };
  for (const Case& c : cases) {
    const auto reply = bench.call(c.operation, c.address, c.value);
    if (!reply.ok()) return reply.message();
    if (reply.value().status != c.answer) return c.what;
  }
  return {};
}

}  // namespace

CheckFinding check_identity(Bench& bench) {
  CheckFinding finding;
  finding.threshold =
      fmt::format("protocol {}, register_revision {} or above; period, watchdog, quanta and limits as {} has them",
                  firmware::kProtocolVersion, firmware::kRegisterRevision, bench.profile().name);
  const auto protocol = bench.read(number::kProtocol), version = bench.read(number::kFirmware),
             revision = bench.read(number::kRevision), device_class = bench.read(number::kDeviceClass);
  for (const auto* answer : {&protocol, &version, &revision, &device_class})
    if (!answer->ok()) return bad(answer->message(), finding.threshold);
  finding.measured = fmt::format("{}, class {}, firmware {}.{}.{}, protocol {}, registers {}", serial_of(bench),
                                 device_class.value(), version.value() >> 16, (version.value() >> 8) & 0xffu,
                                 version.value() & 0xffu, protocol.value(), revision.value());
  const Status same =
      hal::check_identity(bench.profile(), static_cast<std::uint32_t>(bench.period_ns() / 1000), bench.link(), kAnswer);
  if (!same.ok()) {
    finding.verdict = CheckVerdict::kBad;
    finding.reason = same.message();
  }
  if (same.ok() && revision.value() < firmware::kRegisterRevision) {
    finding.verdict = CheckVerdict::kBad;
    finding.reason = fmt::format("register_revision is {}, this program's is {}: update the device's firmware",
                                 revision.value(), firmware::kRegisterRevision);
  }
  return finding;
}

CheckFinding check_registers(Bench& bench) {
  CheckFinding finding;
  finding.threshold = "all readable, in range; refusals as the protocol says";
  Histogram answers;
  unsigned count = 0;
  for (const Register& row : firmware::all_registers()) {
    for (unsigned i = 0; i < row.count && row.access != Access::kCommand; ++i, ++count) {
      const std::int64_t asked_ns = MonotonicClock::now_ns();
      const auto value = bench.read(static_cast<std::uint16_t>(row.number + i));
      answers.record(MonotonicClock::now_ns() - asked_ns);
      if (!value.ok()) return bad(fmt::format("{}: {}", row.name, value.message()), finding.threshold);
      if (row.access == Access::kReadWrite && !firmware::is_in_range(row, value.value()))
        return bad(fmt::format("{} is out of its range", row.name), finding.threshold);
    }
  }
  finding.measured = fmt::format("{} read", count);
  finding.figures.push_back({"registers", static_cast<double>(count)});
  if (!bench.options().stepped) {
    finding.measured += fmt::format("; an answer takes {:.1f} ms, at most {:.1f} ms",
                                    static_cast<double>(answers.percentile_ns(50)) * 1e-6,
                                    static_cast<double>(answers.max_ns()) * 1e-6);
    finding.figures.push_back({"answer_p50_ms", static_cast<double>(answers.percentile_ns(50)) * 1e-6});
    finding.figures.push_back({"answer_max_ms", static_cast<double>(answers.max_ns()) * 1e-6});
  }
  if (std::string reason = refusals(bench); !reason.empty()) {
    finding.verdict = CheckVerdict::kBad;
    finding.reason = std::move(reason);
  }
  return finding;
}

}  // namespace tactus::hil
