// tactus scene check FILE: checks a scene and lists the effects that it uses and their cost.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "hal/profiles.h"
#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"
#include "tools/experiment/effects.h"
#include "tools/json_report.h"
#include "tools/session/scheme_gains.h"
#include "tools/session/session.h"
#include "tools/session/shared_limit.h"
#include "tools/session/verdict.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

using nlohmann::ordered_json;

struct CheckOptions {
  std::string file;
  double rate_Hz{1000};
  bool json{false};
};

ordered_json to_json(const std::vector<text::Mistake>& mistakes) {
  ordered_json list = ordered_json::array();
  for (const auto& m : mistakes)
    list.push_back(
        {{"line", m.line}, {"column", m.column}, {"where", m.where}, {"what", m.what}, {"accepted", m.accepted}});
  return list;
}

ordered_json to_json(const haptics::AxisVerdict& axis, const char* stiffness_unit, const char* damping_unit) {
  return {{std::string("stiffness_") + stiffness_unit, axis.stiffness},
          {std::string("stiffness_limit_") + stiffness_unit, axis.stiffness_limit},
          {std::string("stiffness_allowed_") + stiffness_unit, axis.stiffness_allowed},
          {std::string("damping_") + damping_unit, axis.damping},
          {std::string("damping_limit_") + damping_unit, axis.damping_limit},
          {"margin", axis.margin},
          {"passive", axis.passive},
          {"accepted", axis.accepted}};
}

ordered_json to_json(const sim::SceneReport& r) {
  ordered_json effects = ordered_json::array(), parts = ordered_json::array(), meshes = ordered_json::array();
  for (const auto& e : r.effects)
    effects.push_back({{"name", e.name},
                       {"declared", e.declared},
                       {"used", e.used},
                       {"cost", e.cost},
                       {"measured_us_per_tick", e.is_measured() ? ordered_json(e.added_us) : ordered_json(nullptr)},
                       {"measured_spread_us", e.tick_us > 0 ? ordered_json(e.spread_us) : ordered_json(nullptr)}});
  for (const auto& p : r.generated)
    parts.push_back({{"kind", p.kind},
                     {"first_id", p.first},
                     {"bodies", p.count},
                     {"friction", p.friction},
                     {"needed_foot_friction", p.foot_friction},
                     {"needed_top_friction", p.top_friction}});
  for (const auto& m : r.meshes)
    meshes.push_back({{"file", m.file},
                      {"body", m.body},
                      {"triangles", m.triangles},
                      {"corners", m.corners},
                      {"patches", m.patches},
                      {"open_edges", m.boundary_edges},
                      {"disagreeing_edges", m.disagreeing_edges},
                      {"merged_corners", m.welded},
                      {"left_out_without_area", m.without_area},
                      {"left_out_doubled", m.doubled}});
  return {{"bodies",
           {{"total", r.bodies.total},
            {"dynamic", r.bodies.dynamic},
            {"fixed", r.bodies.fixed},
            {"boxes", r.bodies.boxes},
            {"spheres", r.bodies.spheres},
            {"capsules", r.bodies.capsules},
            {"planes", r.bodies.planes},
            {"hulls", r.bodies.hulls},
            {"meshes", r.bodies.meshes},
            {"cylinders", r.bodies.cylinders},
            {"cones", r.bodies.cones},
            {"compounds", r.bodies.compounds},
            {"parts", r.bodies.parts}}},
          {"meshes", meshes},
          {"effects", effects},
          {"generated", parts},
          {"lightest_kg", r.lightest_kg},
          {"heaviest_kg", r.heaviest_kg},
          {"mass_ratio", r.mass_ratio},
          {"contact_hertz_Hz", r.contact_hertz_Hz},
          {"max_contact_hertz_Hz", r.max_contact_hertz_Hz},
          {"penetration",
           {{"proxy_m_per_N", r.penetration.proxy_m_per_N}, {"lightest_m_per_N", r.penetration.lightest_m_per_N}}},
          {"coupling",
           {{"translation", to_json(r.coupling.translation, "N_per_m", "Ns_per_m")},
            {"rotation", to_json(r.coupling.rotation, "Nm_per_rad", "Nms_per_rad")}}},
          {"start", {{"contacts", r.start.contacts}, {"points", r.start.points}, {"deepest_m", r.start.deepest_m}}},
          {"hand",
           {{"file", r.hand.file},
            {"motion", r.hand.motion},
            {"points", r.hand.points},
            {"duration_s", r.hand.duration_s},
            {"max_speed_m_per_s", r.hand.max_speed_m_per_s},
            {"device_max_speed_m_per_s", r.hand.device_max_speed_m_per_s},
            {"max_angular_speed_rad_per_s", r.hand.max_angular_speed_rad_per_s},
            {"device_max_angular_speed_rad_per_s", r.hand.device_max_angular_speed_rad_per_s},
            {"farthest_m", r.hand.farthest_m},
            {"workspace_radius_m", r.hand.workspace_radius_m}}},
          {"capacity",
           {{"member_cap", r.capacity.member_cap},
            {"members_possible", r.capacity.members_possible},
            {"contacts_per_body", r.capacity.contacts_per_body},
            {"sub_world_contacts", r.capacity.sub_world_contacts},
            {"global_contacts", r.capacity.global_contacts},
            {"global_sub_steps", r.capacity.global_sub_steps}}},
          {"problems", r.problems}};
}

