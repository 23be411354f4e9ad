#include "tools/session/run_options.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/device_class.h"
#include "hal/gpio/gpio_options.h"
#include "rt/haptics/coupling/snapshot.h"
#include "sim/loader/scene_load.h"
#include "sim/model/choice_names.h"
#include "sim/model/scene.h"
#include "sim/worker_pool.h"
#include "tools/json_text.h"
#include "tools/session/inject_script.h"
#include "tools/version/version.h"

namespace tactus::session {
namespace {

using nlohmann::json;

template <class T>
Status check_range(const char* option, T value, const Range<T>& range, const char* unit) {
  const auto [least, most] = range;
  if (value >= least && value <= most) return Status::good();
  return Status::error(fmt::format("{}: {} is out of range; accepted: {} to {}{}", option, value, least, most, unit));
}

// The numeric properties by name. JSON keeps their bits: it writes the shortest text that reads back the same.
using Properties = haptics::DeviceProperties;
constexpr std::pair<const char*, double Properties::*> kProperties[] = {
    {"workspace_radius_m", &Properties::workspace_radius_m},
    {"max_speed_m_per_s", &Properties::max_speed_m_per_s},
    {"max_angular_speed_rad_per_s", &Properties::max_angular_speed_rad_per_s},
    {"max_force_N", &Properties::max_force_N},
    {"max_torque_Nm", &Properties::max_torque_Nm},
    {"continuous_force_N", &Properties::continuous_force_N},
    {"continuous_torque_Nm", &Properties::continuous_torque_Nm},
    {"position_quantum_m", &Properties::position_quantum_m},
    {"rotation_quantum_rad", &Properties::rotation_quantum_rad},
    {"mass_kg", &Properties::mass_kg},
    {"damping_Ns_per_m", &Properties::damping_Ns_per_m},
    {"inertia_kg_m2", &Properties::inertia_kg_m2},
    {"damping_Nms_per_rad", &Properties::damping_Nms_per_rad},
    {"delay_s", &Properties::delay_s},
    {"coulomb_friction_N", &Properties::coulomb_friction_N},
    {"coulomb_friction_Nm", &Properties::coulomb_friction_Nm},
};
static_assert(sizeof(haptics::DeviceProperties) == 8 + sizeof(double) * std::size(kProperties), "one is not listed");

json properties_to_json(const haptics::DeviceProperties& device) {
  json object{{"has_rotation", device.has_rotation}};
  for (const auto& [name, member] : kProperties) object[name] = device.*member;
  return object;
}

// Returns the name of the first property that is missing or not a number; empty if all are present.
std::string properties_from_json(const json& object, haptics::DeviceProperties& device) {
  const auto rotation = object.find("has_rotation");
  if (rotation == object.end() || !rotation->is_boolean()) return "has_rotation";
  device.has_rotation = rotation->get<bool>();
  for (const auto& [name, member] : kProperties) {
    const auto at = object.find(name);
    if (at == object.end() || !at->is_number()) return name;
    device.*member = at->get<double>();
  }
  return {};
}

// JSON has no infinity: a limit that is none is left out.
json hand_to_json(const RunOptions& o) {
  json object{{"number", o.hand}, {"of", o.hands}};
  const SharedLimits limits = o.shared_limits.value_or(SharedLimits{});
  if (std::isfinite(limits.stiffness_N_per_m)) object["limit_N_per_m"] = limits.stiffness_N_per_m;
  if (std::isfinite(limits.stiffness_Nm_per_rad)) object["limit_Nm_per_rad"] = limits.stiffness_Nm_per_rad;
  return object;
}

bool hand_from_json(const json& object, RunOptions& o) {
  if (!object.is_object()) return false;
  const auto count = [&](const char* key) -> std::uint64_t {
    const auto at = object.find(key);
    return at != object.end() && at->is_number_unsigned() ? at->get<std::uint64_t>() : sim::kMaxHands + 1;
  };
  if (count("of") > sim::kMaxHands || count("number") >= count("of")) return false;
  o.hand = static_cast<unsigned>(count("number"));
  o.hands = static_cast<unsigned>(count("of"));
  SharedLimits& limits = o.shared_limits.emplace();
  for (const auto& [key, limit] : {std::pair{"limit_N_per_m", &limits.stiffness_N_per_m},
                                   std::pair{"limit_Nm_per_rad", &limits.stiffness_Nm_per_rad}}) {
    const auto at = object.find(key);
    if (at == object.end()) continue;
    if (!at->is_number()) return false;
    *limit = at->get<double>();
  }
  return true;
}

constexpr std::pair<Accuracy, std::string_view> kAccuracies[] = {
    {Accuracy::kFast, "fast"}, {Accuracy::kBalanced, "balanced"}, {Accuracy::kAccurate, "accurate"}};

}  // namespace

std::string_view name_of(Accuracy accuracy) noexcept {
  for (const auto& [value, word] : kAccuracies)
    if (value == accuracy) return word;
  return "unknown";
}

std::optional<Accuracy> parse_accuracy(std::string_view word) noexcept {
  for (const auto& [value, name] : kAccuracies)
    if (name == word) return value;
  return std::nullopt;
}

std::vector<std::string> option_mistakes(const RunOptions& o) {
  std::vector<std::string> mistakes;
  const auto look_at = [&](const Status& status) {
    if (!status.ok()) mistakes.push_back(status.message());
  };
  look_at(check_range("--rate", o.rate_Hz, kRates_Hz, " Hz"));
  if (o.ratio != 0) look_at(check_range("--ratio", o.ratio, kRatios, ""));
  if (o.members != 0) look_at(check_range("--members", o.members, kMemberCaps, ""));
  if (o.duration_s != 0) look_at(check_range("--duration", o.duration_s, {0.01, 1e6}, " s"));
  if (o.cpu != -1) look_at(check_range("--cpu", o.cpu, kCores, ""));
  look_at(check_range("--priority", o.priority, kPriorities, ""));
  look_at(check_range("--world-threads", o.world_threads, {1u, sim::kMaxWorldThreads}, ""));
  if (!o.world_cpus.empty() && o.world_cpus.size() != o.world_threads)
    mistakes.push_back(fmt::format("--world-cpu: {} cores for {} of --world-threads; accepted: as many, or none",
                                   o.world_cpus.size(), o.world_threads));
  const auto choice = hal::choose_device(o.device);
  const bool taped = o.taped_device.has_value(), given = o.given_device || o.device == kGivenDevice;
  if (!o.given_device && !(taped && given)) look_at(choice.status());
  const bool real = choice.ok() && choice.value().device_class->real;
  if (choice.ok() && !taped) {
    const hal::DeviceClass& device_class = *choice.value().device_class;
    if (o.virtual_time) look_at(hal::check_virtual_time(device_class, o.device));
    if (!o.device_file.empty()) look_at(hal::check_described(device_class, o.device));
  }
  if (!o.gpio.empty()) look_at(hal::parse_gpio_options(o.gpio).status());
  if (o.virtual_time && !o.gpio.empty())
    mistakes.push_back("--gpio: lines are of real time; accepted: without --virtual-time");
  const auto script = split_inject_script(o.inject);
  look_at(script.status());
  if (script.ok() && !script.value().device.empty() && (real || given))
    mistakes.push_back(fmt::format(
        "--inject: faults of the device are for the simulated one, not for {}; accepted: stall, reset, or --device sim",
        o.device));
  return mistakes;
}

Status check_options(const RunOptions& o) {
  const std::vector<std::string> mistakes = option_mistakes(o);
  return mistakes.empty() ? Status::good() : Status::error(mistakes.front());
}

std::string to_tape_text(const RunOptions& o, const haptics::DeviceProperties& device, const std::string& scene_name,
                         const std::string& scene_source) {
  json text;
  text["tactus"] = "tape of a haptic thread";
  text["made_by"] = "tactus " + version();
  text["scene_file"] = o.scene.string();
  text["scene_hash"] = sim::source_hash(scene_source);
  text["coupling"] = sim::name_of(o.coupling);
  text["border"] = sim::name_of(o.border);
  text["order"] = sim::name_of(o.order);
  text["reach"] = sim::name_of(o.reach);
  text["accuracy"] = name_of(o.accuracy);
  text["all_members"] = o.all_members;
  text["rate_Hz"] = o.rate_Hz;
  text["late_s"] = o.late_s;
  text["ratio"] = o.ratio;
  text["members"] = o.members;
  text["inject"] = o.inject;
  text["seed"] = o.seed;
  text["world_precision"] = sim::name_of(o.world_precision);
  text["virtual_time"] = o.virtual_time;
  text["device"] = o.device;
  text["device_properties"] = properties_to_json(device);
  if (o.hands > 1) text["hand"] = hand_to_json(o);
  text["scene_name"] = scene_name;
  text["scene"] = scene_source;
  return json_text(text);
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
  const auto accuracy = parse_accuracy(word("accuracy"));
  if (!coupling || !border || !order || !reach || !accuracy)
    return bad("names no coupling, border, order, reach or accuracy of this program");
  for (const char* key : {"rate_Hz", "late_s"})
    if (!parsed.contains(key) || !parsed[key].is_number()) return bad(fmt::format("has no number '{}'", key));
  for (const char* key : {"ratio", "members", "seed"}) {
    if (!parsed.contains(key) || !parsed[key].is_number_unsigned()) return bad(fmt::format("has no number '{}'", key));
  }
  for (const char* key : {"all_members", "virtual_time"}) {
    if (!parsed.contains(key) || !parsed[key].is_boolean()) return bad(fmt::format("has no '{}'", key));
  }
  RunOptions& o = tape.options;
  o.coupling = *coupling;
  o.border = *border;
  o.order = *order;
  o.reach = *reach;
  o.accuracy = *accuracy;
  o.all_members = parsed["all_members"].get<bool>();
  o.virtual_time = parsed["virtual_time"].get<bool>();
  o.rate_Hz = parsed["rate_Hz"].get<double>();
  o.late_s = parsed["late_s"].get<double>();
  // Saturates instead of truncating; the range check below then rejects the value.
  const auto small = [&](const char* key) {
    return static_cast<unsigned>(std::min<std::uint64_t>(parsed[key].get<std::uint64_t>(), 0xffffffffu));
  };
  o.ratio = small("ratio");
  o.members = small("members");
  o.seed = parsed["seed"].get<std::uint64_t>();
  if (const auto hand = parsed.find("hand"); hand != parsed.end()) {
    if (!hand_from_json(*hand, o)) return bad("has a 'hand' that is none");
  }
  o.inject = word("inject");
  if (const auto precision = sim::parse_precision(word("world_precision"))) {
    o.world_precision = *precision;
    tape.knows_world = true;
  }
  o.device = word("device");
  const auto properties = parsed.find("device_properties");
  if (properties == parsed.end() || !properties->is_object()) return bad("has no 'device_properties'");
  const std::string missing = properties_from_json(*properties, o.taped_device.emplace());
  if (!missing.empty()) return bad(fmt::format("has no '{}' among its 'device_properties'", missing));
  tape.scene_name = word("scene_name");
  tape.scene_source = word("scene");
  tape.made_by = word("made_by");
  tape.scene_file = word("scene_file");
  tape.scene_hash = sim::source_hash(tape.scene_source);
  if (const Status status = check_options(o); !status.ok()) return bad("has " + status.message());
  return tape;
}

}  // namespace tactus::session
