// Masses, centres, moments and start of imported bodies against those that MuJoCo's compiler gives.
#include <algorithm>
#include <map>

#include "rt/physics/shapes/compound.h"
#include "tests/tools/import/import_bench.h"
#include "tools/import/compiled_model.h"

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

// By name.
std::map<std::string, physics::Body> bodies_of(const sim::Scene& scene, const std::string& text) {
  std::map<std::string, physics::Body> bodies;
  const auto names = names_of(text);
  REQUIRE(names.size() + 1 == scene.bodies.size());
  for (std::size_t i = 0; i < names.size(); ++i) bodies[names[i]] = scene.bodies[i + 1];
  return bodies;
}

scene_import::CompiledModel compiled(const std::string& name) {
  scene_import::Account account;
  auto model = scene_import::compile_model(compiler(), kModels / name, {}, account);
  REQUIRE(model.ok());
  return std::move(model).value();
}

// A part of a body as MuJoCo has it: kind, size, place; hulls by their centre.
void check_part(const physics::CompoundPart& part, const Posed& world_from_body, const scene_import::ModelGeom& geom) {
  const Posed pose = world_from_body * part.body_from_part;
  CHECK(norm(pose.position - geom.pose.position) < 1e-9);
  if (geom.type == "mesh") {
    CHECK(part.shape.kind == physics::ShapeKind::kHull);
    return;
  }
  for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    CHECK(norm(rotate(pose.rotation, axis) - rotate(geom.pose.rotation, axis)) < 1e-9);
  const physics::Shape expected = geom.type == "sphere"     ? physics::Shape::sphere(geom.size.x)
                                  : geom.type == "capsule"  ? physics::Shape::capsule(geom.size.x, geom.size.y)
                                  : geom.type == "cylinder" ? physics::Shape::cylinder(geom.size.x, geom.size.y)
                                                            : physics::Shape::box(geom.size);
  CHECK(part.shape.kind == expected.kind);
  const Vec3d sizes{part.shape.radius, part.shape.half_length, 0}, known{expected.radius, expected.half_length, 0};
  CHECK(norm(sizes - known) < 1e-15);
  CHECK(norm(part.shape.half_extents - expected.half_extents) < 1e-15);
}

}  // namespace

TEST_CASE("imported bodies have the mass, centre and moments that MuJoCo gives them, to 1e-9") {
  TACTUS_NEEDS_COMPILER();
  const std::string name =
      GENERATE("shapes.xml", "inertial.xml", "several.xml", "gripper.xml", "cabinet.urdf", "roll.xml");
  CAPTURE(name);
  const auto made = imported(name);
  const auto scene = loaded(made);
  const auto model = compiled(name);
  auto bodies = bodies_of(scene, made.files.text);
  unsigned compared = 0;
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const auto& body = model.bodies[b];
    if (body.weld != static_cast<int>(b) || body.mocap) continue;
    MassProperties whole;
    for (const auto& other : model.bodies)
      if (other.weld == static_cast<int>(b)) whole = whole + other.mass;
    CAPTURE(body.name);
    REQUIRE(bodies.count(body.name) == 1);
    const MassProperties ours = mass_of(bodies[body.name]);
    CHECK(ours.mass == Approx(whole.mass).epsilon(1e-9));
    CHECK(norm(ours.centre - whole.centre) < 1e-9);
    CHECK(scene_import::largest_difference(ours.inertia, whole.inertia) < 1e-9 * scene_import::trace(whole.inertia));
    ++compared;
  }
  CHECK(compared >= 2);
}

TEST_CASE("several shapes of a body are one compound, each part where MuJoCo has its shape") {
  TACTUS_NEEDS_COMPILER();
  const auto made = imported("several.xml");
  const auto scene = loaded(made);
  const auto model = compiled("several.xml");
  auto bodies = bodies_of(scene, made.files.text);
  CHECK(bodies.size() == 4);
  CHECK(made.account.joints == 0);
  std::map<std::string, std::size_t> parts;
  for (const auto& geom : model.geoms) {
    if (!geom.touches) continue;
    const auto& head = model.bodies[static_cast<std::size_t>(model.bodies[static_cast<std::size_t>(geom.body)].weld)];
    CAPTURE(head.name, parts[head.name]);
    const physics::Body& body = bodies.at(head.name);
    REQUIRE(body.shape.kind == physics::ShapeKind::kCompound);
    const auto& compound = scene.compounds[body.shape.index];
    REQUIRE(parts[head.name] < compound.parts.size());
    check_part(compound.parts[parts[head.name]++], body.motion.pose, geom);
  }
  for (const auto& [name, count] : parts) CHECK(scene.compounds[bodies.at(name).shape.index].parts.size() == count);
  const std::string changed = fmt::format("{}", fmt::join(made.account.changed, "\n"));
  CHECK_THAT(changed, Contains("body \"hammer\": 3 shapes, one compound body; mass, centre and moments exact") &&
                          Contains("body \"tray\": 2 shapes, one compound body\n"));
  // Friction of the head, the handle and the ring: 0.4, 0.9 with a torsional one, and 1.
  CHECK_THAT(changed, Contains("body \"hammer\": its shapes have friction of their own, the compound the largest: "
                               "sliding 0.4 to 1, torsional [m] 0 to 0.01"));
  CHECK(bodies["hammer"].friction == 1);
  CHECK_THAT(made.files.text, Contains("contact_radius_m = 0.015\n") && Contains("kinematic = true\n"));
}

TEST_CASE("a shape keeps its surface where its mass is not central") {
  TACTUS_NEEDS_COMPILER();
  const auto made = imported("inertial.xml");
  const auto scene = loaded(made);
  const auto model = compiled("inertial.xml");
  auto bodies = bodies_of(scene, made.files.text);
  CHECK(bodies["stiff_box"].shape == physics::Shape::box({0.05, 0.05, 0.04}));
  for (const auto& geom : model.geoms) {
    const std::string name = model.bodies[static_cast<std::size_t>(geom.body)].name;
    if (name == "stiff_box") continue;
    CAPTURE(name);
    const physics::Body& body = bodies.at(name);
    REQUIRE(body.shape.kind == physics::ShapeKind::kCompound);
    REQUIRE(scene.compounds[body.shape.index].parts.size() == 1);
    check_part(scene.compounds[body.shape.index].parts[0], body.motion.pose, geom);
  }
  CHECK(made.account.changed.size() == 1);  // the proxy, filled in
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