// The device that the scene names; the loader accepts only known ones.
haptics::DeviceProperties device_of(const sim::Scene& scene, double tick_s) {
  const hal::DeviceProfile* profile = hal::find_profile(scene.device.profile);
  TACTUS_CHECK(profile != nullptr, 0, 0);
  haptics::DeviceProperties properties = profile->properties;
  properties.delay_s = profile->transport_delay_ticks * tick_s;
  return properties;
}

// Adds the problems of the second and further hands that `report` does not list yet.
void add_further_hands(const sim::Scene& scene, double tick_s, sim::SceneReport& report) {
  const std::vector<std::string> first = report.problems;
  for (unsigned hand = 1; hand < scene.hands(); ++hand) {
    const sim::Scene own = sim::scene_of_hand(scene, hand);
    for (const std::string& problem : sim::report_on(own, device_of(own, tick_s), tick_s).problems)
      if (std::find(first.begin(), first.end(), problem) == first.end())
        report.problems.push_back(fmt::format("hand {}: {}", hand + 1, problem));
  }
}

// The gains that tactus run uses for each of several hands, with the scene's ratio: see shared_limit.h.
struct HandGains {
  session::RunOptions options;
  session::SchemeGains gains;
  unsigned ratio{0};
};

std::vector<HandGains> gains_of_hands(const sim::Scene& scene, double rate_Hz) {
  std::vector<HandGains> hands;
  for (unsigned hand = 0; hand < scene.hands() && scene.hands() > 1; ++hand) {
    const sim::Scene own = sim::scene_of_hand(scene, hand);
    session::RunOptions options;
    options.hand = hand;
    options.hands = scene.hands();
    options.rate_Hz = rate_Hz;
    const haptics::DeviceProperties device = device_of(own, options.period_s());
    options.shared_limits = session::shared_limits(own, options, device);
    const session::SchemeGains gains = session::gains_of(own, options, device);
    hands.push_back({std::move(options), gains, session::ratio_of(own, options)});
  }
  return hands;
}

std::string to_text(const std::vector<HandGains>& hands) {
  std::string text = hands.empty() ? "" : "hands, as tactus run has them\n";
  for (const HandGains& hand : hands) {
    const std::string lowered = session::lowered_text(hand.gains);
    text +=
        fmt::format("  {:<12}{}\n", hand.options.hand + 1,
                    lowered.empty() ? fmt::format("{:g} N/m and {:g} N m/rad at ratio {}, as in the scene",
                                                  hand.gains.gains.stiffness_N_per_m,
                                                  hand.gains.gains.stiffness_Nm_per_rad, hand.ratio)
                                    : fmt::format("{}: {}", lowered, session::lowered_why(hand.options, hand.ratio)));
  }
  return text;
}

