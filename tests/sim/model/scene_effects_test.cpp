// Effects in scene files: their keys are read, a key without its effect is a mistake that names it, an effect without
// use is a warning; and joints hold bodies together in the contact graph, in islands and in the sub-world.
#include "sim/model/scene_effects.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <memory>

#include "rt/haptics/coupling/sub_world.h"
#include "sim/loader/scene_load.h"
#include "tests/sim/global_world_bench.h"

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;
using physics::JointKind;

namespace {

const std::string kProxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\n";

text::Diagnostics diagnose(const std::string& text) {
  text::Diagnostics diagnostics;
  (void)parse_scene(text + kProxy, "x.toml", &diagnostics);
  return diagnostics;
}
Scene good(const std::string& text) {
  auto scene = parse_scene(text + kProxy, "x.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}
std::string cube(const std::string& name, const std::string& at, const std::string& more = "") {
  return fmt::format(
      "[[body]]\nname = \"{}\"\nshape = \"box\"\nsize_m = [0.1, 0.1, 0.1]\nmass_kg = 1\nposition_m = {}\n{}", name, at,
      more);
}
template <class Object>
const typename Object::Setup& setup_of(const physics::EffectSetups& setups) {
  return std::get<typename Object::Setup>(setups);
}

}  // namespace

TEST_CASE("a key or table that needs an effect which is not declared is a mistake that names the effect") {
  const std::pair<std::string, const char*> cases[] = {
      {"[damping]\nlinear_per_s = 1", "damping: set, but the effect damping is not declared"},
      {"[drag]\nfluid_density_kg_per_m3 = 1", "drag: set, but the effect drag is not declared"},
      {cube("a", "[0, 0, 1]", "kinematic = true\n"), "[body.1] kinematic: set, but the effect kinematic"},
      {cube("a", "[0, 0, 1]", "restitution = 0.5\n"), "[body.1] restitution: set, but the effect restitution"},
      {cube("a", "[0, 0, 1]", "contact_radius_m = 0.01\n"), "contact_radius_m: set, but the effect torsional"},
      {cube("a", "[0, 0, 1]", "rolling_friction_m = 0.01\n"), "rolling_friction_m: set, but the effect rolling"},
      {cube("a", "[0, 0, 1]") + "[[joint]]\nkind = \"ball\"\nb = \"a\"\n", "joint: set, but the effect joints"},
      {cube("a", "[0, 0, 1]", "attraction_weight = 1\n"), "attraction_weight: set, but the effect attraction"},
      {"[[attraction]]\nstrength_Nm2 = 1", "attraction: set, but the effect attraction"},
      {cube("a", "[0, 0, 1]", "texture_height_m = 1e-4\n"), "texture_height_m: set, but the effect texture"},
      {cube("a", "[0, 0, 1]", "transient_strength_Ns_per_m = 1\n"),
       "transient_strength_Ns_per_m: set, but the effect transients"},
  };
  for (const auto& [text, message] : cases) CHECK_THAT(diagnose(text).message(), Contains(message));
}

TEST_CASE("an effect that is declared and not used is a warning, and no world has it") {
  for (const auto& effect : known_effects()) {
    if (effect.name == "sleeping") continue;  // has always something to look at
    const std::string text = fmt::format("effects = [\"{}\"]", effect.name);
    CHECK_THAT(diagnose(text).warning_message(), Contains(fmt::format("\"{}\" is declared and not used", effect.name)));
    const Scene scene = good(text);
    CHECK_FALSE(is_in_use(scene, effect));
    const auto setups = effect_setups(scene);
    std::apply([](const auto&... setup) { CHECK_FALSE((setup.used() || ...)); }, setups);
  }
}

TEST_CASE("keys of effects are read into the options of the worlds") {
  const Scene scene = good(
      "effects = [\"friction\", \"damping\", \"drag\", \"kinematic\", \"restitution\", \"torsional\", \"rolling\", "
      "\"attraction\"]\n"
      "[damping]\nlinear_per_s = 0.5\nangular_per_s = 2\n"
      "[drag]\nfluid_density_kg_per_m3 = 1000\ncoefficient = 0.4\nflow_m_per_s = [1, 0, 0]\n" +
      cube("a", "[0, 0, 1]",
           "restitution = 0.7\ncontact_radius_m = 0.01\nrolling_friction_m = 0.002\nfriction = 0.5\n") +
      "[[body]]\nshape = \"box\"\nsize_m = [1, 1, 0.1]\nkinematic = true\nrepeat_path = true\n"
      "path = [{time_s = 0, position_m = [1, 2, 3]}, {time_s = 2, position_m = [1, 2, 4]}]\n"
      "[[body]]\nshape = \"box\"\nsize_m = [1, 1, 0.1]\nkinematic = true\nvelocity_m_per_s = [0, 0, 1]\n"
      "[[body]]\nshape = \"sphere\"\nradius_m = 0.1\nmass_kg = 2\nattraction_weight = 3\n"
      "[[attraction]]\nbody = \"a\"\nstrength_Nm2 = 4\nsoftening_m = 0.5\n");
  const auto setups = effect_setups(scene);
  CHECK(setup_of<physics::Damping>(setups).linear_per_s == 0.5);
  CHECK(setup_of<physics::Damping>(setups).angular_per_s == 2);
  const auto& drag = setup_of<physics::Drag>(setups);
  CHECK(drag.flow == Vec3d{1, 0, 0});
  REQUIRE(drag.per_m.size() == 5);
  CHECK(drag.per_m[4] == Approx(1000 * 0.4 * 3.14159265 * 0.01 / (2 * 2)));  // a disk of the sphere's radius
  CHECK(drag.per_m[1] == Approx(1000 * 0.4 * 0.06 / 4 / (2 * 1)));           // a quarter of the cube's surface
  const auto& kinematics = setup_of<physics::ScriptedMotion>(setups);
  REQUIRE(kinematics.scripts.size() == 2);
  CHECK(kinematics.scripts[0].keys == 2);
  CHECK(kinematics.scripts[0].repeat);
  CHECK(kinematics.scripts[1].keys == 0);
  CHECK(scene.bodies[2].motion.pose.position == Vec3d{1, 2, 3});
  CHECK(scene.bodies[3].motion.velocity.linear == Vec3d{0, 0, 1});
  CHECK(setup_of<physics::Restitution>(setups).by_id[1] == 0.7);
  CHECK(setup_of<physics::ContactTorque>(setups).by_id[1].radius_m == 0.01);
  CHECK(setup_of<physics::ContactTorque>(setups).by_id[1].rolling_m == 0.002);
  const auto& attraction = setup_of<physics::Attraction>(setups);
  REQUIRE(attraction.sources.size() == 1);
  CHECK(attraction.sources[0].body == 1);
  CHECK(attraction.sources[0].softening_m == 0.5);
  CHECK(attraction.weight_by_id[4] == 3);
}

TEST_CASE("what the hand alone feels is read for its own world, and the global world has none of it") {
  const Scene scene = good("effects = [\"texture\", \"transients\"]\n" +
                           cube("a", "[0, 0, 1]",
                                "texture_height_m = 1e-4\ntexture_wavelength_m = 0.003\n"
                                "transient_strength_Ns_per_m = 2\ntransient_frequency_Hz = 200\n"));
  const auto setups = effect_setups(scene);
  const auto& texture = setup_of<physics::Texture>(setups);
  REQUIRE(texture.by_id.size() == 2);
  CHECK(texture.proxy == scene.proxy);
  CHECK((texture.by_id[1].height_m == 1e-4 && texture.by_id[1].wavelength_m == 0.003));
  const auto& transients = setup_of<physics::Transients>(setups);
  REQUIRE(transients.by_id.size() == 2);
  CHECK((transients.by_id[1].strength_Ns_per_m == 2 && transients.by_id[1].frequency_Hz == 200));
  CHECK(transients.by_id[1].decay_s == 0.01);
  std::apply([](const auto&... setup) { CHECK_FALSE((setup.used() || ...)); }, global_effect_setups(scene));
  CHECK_THAT(diagnose("effects = [\"texture\"]\n" + cube("a", "[0, 0, 1]", "texture_height_m = 0.01\n")).message(),
             Contains("[body.1] texture_height_m: the grain's slope is"));
}

TEST_CASE("joints are read with their frames where the bodies are, and mistakes in them are named") {
  const std::string two = "effects = [\"joints\"]\n" + cube("frame", "[0, 0, 1]") + cube("door", "[0.2, 0, 1]");
  const Scene scene = good(two +
                           "[[joint]]\nkind = \"hinge\"\na = \"frame\"\nb = \"door\"\nposition_m = [0.1, 0, 1]\n"
                           "axis = [0, 2, 0]\nlow_rad = -1\nhigh_rad = 0.5\nmotor_torque_Nm = 2\n"
                           "motor_speed_rad_per_s = 3\nbreak_force_N = 50\n"
                           "[[joint]]\nkind = \"distance\"\nb = \"door\"\nposition_a_m = [0.2, 0, 2]\n");
  REQUIRE(scene.effect_data.joints.size() == 2);
  const auto& hinge = scene.effect_data.joints[0];
  CHECK((hinge.kind == JointKind::kHinge && hinge.a == 1 && hinge.b == 2 && hinge.limited && hinge.driven));
  CHECK((hinge.low == -1 && hinge.high == 0.5 && hinge.motor_effort == 2 && hinge.motor_speed == 3));
  CHECK(norm(hinge.b_from_joint.position - Vec3d{-0.1, 0, 0}) < 1e-12);
  CHECK(norm(rotate(hinge.a_from_joint.rotation, Vec3d{0, 0, 1}) - Vec3d{0, 1, 0}) < 1e-12);
  CHECK(hinge.break_force_N == 50);
  CHECK(std::isinf(hinge.break_torque_Nm));
  const auto& rod = scene.effect_data.joints[1];
  CHECK((rod.a == kNoBody && rod.limited && rod.low == rod.high));
  CHECK(rod.low == Approx(1));
  const std::pair<const char*, const char*> cases[] = {
      {"kind = \"hing\"\nb = \"door\"", "did you mean hinge?"},
      {"kind = \"ball\"\nb = \"dor\"", "no body is called \"dor\", did you mean door?"},
      {"kind = \"ball\"", "[joint.1] b: missing"},
      {"kind = \"ball\"\na = \"door\"\nb = \"door\"", "is the same body as a"},
      {"kind = \"hinge\"\nb = \"door\"", "[joint.1] axis: missing"},
      {"kind = \"hinge\"\nb = \"door\"\naxis = [0, 0, 1]\nlow_rad = 1\nhigh_rad = 0", "0 is below 1"},
      {"kind = \"slider\"\nb = \"door\"\naxis = [0, 0, 1]\nmotor_speed_m_per_s = 1", "there is no motor"},
      {"kind = \"ball\"\nb = \"door\"\naxis = [0, 0, 1]", "[joint.1] axis: not a key"},
  };
  for (const auto& [joint, message] : cases)
    CHECK_THAT(diagnose(two + "[[joint]]\n" + joint + "\n").message(), Contains(message));
  CHECK_THAT(diagnose("effects = [\"joints\"]\n" + cube("a", "[0, 0, 1]") + cube("a", "[0, 0, 2]")).message(),
             Contains("\"a\" is another body's name"));
}

namespace {

// A chain of cubes along x from beside the proxy, without gravity; the proxy touches none.
std::string chain(int links, double break_force_N = 0) {
  std::string text = "effects = [\"joints\", \"sleeping\"]\n[sleeping]\nafter_s = 0.05\n";
  for (int i = 0; i < links; ++i) text += cube(fmt::format("c{}", i), fmt::format("[{}, 0, 0]", 0.07 + 0.2 * i));
  for (int i = 1; i < links; ++i)
    text +=
        fmt::format("[[joint]]\nkind = \"ball\"\na = \"c{}\"\nb = \"c{}\"\nposition_m = [{}, 0, 0]\n{}", i - 1, i,
                    0.07 + 0.2 * i - 0.1, break_force_N > 0 ? fmt::format("break_force_N = {}\n", break_force_N) : "");
  return text;
}

struct Worlds {
  Scene scene;
  GlobalWorld world;
  std::unique_ptr<haptics::WorldSnapshot> snapshot = std::make_unique<haptics::WorldSnapshot>();
  std::unique_ptr<haptics::SubWorldReport> report = std::make_unique<haptics::SubWorldReport>();
  static GlobalOptions options(std::uint32_t cap) {
    GlobalOptions options = tactus::test::capped_border();
    options.extraction.cap = cap;
    return options;
  }
  Worlds(const Scene& given, std::uint32_t cap) : scene(given), world(scene, options(cap)) {
    world.first_snapshot(*snapshot);
  }
  haptics::SubWorldConfig sub_config() const {
    haptics::SubWorldConfig config;
    config.border_mode = physics::BorderMode::kCapped;
    config.proxy = scene.proxy;
    config.capacities.border_contacts = haptics::kMaxBorderPoints;
    config.effects = effect_setups(scene);
    choose_effects(scene, config.step);
    return config;
  }
  // One cycle of both.
  void cycle(haptics::SubWorld& sub) {
    sub.synchronise(*snapshot, *report);
    for (std::uint32_t i = 0; i < sub.config().ratio; ++i) (void)sub.step({}, 4, {});
    world.step(*report, *snapshot);
  }
};

}  // namespace

TEST_CASE("a member brings along what is joined to it, as far as the cap, and the first of a chain first") {
  const Scene scene = good(chain(12));
  Worlds all(scene, 64);
  CHECK(all.snapshot->members.size() == 13);  // nobody touches anybody: the first cube is close, the others joined
  Worlds few(scene, 5);
  REQUIRE(few.snapshot->members.size() == 5);
  for (std::uint32_t i = 0; i < 5; ++i) CHECK(few.snapshot->members[i] == i);
}

TEST_CASE("a joint across the border holds the member to the body outside, which moves on") {
  Scene scene = good(chain(3));
  for (BodyId id = 1; id <= 3; ++id) scene.bodies[id].motion.velocity.linear = {0, 0.2, 0};
  Worlds worlds(scene, 3);  // the proxy and two cubes
  haptics::SubWorld sub(worlds.sub_config(), {});
  for (int i = 0; i < 20; ++i) worlds.cycle(sub);
  REQUIRE(sub.members() == 3);
  const auto& states = sub.world().effects().find<physics::Joints>()->states();
  CHECK(norm(states[1].force) < 1);
  const auto& last = sub.world().bodies()[2].motion;
  CHECK(last.velocity.linear.y == Approx(0.2).epsilon(1e-2));
  CHECK(last.pose.position.y == Approx(0.2 * 0.2).epsilon(2e-2));
}

TEST_CASE("joined bodies are one island: they fall asleep and wake together without touching") {
  const Scene scene = good(chain(4));
  // Far from the proxy, so that it keeps nobody awake.
  Scene far = scene;
  for (BodyId id = 1; id <= 4; ++id) far.bodies[id].motion.pose.position.x += 20;
  far.bodies[4].motion.velocity.linear.y = 0.05;  // one that moves keeps all awake
  Worlds moving(far, 64);
  for (int i = 0; i < 20; ++i) {
    moving.report->cycle = moving.snapshot->cycle;
    moving.world.step(*moving.report, *moving.snapshot);
  }
  CHECK(moving.world.statistics().asleep == 0);
  far.bodies[4].motion.velocity = {};
  Worlds still(far, 64);
  for (int i = 0; i < 20; ++i) {
    still.report->cycle = still.snapshot->cycle;
    still.world.step(*still.report, *still.snapshot);
  }
  CHECK(still.world.statistics().asleep == 4);
}

TEST_CASE("a joint that breaks in the sub-world is broken in the global world too") {
  Scene scene = good(chain(2, 5));
  Worlds worlds(scene, 64);
  haptics::SubWorld sub(worlds.sub_config(), {});
  worlds.cycle(sub);
  REQUIRE(sub.members() == 3);
  CHECK(worlds.world.statistics().broken_joints == 0);
  // Pulled apart in the sub-world alone.
  Scene torn = scene;
  torn.bodies[2].motion.velocity.linear = {3, 0, 0};
  Worlds other(torn, 64);
  haptics::SubWorld pulled(other.sub_config(), {});
  for (int i = 0; i < 3; ++i) other.cycle(pulled);
  CHECK(pulled.world().effects().find<physics::Joints>()->states()[0].broken != 0);
  CHECK(other.world.statistics().broken_joints == 1);
}
