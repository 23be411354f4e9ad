#include "sim/loader/scene_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "rt/base/hash.h"
#include "rt/haptics/coupling/snapshot.h"
#include "rt/text/read_file.h"
#include "rt/text/table_reader.h"
#include "sim/loader/scene_load_body.h"
#include "sim/loader/scene_load_effects.h"
#include "sim/loader/scene_load_generators.h"
#include "sim/loader/scene_load_hand.h"
#include "sim/loader/scene_load_ranges.h"
#include "sim/model/choice_names.h"

namespace tactus::sim {
namespace {

constexpr double kNominalTick_s = 1e-3;

// Fills a scene from the document, table by table; the order of calls determines the body ids.
class SceneReader {
 public:
  SceneReader(const text::TomlNode& root, Scene& scene, text::Diagnostics& diagnostics,
              const std::optional<std::filesystem::path>& folder)
      : root_(&root, "", diagnostics),
        scene_(scene),
        diagnostics_(diagnostics),
        bodies_(scene, diagnostics, folder),
        hand_(scene, diagnostics, folder),
        effects_(scene, diagnostics) {}

  void read() {
    bodies_.read_kept(root_);
    hand_.read_kept(root_.array("motion_file", kMaxHands));
    scene_.title = root_.text("title", "", 200);
    effects_.read_list(root_);
    read_gravity();
    effects_.read_tables(root_);
    read_simulation();
    read_sleeping();
    read_proxies();
    read_devices();
    read_couplings();
    read_bodies();
    read_generators();
    effects_.read_joints(root_);
    effects_.read_attraction(root_);
    read_hands();
    root_.finish();
    effects_.finish(root_);
    check_card_houses();
  }
  std::string kept_files() const { return bodies_.kept() + hand_.kept(); }

 private:
  text::TableReader table(const char* key) { return {root_.table(key), fmt::format("[{}]", key), diagnostics_}; }

  void read_gravity() {
    const Vec3d g = root_.vector("gravity_m_per_s2", scene_.gravity_m_per_s2, {"an acceleration", -1000, 1000});
    if (root_.has("gravity_m_per_s2") && !scene_.effects.gravity)
      root_.mistake("gravity_m_per_s2", "set, but the effect gravity is not declared",
                    "\"gravity\" among the effects, or no gravity_m_per_s2");
    scene_.gravity_m_per_s2 = scene_.effects.gravity ? g : Vec3d{};
  }

  void read_simulation() {
    text::TableReader t = table("simulation");
    SolverChoice& solver = scene_.solver;
    scene_.ratio = t.count("ratio", scene_.ratio, {"a ratio", 1, 64});
    scene_.members = t.count("members", scene_.members, {"a number of members", 1, haptics::kMaxMembers});
    solver.sub_steps = t.count("sub_steps", solver.sub_steps, {"a number of sub-steps", 1, 64});
    solver.relax_sweeps = t.count("relax_sweeps", solver.relax_sweeps, {"a number of sweeps", 1, 16});
    solver.friction_sweeps = *parse_friction_sweeps(t.word("friction_sweeps", "auto", {"auto", "relax", "every"}));
    solver.global_sub_steps_per_tick =
        t.number("global_sub_steps_per_tick", solver.global_sub_steps_per_tick, {"a number of sub-steps", 0.1, 16});
    solver.far_sub_steps_per_tick = t.number("far_sub_steps_per_tick", solver.global_sub_steps_per_tick,
                                             {"a number of sub-steps", 0.1, solver.global_sub_steps_per_tick});
    solver.contact_hertz = t.number("contact_hertz_Hz", solver.contact_hertz, {"a contact frequency", 1, 10000});
    solver.contact_damping_ratio =
        t.number("contact_damping_ratio", solver.contact_damping_ratio, {"a damping ratio", 0.1, 100});
    const double highest = max_contact_hertz(solver, kNominalTick_s);
    if (solver.contact_hertz > highest)
      t.mistake("contact_hertz_Hz",
                fmt::format("{:g} Hz is too stiff for {} haptic and {:g} global sub-steps in a tick of 1 ms",
                            solver.contact_hertz, solver.sub_steps, solver.global_sub_steps_per_tick),
                fmt::format("at most {:g} Hz: 250 Hz x the smallest number of sub-steps", highest));
    t.finish();
  }

  void read_sleeping() {
    if (!scene_.effects.sleeping)
      root_.refuse("sleeping", "set, but the effect sleeping is not declared",
                   "\"sleeping\" among the effects, or no table [sleeping]");
    text::TableReader t = table("sleeping");
    SleepingChoice& sleeping = scene_.sleeping;
    sleeping.max_speed_m_per_s = t.number("max_speed_m_per_s", sleeping.max_speed_m_per_s, {"a speed", 1e-6, 10});
    sleeping.after_s = t.number("after_s", sleeping.after_s, {"a time", 0.01, 3600});
    sleeping.from_start = t.flag("from_start", sleeping.from_start);
    t.finish();
  }

