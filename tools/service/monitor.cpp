#include "tools/service/monitor.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "hal/device_words.h"
#include "hal/host_faults.h"
#include "rt/base/status.h"
#include "tools/json_report.h"

namespace tactus::service {
namespace {

std::string number(std::uint64_t value) { return fmt::format("{}", value); }

}  // namespace

std::string state_json(const session::LiveStatus& live, double elapsed_s, double rate_Hz, const RunName& run) {
  constexpr auto relaxed = std::memory_order_relaxed;
  nlohmann::ordered_json conditions = nlohmann::ordered_json::array();
  const std::uint32_t status = live.status.load(relaxed);
  for (std::uint32_t bit = 0; bit < 32; ++bit)
    if (const auto name = name_of(static_cast<StatusBit>(1u << bit)); ((status >> bit) & 1u) != 0 && !name.empty())
      conditions.push_back(std::string(name));
  const auto fault = static_cast<Fault>(live.fault.load(relaxed));
  const auto device_state = static_cast<haptics::DeviceState>(live.device_state.load(relaxed));
  return report_text(nlohmann::ordered_json{{"ok", true},
                                            {"scene_file", run.scene.string()},
                                            {"scene_hash", run.scene_hash},
                                            {"elapsed_s", elapsed_s},
                                            {"ticks", live.ticks.load(relaxed)},
                                            {"rate_Hz", rate_Hz},
                                            {"armed", (status & kNotArmed) == 0},
                                            {"force_N", live.force_N.load(relaxed)},
                                            {"members", live.members.load(relaxed)},
                                            {"contacts", live.contacts.load(relaxed)},
                                            {"border_contacts", live.border.load(relaxed)},
                                            {"overruns", live.overruns.load(relaxed)},
                                            {"late_cycles", live.late_cycles.load(relaxed)},
                                            {"resets", live.resets.load(relaxed)},
                                            {"conditions", conditions},
                                            {"fault", static_cast<std::uint32_t>(fault)},
                                            {"fault_text", fault_line(live)},
                                            {"device_state", hal::name_of(device_state)},
                                            {"device_fault", hal::shown_fault(live.device_fault.load(relaxed))},
                                            {"device_limits", live.device_limits.load(relaxed)}});
}

void Monitor::look(const session::LiveStatus& live, double elapsed_s) {
  constexpr auto relaxed = std::memory_order_relaxed;
  const std::uint64_t ticks = live.ticks.load(relaxed), overruns = live.overruns.load(relaxed),
                      late = live.late_cycles.load(relaxed);
  const std::uint32_t fault = live.fault.load(relaxed);
  alive_ = ticks > ticks_;
  if (elapsed_s > last_s_) rate_Hz_ = static_cast<double>(ticks - ticks_) / (elapsed_s - last_s_);
  if (!started_ && ticks > 0)
    log_.event(LogLevel::kInfo, "running",
               {{"rate_Hz", fmt::format("{:.0f}", rate_Hz_)},
                {"version", version()},
                {"scene", name_.scene.string()},
                {"scene_hash", name_.scene_hash}},
               elapsed_s);
  started_ = started_ || ticks > 0;
  if (overruns > overruns_)
    log_.event(LogLevel::kWarning, "overruns", {{"count", number(overruns - overruns_)}, {"total", number(overruns)}},
               elapsed_s);
  if (late > late_cycles_)
    log_.event(LogLevel::kWarning, "late-world", {{"cycles", number(late - late_cycles_)}, {"total", number(late)}},
               elapsed_s);
  if (fault != fault_ && fault != 0)
    log_.event(LogLevel::kError, "fault",
               {{"code", number(fault)},
                {"device_code", number(hal::shown_fault(live.device_fault.load(relaxed)))},
                {"text", fault_line(live)}},
               elapsed_s);
  if (fault != fault_ && fault == 0) log_.event(LogLevel::kNotice, "re-armed", {{"code", number(fault_)}}, elapsed_s);
  if (const std::uint32_t resets = live.resets.load(relaxed); resets != resets_) {
    log_.event(LogLevel::kNotice, "reset", {{"total", number(resets)}}, elapsed_s);
    resets_ = resets;
  }
  // Logs the state of the loop, not the request; a fault that removes the force has its own line.
  const bool armed = started_ && (live.status.load(relaxed) & kNotArmed) == 0;
  if (armed != armed_ && fault == 0) log_.event(LogLevel::kNotice, armed ? "armed" : "disarmed", {}, elapsed_s);
  armed_ = armed;
  if (started_ && !alive_) log_.event(LogLevel::kError, "standstill", {{"ticks", number(ticks)}}, elapsed_s);
  ticks_ = ticks;
  overruns_ = overruns;
  late_cycles_ = late;
  fault_ = fault;
  last_s_ = elapsed_s;
}

}  // namespace tactus::service
