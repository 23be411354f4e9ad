#include "tools/timing/cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "rt/loop/run_stats.h"

namespace tactus::timing {
namespace {

using loop::OverrunCause;
using loop::TickTimes;

// A shorter time off the core is the error of two clocks read one after the other.
constexpr std::int64_t kNoise_ns = 5'000;

// For a tick that met its deadline: the part that exceeds its typical value most.
OverrunCause largest_part(const TickTimes& t, const Typical& typical) {
  const std::int64_t execution = t.wrote_ns - t.woke_ns, rest = execution - (t.computed_ns - t.read_ns);
  const std::int64_t explained = std::min(t.cpu_ns, 2 * t.predicted_ns + rest);
  const std::int64_t late = t.woke_ns - t.scheduled_ns - typical.wake_ns;
  const std::int64_t work = explained - typical.execution_ns;
  const std::int64_t unexplained = execution - std::max(explained, typical.execution_ns);
  if (late >= work && late >= unexplained) return OverrunCause::kLateWake;
  return work >= unexplained ? OverrunCause::kOwnWork : OverrunCause::kInterrupted;
}

bool is_overrun(const TickTimes& t, std::int64_t period_ns) { return t.wrote_ns > t.scheduled_ns + period_ns; }

OverrunCause first_answer(const TickTimes& t, std::int64_t period_ns, const Typical& typical) {
  if (!is_overrun(t, period_ns)) return largest_part(t, typical);
  return loop::classify_overrun(static_cast<double>(t.woke_ns - t.scheduled_ns), static_cast<double>(t.cpu_ns),
                                static_cast<double>(t.predicted_ns), static_cast<double>(period_ns));
}

std::string machine_evidence(const std::optional<MachineChange>& change) {
  if (!change) return "";
  std::string text;
  const double span_ms = us(change->span_ns) * 1e-3;
  if (change->stolen_ms.value_or(0) > 0) text += fmt::format("; its host took {} ms", *change->stolen_ms);
  if (change->interrupts)
    text +=
        fmt::format("; {} device and {} kernel interrupts", change->interrupts->devices, change->interrupts->kernel);
  if (change->waited_ns.value_or(0) > 0)
    text += fmt::format("; ready and not running {:.0f} us", us(*change->waited_ns));
  return text.empty() ? text : text + fmt::format(" in the {:.0f} ms around it", span_ms);
}

// Noise measured by the kernel within the tick: sums by kind, and the name of the longest.
struct Measured {
  std::int64_t interrupts_ns{0}, threads_ns{0};
  std::string text;
};

std::optional<Measured> measured_noise(const std::optional<MachineChange>& change) {
  constexpr std::size_t kNamed = 3;
  if (!change || !change->noise) return std::nullopt;
  Measured sum;
  std::map<std::string, std::int64_t> by_name;
  for (const Noise& noise : *change->noise) {
    (noise.kind == Noise::Kind::kThread ? sum.threads_ns : sum.interrupts_ns) += noise.duration_ns;
    by_name[noise.name] += noise.duration_ns;
  }
  std::vector<std::pair<std::string, std::int64_t>> longest(by_name.begin(), by_name.end());
  std::stable_sort(longest.begin(), longest.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  if (longest.size() > kNamed) longest.resize(kNamed);
  for (const auto& [name, ns] : longest)
    sum.text += fmt::format("{} {} {:.0f} us", sum.text.empty() ? "; the kernel measured" : ",", name, us(ns));
  if (longest.empty()) sum.text = "; the kernel measured nothing on its core";
  return sum;
}

bool stolen(const std::optional<MachineChange>& change) { return change && change->stolen_ms.value_or(0) > 0; }

bool device_interrupted(const std::optional<MachineChange>& change) {
  return change && change->interrupts && change->interrupts->devices > 0;
}

Cause what_interrupted(const TickTimes& t, std::int64_t off_core_ns, std::int64_t to_explain_ns,
                       const std::optional<Measured>& noise, const std::optional<MachineChange>& change) {
  if (t.minor_faults + t.major_faults > 0) return Cause::kPageFault;
  // If the kernel measures the use of the core, the remaining time was used below the kernel.
  if (noise) {
    if (2 * (noise->interrupts_ns + noise->threads_ns) < to_explain_ns) return Cause::kMachine;
    return noise->threads_ns >= noise->interrupts_ns ? Cause::kContextSwitch : Cause::kInterrupt;
  }
  if (off_core_ns > kNoise_ns && t.involuntary_switches > 0) return Cause::kContextSwitch;
  if (device_interrupted(change) && !stolen(change)) return Cause::kInterrupt;
  return Cause::kMachine;
}

}  // namespace

const char* name_of(Cause cause) {
  constexpr std::array<const char*, kCauses + 1> names{
      "late wake-up", "page fault", "context switch", "interrupt", "own work", "the machine, inferred", "computing"};
  return names[static_cast<std::size_t>(cause)];
}

const char* key_of(Cause cause) {
  constexpr std::array<const char*, kCauses + 1> keys{"late_wake_up", "page_fault",       "context_switch", "interrupt",
                                                      "own_work",     "machine_inferred", "computing"};
  return keys[static_cast<std::size_t>(cause)];
}

Attribution attribute(const TickTimes& t, std::int64_t period_ns, const Typical& typical,
                      const std::optional<MachineChange>& change) {
  const std::int64_t execution_ns = t.wrote_ns - t.woke_ns;
  const std::int64_t off_core_ns = std::max<std::int64_t>(0, execution_ns - t.cpu_ns);
  const auto noise = measured_noise(change);
  const std::string measured = noise ? noise->text : "";
  const std::string took = fmt::format("took {:.0f} us, {:.0f} of them on its core, {:.0f} predicted", us(execution_ns),
                                       us(t.cpu_ns), us(t.predicted_ns));
  switch (first_answer(t, period_ns, typical)) {
    case OverrunCause::kOwnWork:
      return {is_overrun(t, period_ns) ? Cause::kOwnWork : Cause::kComputing,
              fmt::format("{}: {} members, {} contacts, {} border contacts, {} sub-steps", took, t.members, t.contacts,
                          t.border, t.sub_steps)};
    case OverrunCause::kLateWake: {
      std::string text =
          fmt::format("woke {:.0f} us late, typically {:.0f}", us(t.woke_ns - t.scheduled_ns), us(typical.wake_ns));
      if (typical.bare_worst_ns > 0) text += fmt::format("; the bare timer up to {:.0f}", us(typical.bare_worst_ns));
      return {Cause::kLateWake, text + measured + machine_evidence(change)};
    }
    case OverrunCause::kInterrupted:
      break;
  }
  const Cause cause = what_interrupted(t, off_core_ns, execution_ns - typical.execution_ns, noise, change);
  std::string text = took;
  if (cause == Cause::kPageFault)
    text += fmt::format("; {} minor, {} major page faults", t.minor_faults, t.major_faults);
  if (cause == Cause::kContextSwitch) text += fmt::format("; {} times pushed aside", t.involuntary_switches);
  if (cause == Cause::kMachine) {
    text += "; no fault, no context switch";
    if (typical.bare_worst_ns > 0)
      text += fmt::format("; the bare timer woke up to {:.0f} us late", us(typical.bare_worst_ns));
  }
  return {cause, text + measured + machine_evidence(change)};
}

}  // namespace tactus::timing