  // The tables of each hand: [key] once, for all of them if `shared`, or [[key]] once for each. Null: it is absent.
  std::vector<const text::TomlNode*> tables_of_hands(const char* key, bool shared) {
    const std::span<const text::TomlNode> nodes = root_.tables(key, kMaxHands);
    const unsigned hands = scene_.hands();
    std::vector<const text::TomlNode*> tables(hands, nullptr);
    if (nodes.empty()) return tables;
    const bool one_for_all = nodes.size() == 1 && (shared || hands == 1);
    if (!one_for_all && nodes.size() != hands)
      root_.mistake(key, fmt::format("{} for {} hands, which are as many as there are proxies", nodes.size(), hands),
                    fmt::format("[[{}]] {}{} times", key, shared ? "once or " : "", hands));
    for (unsigned hand = 0; hand < hands; ++hand) {
      const std::size_t i = one_for_all ? 0 : hand;
      if (i < nodes.size()) tables[hand] = &nodes[i];
    }
    return tables;
  }

  SceneDevice& device_of(unsigned hand) { return hand == 0 ? scene_.device : scene_.more_hands[hand - 1].device; }
  haptics::CouplingGains& coupling_of(unsigned hand) {
    return hand == 0 ? scene_.coupling : scene_.more_hands[hand - 1].coupling;
  }

  void read_devices() {
    const auto tables = tables_of_hands("device", true);
    for (unsigned hand = 0; hand < tables.size(); ++hand) {
      text::TableReader t(tables[hand], "[device]", diagnostics_);
      SceneDevice& device = device_of(hand);
      device.profile = t.word("profile", device.profile, {"virtuose6d", "desk3d"});
      device.world_from_device = t.pose();
      device.motion_scale = t.number("motion_scale", device.motion_scale, {"a scale", 0.01, 100});
      t.finish();
    }
  }

  void read_couplings() {
    const auto tables = tables_of_hands("coupling", true);
    for (unsigned hand = 0; hand < tables.size(); ++hand) {
      text::TableReader t(tables[hand], "[coupling]", diagnostics_);
      haptics::CouplingGains& gains = coupling_of(hand);
      gains.stiffness_N_per_m = t.number("stiffness_N_per_m", gains.stiffness_N_per_m, kStiffness);
      gains.damping_Ns_per_m = t.number("damping_Ns_per_m", gains.damping_Ns_per_m, kDamping);
      gains.stiffness_Nm_per_rad = t.number("stiffness_Nm_per_rad", gains.stiffness_Nm_per_rad, kStiffness);
      gains.damping_Nms_per_rad = t.number("damping_Nms_per_rad", gains.damping_Nms_per_rad, kDamping);
      t.finish();
    }
  }

  void read_hands() {
    const auto tables = tables_of_hands("hand", false);
    for (unsigned hand = 0; hand < tables.size(); ++hand)
      hand_.read({tables[hand], "[hand]", diagnostics_}, hand == 0 ? scene_.hand : scene_.more_hands[hand - 1].hand,
                 hand == 0 ? scene_.proxy : scene_.more_hands[hand - 1].proxy);
  }

  // Reads the proxies. Each table makes one hand.
  void read_proxies() {
    if (!root_.require("proxy", "a table [proxy]: the body that the device holds")) return;
    bool first = true;
    for (const text::TomlNode& node : root_.tables("proxy", kMaxHands)) {
      text::TableReader t(&node, "[proxy]", diagnostics_);
      if (!t.there()) continue;
      const auto& body = add_listed(bodies_.read(t, BodyRole::kProxy), node);
      if (first)
        scene_.proxy = body.id;
      else
        scene_.more_hands.push_back({.proxy = body.id, .device = {}, .coupling = {}, .hand = {}});
      first = false;
      check_friction(t, body.friction);
      effects_.set_surface(body.id, effects_.read_surface(t));
      effects_.set_name(body.id == 0 ? "proxy" : fmt::format("proxy{}", body.id + 1), body.id);
      t.finish();
    }
  }

  void read_bodies() {
    unsigned number = 0;
    for (const text::TomlNode& node : root_.array("body", kMaxSceneBodies - 1)) {
      text::TableReader t(&node, fmt::format("[body.{}]", ++number), diagnostics_);
      if (!t.there()) continue;
      auto& body = add_listed(bodies_.read(t, BodyRole::kBody), node);
      check_friction(t, body.friction);
      effects_.set_surface(body.id, effects_.read_surface(t));
      effects_.read_body(t, body);
      t.finish();
    }
  }

  void read_generators() {
    unsigned number = 0;
    for (const text::TomlNode& node : root_.array("generate", 1000)) {
      text::TableReader t(&node, fmt::format("[generate.{}]", ++number), diagnostics_);
      if (!t.there()) continue;
      const auto surface = effects_.read_surface(t);
      Generated made = read_generator(t, kMaxSceneBodies - static_cast<unsigned>(scene_.bodies.size()));
      if (made.bodies.empty()) continue;
      check_friction(t, made.part.friction);
      made.part.first = static_cast<BodyId>(scene_.bodies.size());
      made.part.line = node.line;
      for (const auto& body : made.bodies) effects_.set_surface(add(body).id, surface);
      scene_.generated.push_back(std::move(made.part));
    }
  }

