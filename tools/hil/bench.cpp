#include "tools/hil/bench.h"

#include <fmt/format.h>

#include <cmath>

namespace tactus::hil {
namespace {

using firmware::ServiceMessage;
using firmware::ServiceStatus;
using firmware::State;

const char* fault_words(std::uint16_t fault) {
  switch (static_cast<firmware::Fault>(fault)) {
    case firmware::Fault::kNone:
      return "none";
    case firmware::Fault::kCommandsLost:
      return "commands lost";
    case firmware::Fault::kEmergencyStop:
      return "e-stop";
    case firmware::Fault::kOverspeed:
      return "overspeed";
    case firmware::Fault::kEffortNotFinite:
      return "effort not finite";
    case firmware::Fault::kMotorBus:
      return "motor supply";
    case firmware::Fault::kBadConfiguration:
      return "bad configuration";
    case firmware::Fault::kEncoder:
      return "encoder";
    case firmware::Fault::kOverheated:
      return "overheated";
    case firmware::Fault::kSelfTest:
      return "self-test";
  }
  return "unknown";
}

const char* refusal_words(ServiceStatus status) {
  switch (status) {
    case ServiceStatus::kGood:
      return "good";
    case ServiceStatus::kNoSuchRegister:
      return "no such register";
    case ServiceStatus::kReadOnly:
      return "read only";
    case ServiceStatus::kOutOfRange:
      return "out of range";
    case ServiceStatus::kWrongState:
      return "not in this state";
    case ServiceStatus::kNoSuchOperation:
      return "no such operation";
    case ServiceStatus::kBusy:
      return "busy";
  }
  return "an unknown status";
}

ExchangeSettings settings_of(const HilOptions& options) {
  return {std::llround(1e9 / options.rate_Hz), options.stepped, options.setup};
}

}  // namespace

std::string describe(const firmware::StateFrame& frame) {
  constexpr const char* kStates[] = {"RESET", "IDLE", "FORCE", "BRAKE"};
  const std::string state = kStates[static_cast<std::size_t>(frame.state) & 3u];
  return frame.fault == 0 ? state : fmt::format("{}, fault {} ({})", state, frame.fault, fault_words(frame.fault));
}

Bench::Bench(hal::AnyLink& link, const hal::DeviceProfile& profile, Provoker& provoker, const HilOptions& options)
    : link_(link),
      profile_(profile),
      provoker_(provoker),
      options_(options),
      settings_(settings_of(options)),
      conversation_{.codec = hal::FrameCodec(profile.kinematics, profile.quantum, profile.properties.has_rotation),
                    .command_sequence = 0,
                    .state = {},
                    .sample = {}} {}

std::uint64_t Bench::ticks(double seconds) const noexcept {
  return static_cast<std::uint64_t>(std::llround(seconds * options_.rate_Hz));
}

Result<ExchangeResult> Bench::exchange(std::span<const ExchangePhase> plan, const Director& director, bool keep) {
  std::uint64_t all = 0, seen = 0;
  for (const ExchangePhase& phase : plan) all += phase.ticks;
  const Director with_progress = [&](const Record& record) {
    if (progress_ && all > 0 && ++seen % 256 == 0)
      progress_(std::min(1.0, static_cast<double>(seen) / static_cast<double>(all)));
    return director ? director(record) : Next::kGoOn;
  };
  auto result = run_exchange(link_, conversation_, settings_, plan, with_progress, keep);
  if (result.ok() && !options_.stepped) setup_ = result.value().setup;
  if (result.ok() && result.value().dropped_records > 0)
    return Status::error(fmt::format("{} records of the exchange were lost: this machine did not keep up",
                                     result.value().dropped_records));
  return result;
}

const Result<QuietExchange>& Bench::quiet() {
  if (quiet_) return *quiet_;
  const ExchangePhase plan[] = {{.ticks = ticks(options_.quiet_s)}};
  auto result = exchange(plan);
  if (!result.ok()) return quiet_.emplace(result.status());
  QuietExchange quiet;
  quiet.result = std::move(result).value();
  for (const Record& record : quiet.result.records) {
    quiet.counts.add(record);
    quiet.times.add(record);
  }
  return quiet_.emplace(std::move(quiet));
}

Status Bench::settle() {
  constexpr std::uint64_t kPatience = 60;  // periods; time limit for the device to act on a re-arm
  const ExchangePhase plan[] = {{.ticks = 20}, {.ticks = kPatience, .rearm = true}, {.ticks = 20}};
  auto result = exchange(plan);
  if (!result.ok()) return result.status();
  const Record& last = result.value().records.back();
  if (last.got == Got::kDisconnected) return Status::error("the device is away: plug it in");
  const bool heard = std::any_of(result.value().records.end() - 20, result.value().records.end(),
                                 [](const Record& r) { return r.got == Got::kFresh; });
  if (!heard) return Status::error("no whole state frame comes: check the cable and the rate");
  if (last.state.state != State::kIdle || last.state.fault != 0)
    return Status::error(fmt::format("the device stays in {} after a re-arm", describe(last.state)));
  return Status::good();
}

Result<ServiceMessage> Bench::call(firmware::Operation operation, std::uint16_t number, std::uint32_t value) {
  ServiceMessage request;
  request.operation = operation;
  request.address = number;
  request.value = value;
  request.tag = ++tag_;
  auto reply = link_.call(request, kAnswer);
  if (!reply.ok()) return reply;
  if (reply.value().address != number || reply.value().tag != request.tag)
    return Status::error(fmt::format("register {:#06x}: the answer is to another question", number));
  return reply;
}

Result<std::uint32_t> Bench::read(std::uint16_t number) {
  const auto reply = call(firmware::Operation::kRead, number);
  if (!reply.ok()) return reply.status();
  if (reply.value().status == ServiceStatus::kGood) return reply.value().value;
  return Status::error(fmt::format("register {:#06x} cannot be read: {}", number, refusal_words(reply.value().status)));
}

Status Bench::write(std::uint16_t number, std::uint32_t value) {
  const auto reply = call(firmware::Operation::kWrite, number, value);
  if (!reply.ok()) return reply.status();
  if (reply.value().status == ServiceStatus::kGood) return Status::good();
  return Status::error(
      fmt::format("register {:#06x} cannot be written: {}", number, refusal_words(reply.value().status)));
}

}  // namespace tactus::hil