ordered_json to_json(const std::vector<HandGains>& hands) {
  ordered_json list = ordered_json::array();
  for (const HandGains& hand : hands)
    list.push_back({{"number", hand.options.hand + 1},
                    {"ratio", hand.ratio},
                    {"stiffness_N_per_m", hand.gains.gains.stiffness_N_per_m},
                    {"asked_stiffness_N_per_m", hand.gains.asked.stiffness_N_per_m},
                    {"stiffness_Nm_per_rad", hand.gains.gains.stiffness_Nm_per_rad},
                    {"asked_stiffness_Nm_per_rad", hand.gains.asked.stiffness_Nm_per_rad},
                    {"lowered", hand.gains.lowered()}});
  return list;
}

int check_scene(const CheckOptions& options) {
  text::Diagnostics diagnostics;
  const auto scene = sim::load_scene(options.file, &diagnostics);
  ordered_json object{{"file", options.file},
                      {"accepted", scene.ok()},
                      {"mistakes", to_json(diagnostics.mistakes)},
                      {"warnings", to_json(diagnostics.warnings)}};
  if (!scene.ok()) {
    object["error"] = scene.message();
    if (options.json) fmt::print("{}\n", report_text(object, 2));
    fmt::print(stderr, "tactus: {}\n", scene.message());
    return kExitBadInput;
  }
  const double tick_s = 1 / options.rate_Hz;
  auto report = sim::report_on(scene.value(), device_of(scene.value(), tick_s), tick_s);
  add_further_hands(scene.value(), tick_s, report);
  for (const auto& time : experiment::time_effects(scene.value()))
    for (auto& effect : report.effects)
      if (effect.name == time.effect) {
        effect.added_us = time.added_us;
        effect.spread_us = time.spread_us;
        effect.tick_us = time.tick_us;
      }
  if (!diagnostics.warnings.empty()) fmt::print(stderr, "{}\n", diagnostics.warning_message());
  const std::vector<HandGains> hands =
      report.coupling.accepted ? gains_of_hands(scene.value(), options.rate_Hz) : std::vector<HandGains>();
  const session::RunVerdict verdict = session::judge(report);
  if (options.json) {
    object["name"] = report.name;
    object["title"] = report.title;
    object["scene_hash"] = sim::source_hash(scene.value().source);
    object["good"] = verdict.level() == session::Level::kGood;
    object["verdict"] = name_of(verdict.level());
    object["rules"] = session::to_json(verdict);
    object["report"] = to_json(report);
    if (!hands.empty()) object["report"]["hands"] = to_json(hands);
    fmt::print("{}\n", report_text(object, 2));
  } else {
    fmt::print("{}{}text {}, checked by tactus {}\nverdict: {}\n", sim::to_text(report), to_text(hands),
               sim::source_hash(scene.value().source), version(), name_of(verdict.level()));
  }
  return verdict.exit_code();
}

}  // namespace

CLI::App* add_scene_command(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* scene = program.add_subcommand("scene", "Check a scene file (TOML), or list the keys of scene files.");
  scene->footer("Examples:\n  tactus scene check sim/scenes/card_house.toml\n  tactus scene keys simulation");
  CLI::App* check =
      scene->add_subcommand("check", "Validate a scene; list the effects that it uses and what they cost.");
  check->footer(
      "Every mistake gets a line: file, line, column, key, what is wrong, what is accepted. A scene with warnings\n"
      "is accepted: an effect that nothing uses, a hull that fills a cavity of its file's shape.\n"
      "sim/scenes/README.md explains the keys.\n"
      "Exit status: 0 the scene is good; 1 it will not run well, by the problems listed; 2 the file is not a valid\n"
      "scene.\n\n"
      "Examples:\n"
      "  tactus scene check sim/scenes/card_house.toml\n"
      "  tactus scene check --json sim/scenes/pile700.toml");
  check->add_option("FILE", options->file, "scene file, such as sim/scenes/card_house.toml")->required();
  check->add_option("--rate", options->rate_Hz, std::string(help::kRate) + ", for the check of stiffnesses")
      ->check(in_range(session::kRates_Hz, "Hz"))
      ->capture_default_str();
  check->add_flag("--json", options->json, help::kJson);
  check->callback([options, &exit_code] { exit_code = check_scene(*options); });
  add_scene_keys_command(*scene, exit_code);
  return scene;
}

}  // namespace tactus::tools