  physics::Body& add(physics::Body body) {
    body.id = static_cast<BodyId>(scene_.bodies.size());
    scene_.bodies.push_back(body);
    return scene_.bodies.back();
  }

  physics::Body& add_listed(const ReadBody& read, const text::TomlNode& table) {
    const text::TomlNode* name = table.find("name");
    scene_.listed.push_back(
        {.name = name == nullptr ? "" : name->text, .line = table.line, .given_from_body = read.given_from_body});
    return add(read.body);
  }

  void check_friction(text::TableReader& t, double friction) {
    if (friction > 0 && !scene_.effects.friction)
      t.mistake("friction", "set, but the effect friction is not declared", "\"friction\" among the effects, or 0");
  }

  void check_card_houses() {
    double ground = 0;  // the house may stand on any fixed body: the largest friction is taken
    for (const auto& body : scene_.bodies)
      if (body.kind == physics::BodyKind::kFixed) ground = std::max(ground, body.friction);
    for (const auto& part : scene_.generated) {
      if (part.foot_friction.empty()) continue;
      const double on_ground = std::sqrt(part.friction * ground);
      if (part.friction < part.top_friction)
        root_.warning("generate",
                      fmt::format("the card house cannot stand: friction {:.3g} between cards", part.friction),
                      fmt::format("at least {:.3g}", part.top_friction));
      if (on_ground < part.foot_friction.front())
        root_.warning("generate",
                      fmt::format("the card house cannot stand: friction {:.3g} with the ground", on_ground),
                      fmt::format("at least {:.3g}", part.foot_friction.front()));
    }
  }

  text::TableReader root_;
  Scene& scene_;
  text::Diagnostics& diagnostics_;
  BodyReader bodies_;
  HandReader hand_;
  EffectReader effects_;
};

Result<Scene> finish(Scene scene, text::Diagnostics found, text::Diagnostics* diagnostics) {
  found.sort_by_place();
  const bool good = found.ok();
  std::string message = found.message();
  if (diagnostics != nullptr) *diagnostics = std::move(found);
  if (!good) return Status::error(std::move(message));
  return scene;
}

// `folder`: of the scene's files; none: no file is opened.
Result<Scene> parse(std::string_view text, std::string_view name, const std::optional<std::filesystem::path>& folder,
                    text::Diagnostics* diagnostics) {
  text::Diagnostics found;
  found.name = std::string(name);
  Scene scene;
  scene.name = std::filesystem::path(name).stem().string();
  text::TomlNode root;
  std::string kept;
  if (text::read_toml(text, root, found)) {
    SceneReader reader(root, scene, found, folder);
    reader.read();
    kept = reader.kept_files();
  }
  if (text.size() + kept.size() > kMaxSceneBytes && found.ok())  // a tape with a longer source could not be read
    found.add({.where = "the file",
               .what = fmt::format("{} bytes with what its files hold", text.size() + kept.size()),
               .accepted = fmt::format("at most {} bytes: fewer rows, corners or triangles", kMaxSceneBytes)});
  if (found.ok()) scene.source = std::string(text) + kept;
  return finish(std::move(scene), std::move(found), diagnostics);
}

}  // namespace

Result<Scene> parse_scene(std::string_view text, std::string_view name, text::Diagnostics* diagnostics) {
  return parse(text, name, std::nullopt, diagnostics);
}

Result<Scene> load_scene(const std::filesystem::path& path, text::Diagnostics* diagnostics) {
  if (const auto text = text::read_file(path, kMaxSceneBytes))
    return parse(*text, path.string(), path.parent_path(), diagnostics);
  text::Diagnostics found;
  found.name = path.string();
  found.add({.where = "the file",
             .what = "cannot be read",
             .accepted = "the path of a scene file, such as sim/scenes/card_house.toml"});
  return finish({}, std::move(found), diagnostics);
}

std::vector<text::AskedKey> asked_keys(std::string_view text) {
  std::vector<text::AskedKey> asked;
  text::Diagnostics found;
  found.asked = &asked;
  Scene scene;
  text::TomlNode root;
  if (text::read_toml(text, root, found)) SceneReader(root, scene, found, std::nullopt).read();
  return asked;
}

std::string source_hash(std::string_view source) {
  Fnv1a hash;
  hash.add_text(source);
  return fmt::format("{:016x}", hash.value());
}

double max_contact_hertz(const SolverChoice& solver, double tick_s) noexcept {
  double fewest = std::min(double(solver.sub_steps), solver.global_sub_steps_per_tick);
  if (solver.far_sub_steps_per_tick > 0) fewest = std::min(fewest, solver.far_sub_steps_per_tick);
  return 0.25 * fewest / tick_s;
}

}  // namespace tactus::sim
