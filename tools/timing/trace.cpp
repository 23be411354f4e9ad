#include "tools/timing/trace.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "tools/json_text.h"
#include "tools/version/version.h"

namespace tactus::timing {
namespace {

using nlohmann::ordered_json;

constexpr int kProcess = 1, kHapticThread = 1, kDeadlines = 2;

ordered_json slice(const char* name, std::int64_t from_ns, std::int64_t to_ns, std::int64_t origin_ns) {
  return {{"name", name},
          {"ph", "X"},
          {"ts", static_cast<double>(from_ns - origin_ns) * 1e-3},
          {"dur", static_cast<double>(to_ns - from_ns) * 1e-3},
          {"pid", kProcess},
          {"tid", kHapticThread}};
}

ordered_json name_event(const char* kind, int thread, const char* name) {
  return {{"name", kind}, {"ph", "M"}, {"pid", kProcess}, {"tid", thread}, {"args", {{"name", name}}}};
}

void add_tick(ordered_json& events, const loop::TickTimes& t, std::int64_t origin_ns) {
  ordered_json tick = slice("tick", t.woke_ns, t.wrote_ns, origin_ns);
  tick["args"] = {{"tick", t.tick},
                  {"woke_late_us", static_cast<double>(t.woke_ns - t.scheduled_ns) * 1e-3},
                  {"on_core_us", static_cast<double>(t.cpu_ns) * 1e-3},
                  {"foreseen_us", static_cast<double>(t.predicted_ns) * 1e-3},
                  {"minor_faults", t.minor_faults},
                  {"involuntary_switches", t.involuntary_switches},
                  {"members", t.members},
                  {"contacts", t.contacts},
                  {"sub_steps", t.sub_steps}};
  events.push_back(std::move(tick));
  const std::int64_t ends[kStages]{t.woke_ns,     t.read_ns,    t.adopted_ns, t.coupled_ns,
                                   t.collided_ns, t.stepped_ns, t.wrote_ns};
  for (std::uint32_t i = 1; i < kStages; ++i)
    events.push_back(slice(name_of(static_cast<TimedStage>(i)), ends[i - 1], ends[i], origin_ns));
  events.push_back({{"name", "deadline"},
                    {"ph", "i"},
                    {"s", "t"},
                    {"ts", static_cast<double>(t.scheduled_ns - origin_ns) * 1e-3},
                    {"pid", kProcess},
                    {"tid", kDeadlines}});
}

}  // namespace

std::string trace_json(const TickStatistics& statistics) {
  std::map<std::uint64_t, loop::TickTimes> shown;
  for (const loop::TickTimes& t : statistics.recent) shown[t.tick] = t;
  for (const Spike& spike : statistics.spikes)
    for (const loop::TickTimes& t : spike.around) shown[t.tick] = t;
  ordered_json events = ordered_json::array();
  events.push_back(name_event("process_name", kHapticThread, "tactus"));
  events.push_back(name_event("thread_name", kHapticThread, "haptic thread"));
  events.push_back(name_event("thread_name", kDeadlines, "deadlines"));
  const std::int64_t origin_ns = shown.empty() ? 0 : shown.begin()->second.scheduled_ns;
  for (const auto& [tick, times] : shown) add_tick(events, times, origin_ns);
  for (const Spike& spike : statistics.spikes)
    events.push_back({{"name", fmt::format("SPIKE: {}", name_of(spike.attribution.cause))},
                      {"ph", "i"},
                      {"s", "g"},
                      {"ts", static_cast<double>(spike.times.wrote_ns - origin_ns) * 1e-3},
                      {"pid", kProcess},
                      {"tid", kHapticThread},
                      {"args", {{"tick", spike.times.tick}, {"evidence", spike.attribution.evidence}}}});
  return json_text(ordered_json{
      {"displayTimeUnit", "ns"}, {"traceEvents", events}, {"otherData", {{"written_by", "tactus " + version()}}}});
}

}  // namespace tactus::timing
