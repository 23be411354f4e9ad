// Masses, centres, moments and start of imported bodies against those that MuJoCo's compiler gives.
#include <algorithm>
#include <map>

#include "rt/physics/body.h"
#include "tests/tools/import/import_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;
using scene_import::MassProperties;

namespace {

// The names of a scene's bodies, in their order, without the proxy.
std::vector<std::string> names_of(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = 0; (at = text.find("\nname = \"", at)) != std::string::npos;) {
    at += 9;
    names.push_back(text.substr(at, text.find('"', at) - at));
  }
  return names;
}

MassProperties mass_of(const physics::Body& body) {
  return scene_import::principal_mass(body.mass, body.motion.pose.position, body.motion.pose.rotation, body.inertia);
}

// The sums over the bodies whose names are NAME and NAME_2, NAME_3, ...
std::map<std::string, MassProperties> sums_of(const sim::Scene& scene, const std::string& text) {
  std::map<std::string, MassProperties> sums;
  const auto names = names_of(text);
  REQUIRE(names.size() + 1 == scene.bodies.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t mark = names[i].find('_');
    const bool part = mark != std::string::npos && std::isdigit(names[i].back()) != 0;
    sums[part ? names[i].substr(0, mark) : names[i]] =
        sums[part ? names[i].substr(0, mark) : names[i]] + mass_of(scene.bodies[i + 1]);
  }
  return sums;
}

}  // namespace

TEST_CASE("imported bodies have the mass, centre and moments that MuJoCo gives them, to 1e-9") {
  TACTUS_NEEDS_COMPILER();
  const std::string name = GENERATE("shapes.xml", "inertial.xml", "several.xml", "gripper.xml", "cabinet.urdf");
  CAPTURE(name);
  const auto made = imported(name);
  const auto scene = loaded(made);
  scene_import::Account account;
  const auto model = scene_import::compile_model(compiler(), kModels / name, account);
  REQUIRE(model.ok());
  auto sums = sums_of(scene, made.files.text);
  unsigned compared = 0;
  for (std::size_t b = 1; b < model.value().bodies.size(); ++b) {
    const auto& body = model.value().bodies[b];
    if (body.weld != static_cast<int>(b) || body.mocap) continue;
    MassProperties whole;
    for (const auto& other : model.value().bodies)
      if (other.weld == static_cast<int>(b)) whole = whole + other.mass;
    CAPTURE(body.name);
    REQUIRE(sums.count(body.name) == 1);
    const MassProperties& ours = sums[body.name];
    CHECK(ours.mass == Approx(whole.mass).epsilon(1e-9));
    CHECK(norm(ours.centre - whole.centre) < 1e-9);
    CHECK(scene_import::largest_difference(ours.inertia, whole.inertia) < 1e-9 * scene_import::trace(whole.inertia));
    ++compared;
  }
  CHECK(compared >= 2);
}

TEST_CASE("a model begins at its first keyframe, with its velocities") {
  TACTUS_NEEDS_COMPILER();
  const auto slider = imported("slider.xml");
  const auto scene = loaded(slider);
  const Vec3d along{0.8660254037844386, 0, 0.5};
  CHECK(norm(scene.bodies[1].motion.velocity.linear - 3 * along) < 1e-12);
  // The bob's centre: its rod hangs at 0.4 rad, its middle 0.1 m from the hinge.
  const Vec3d bob = scene.bodies[2].motion.pose.position;
  CHECK(norm(bob - Vec3d{-0.1 * std::sin(0.4), 0, 0.97 - 0.1 * std::cos(0.4)}) < 1e-12);
}

TEST_CASE("limits count from the start") {
  TACTUS_NEEDS_COMPILER();
  const auto scene = loaded(imported("gripper.xml"));
  const auto& joints = scene.effect_data.joints;
  const auto lift = std::find_if(joints.begin(), joints.end(),
                                 [](const physics::Joint& j) { return j.kind == physics::JointKind::kSlider; });
  REQUIRE(lift != joints.end());
  // The lift's range is -0.05 to 0.05 m, and the keyframe has it at 0.01 m.
  CHECK(lift->low == Approx(-0.06).epsilon(1e-12));
  CHECK(lift->high == Approx(0.04).epsilon(1e-12));
}
