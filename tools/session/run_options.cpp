#include "tools/session/run_options.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "rt/haptics/snapshot.h"
#include "sim/choice_names.h"

namespace tactus::session {
namespace {

using nlohmann::json;

template <class T>
Status check_range(const char* option, T value, T low, T high, const char* unit) {
  if (value >= low && value <= high) return Status::good();
  return Status::error(fmt::format("{}: {} is out of range; accepted: {} to {}{}", option, value, low, high, unit));
}

}  // namespace

Status check_options(const RunOptions& o) {
  for (const Status& status : {
           check_range("--rate", o.rate_Hz, 100.0, 10000.0, " Hz"),
           check_range("--ratio", o.ratio, o.ratio == 0 ? 0u : 1u, 100u, ""),
           check_range("--members", o.members, o.members == 0 ? 0u : 1u, haptics::kMaxMembers, ""),
           check_range("--duration", o.duration_s, o.duration_s == 0 ? 0.0 : 0.01, 1e6, " s"),
           check_range("--priority", o.priority, 0, 98, ""),
       }) {
    if (!status.ok()) return status;
  }
  if (o.device != "sim") {
    return Status::error(fmt::format("--device: '{}' is no device of this build; accepted: sim", o.device));
  }
  return Status::good();
}

std::string to_tape_text(const RunOptions& o, const std::string& scene_name, const std::string& scene_source) {
  json text;
  text["tactus"] = "tape of a haptic thread";
  text["coupling"] = sim::name_of(o.coupling);
  text["border"] = sim::name_of(o.border);
  text["order"] = sim::name_of(o.order);
  text["reach"] = sim::name_of(o.reach);
  text["all_members"] = o.all_members;
  text["rate_Hz"] = o.rate_Hz;
  text["ratio"] = o.ratio;
  text["members"] = o.members;
  text["inject"] = o.inject;
  text["seed"] = o.seed;
  text["virtual_time"] = o.virtual_time;
  text["scene_name"] = scene_name;
  text["scene"] = scene_source;
  return text.dump();
}

Result<TapeSettings> from_tape_text(const std::string& text) {
  const json parsed = json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto bad = [](const std::string& what) {
    return Status::error("the tape's header " + what + "; accepted: a tape that `tactus run --record` wrote");
  };
  if (parsed.is_discarded() || !parsed.is_object()) return bad("is not JSON");
  const auto word = [&](const char* key) {
    const auto at = parsed.find(key);
    return at != parsed.end() && at->is_string() ? at->get<std::string>() : std::string();
  };
  TapeSettings tape;
  const auto coupling = sim::parse_coupling_scheme(word("coupling"));
  const auto border = sim::parse_border_mode(word("border"));
  const auto order = sim::parse_cut_order(word("order"));
  const auto reach = sim::parse_reach(word("reach"));
  if (!coupling || !border || !order || !reach) return bad("names no coupling, border, order or reach of this program");
  if (!parsed.contains("rate_Hz") || !parsed["rate_Hz"].is_number()) return bad("has no number 'rate_Hz'");
  for (const char* key : {"ratio", "members", "seed"}) {
    if (!parsed.contains(key) || !parsed[key].is_number_unsigned()) return bad(fmt::format("has no number '{}'", key));
  }
  for (const char* key : {"all_members", "virtual_time"}) {
    if (!parsed.contains(key) || !parsed[key].is_boolean()) return bad(fmt::format("has no '{}'", key));
  }
  RunOptions& o = tape.options;
  o.coupling = *coupling, o.border = *border, o.order = *order, o.reach = *reach;
  o.all_members = parsed["all_members"].get<bool>();
  o.virtual_time = parsed["virtual_time"].get<bool>();
  o.rate_Hz = parsed["rate_Hz"].get<double>();
  // Narrowed only where it fits; what does not is out of range below.
  const auto small = [&](const char* key) {
    return static_cast<unsigned>(std::min<std::uint64_t>(parsed[key].get<std::uint64_t>(), 0xffffffffu));
  };
  o.ratio = small("ratio");
  o.members = small("members");
  o.seed = parsed["seed"].get<std::uint64_t>();
  o.inject = word("inject");
  tape.scene_name = word("scene_name");
  tape.scene_source = word("scene");
  if (const Status status = check_options(o); !status.ok()) return bad("has " + status.message());
  return tape;
}

}  // namespace tactus::session
