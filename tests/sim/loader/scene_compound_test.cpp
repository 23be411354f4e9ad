// Compounds in scene files: mass, centre and moments of the parts together, and every mistake with its place.
#include <algorithm>
#include <catch2/catch.hpp>

#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;

namespace {

const std::string kProxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\nposition_m = [5, 5, 5]\n";

Scene good(const std::string& text) {
  auto scene = parse_scene(text + kProxy, "x.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

std::string wrong(const std::string& text) {
  const auto scene = parse_scene(text + kProxy, "x.toml");
  REQUIRE_FALSE(scene.ok());
  return scene.message();
}

std::string compound(const std::string& keys, const std::string& parts) {
  return "[[body]]\nshape = \"compound\"\n" + keys + "\n" + parts;
}

std::string box(const std::string& size, const std::string& place, const std::string& more = "") {
  return "[[body.parts]]\nshape = \"box\"\nsize_m = " + size + "\nposition_m = " + place + "\n" + more + "\n";
}

const std::string kHalves = box("[0.1, 0.2, 0.3]", "[0.05, 0.1, 0.15]") +
                            box("[0.1, 0.2, 0.3]", "[0.15, 0.1, 0.15]");  // a box of 0.2, 0.2, 0.3

}  // namespace

TEST_CASE("Two halves have the mass, the centre and the moments of the whole") {
  for (const std::string mass : {"mass_kg = 12", "density_kg_per_m3 = 1000"}) {
    const Scene scene = good(compound(mass + "\nposition_m = [1, 2, 3]", kHalves));
    const auto& body = scene.bodies[1];
    CHECK(body.shape.kind == physics::ShapeKind::kCompound);
    CHECK(body.mass == Approx(12).epsilon(1e-12));
    CHECK(norm(body.motion.pose.position - Vec3d{1.1, 2.1, 3.15}) < 1e-12);
    const Vec3d whole = physics::inertia_of(physics::Shape::box({0.1, 0.1, 0.15}), 12);
    CHECK(norm(body.inertia - whole) < 1e-12);
    REQUIRE(scene.compounds.size() == 1);
    CHECK(scene.compounds[0].volume == Approx(0.012).epsilon(1e-12));
    CHECK(norm(scene.compounds[0].half_extents - Vec3d{0.1, 0.1, 0.15}) < 1e-12);
    CHECK(scene.compounds[0].half_thickness == Approx(0.05));
  }
}

TEST_CASE("Parts of their own masses, turned and of any shape, add up by the parallel axes") {
  const Scene scene = good(compound(
      "",
      "[[body.parts]]\nshape = \"sphere\"\nradius_m = 0.1\nmass_kg = 3\nposition_m = [0.3, 0, 0]\n"
      "[[body.parts]]\nshape = \"capsule\"\nradius_m = 0.05\nlength_m = 0.2\nmass_kg = 1\nposition_m = [-0.1, 0.2, 0]\n"
      "rotation_vector_rad = [0, 1.5707963267948966, 0]\n"
      "[[body.parts]]\nshape = \"hull\"\npoints_m = [[0,0,0],[0.1,0,0],[0,0.1,0],[0,0,0.1],[0.1,0.1,0],[0.1,0,0.1],"
      "[0,0.1,0.1],[0.1,0.1,0.1]]\ndensity_kg_per_m3 = 2000\nposition_m = [-0.05, -0.05, 0.4]\n"));
  const auto& body = scene.bodies[1];
  CHECK(body.mass == Approx(6).epsilon(1e-12));  // the cube has 2 kg, and its centre at [0, 0, 0.45]
  const Vec3d centre{(3 * 0.3 - 0.1) / 6, 0.2 / 6, 2 * 0.45 / 6};
  CHECK(norm(body.motion.pose.position - centre) < 1e-12);

  // The tensor about the centre, along the world's axes; the capsule lies along x.
  const Vec3d ball = physics::inertia_of(physics::Shape::sphere(0.1), 3);
  const Vec3d rod = physics::inertia_of(physics::Shape::capsule(0.05, 0.1), 1);
  const Vec3d cube = physics::inertia_of(physics::Shape::box({0.05, 0.05, 0.05}), 2);
  double expected[3][3]{};
  const auto add = [&](const Vec3d& own, double m, const Vec3d& at) {
    const Vec3d d = at - centre;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) expected[i][k] += (i == k ? own[i] + m * norm_squared(d) : 0) - m * d[i] * d[k];
  };
  add(ball, 3, {0.3, 0, 0});
  add({rod.z, rod.y, rod.x}, 1, {-0.1, 0.2, 0});
  add(cube, 2, {0, 0, 0.45});
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      double found = 0;  // sum over the principal axes
      for (int axis = 0; axis < 3; ++axis) {
        Vec3d unit;
        unit[axis] = 1;
        const Vec3d n = rotate(body.motion.pose.rotation, unit);
        found += body.inertia[axis] * n[i] * n[k];
      }
      CHECK(found == Approx(expected[i][k]).margin(1e-12));
    }
  // The parts are where they were written.
  for (const auto& part : scene.compounds[0].parts)
    if (part.shape.kind == physics::ShapeKind::kSphere)
      CHECK(norm(body.motion.pose * part.body_from_part.position - Vec3d{0.3, 0, 0}) < 1e-12);
}

TEST_CASE("A compound takes given moments and a given centre, and stays where it is") {
  const Scene scene = good(compound(
      "mass_kg = 2\ninertia_kg_m2 = [0.3, 0.4, 0.5, 0.01, 0.02, 0.03]\ncentre_of_mass_m = [0.1, 0.1, 0.05]", kHalves));
  const auto& body = scene.bodies[1];
  CHECK(norm(body.motion.pose.position - Vec3d{0.1, 0.1, 0.05}) < 1e-12);
  CHECK(body.inertia.x + body.inertia.y + body.inertia.z == Approx(1.2));
  CHECK(norm(body.motion.pose * scene.compounds[0].parts[0].body_from_part.position - Vec3d{0.05, 0.1, 0.15}) < 1e-12);
}

TEST_CASE("A fixed compound, a kinematic one and a proxy, and bodies that are alike share a compound") {
  const Scene scene = good("effects = [\"kinematic\"]\n" + compound("fixed = true", kHalves) +
                           compound("kinematic = true\nposition_m = [1, 0, 0]", kHalves) +
                           compound("mass_kg = 1\nposition_m = [2, 0, 0]", kHalves));
  CHECK(scene.bodies[1].kind == physics::BodyKind::kFixed);
  CHECK(scene.bodies[2].kind == physics::BodyKind::kDynamic);
  CHECK(scene.compounds.size() == 1);
  CHECK_THAT(to_text(report_on(scene, {}, 1e-3)), Contains("3 compounds of 6 parts"));
  const auto proxy = parse_scene(
      "[proxy]\nshape = \"compound\"\nmass_kg = 0.1\n[[proxy.parts]]\nshape = \"sphere\"\nradius_m = 0.01\n", "x.toml");
  REQUIRE(proxy.ok());
  CHECK(proxy.value().bodies[0].gravity_scale == 0);
}

TEST_CASE("Mistakes in a compound are found by part and key") {
  CHECK_THAT(wrong(compound("mass_kg = 1", "")), Contains("[body.1] parts: missing; accepted: [[body.parts]] tables"));
  CHECK_THAT(wrong(compound("mass_kg = 1\nparts = []", "")), Contains("[body.1] parts: are none; accepted: 1 to 128"));
  CHECK_THAT(wrong(compound("mass_kg = 1\nsize_m = [1, 1, 1]", kHalves)), Contains("[body.1] size_m: not a key"));
  CHECK_THAT(wrong(compound("", kHalves)), Contains("[body.1] parts.1 mass_kg: missing"));
  CHECK_THAT(wrong(compound("mass_kg = 1", box("[1, 1, 1]", "[0, 0, 0]", "mass_kg = 1"))),
             Contains("[body.1] parts.1 mass_kg: the body has a mass already"));
  CHECK_THAT(wrong(compound("fixed = true", box("[1, 1, 1]", "[0, 0, 0]", "density_kg_per_m3 = 1"))),
             Contains("[body.1] parts.1 density_kg_per_m3: the body has no mass"));
  CHECK_THAT(wrong(compound("mass_kg = 1", kHalves + "[[body.parts]]\nshape = \"mesh\"\n")),
             Contains("[body.1] parts.3 shape: \"mesh\""));
  CHECK_THAT(wrong(compound("mass_kg = 1", kHalves + "[[body.parts]]\nshape = \"sphere\"\nradius = 1\n")),
             Contains("[body.1] parts.3 radius: not a key") && Contains("radius_m"));
  CHECK_THAT(wrong(compound("mass_kg = 1\ncentre_of_mass_m = [0, 0, 0]", kHalves)),
             Contains("[body.1] centre_of_mass_m: there are no moments of inertia about it"));
  CHECK_THAT(wrong("[[body]]\nshape = \"sphere\"\nradius_m = 1\nmass_kg = 1\n[[body.parts]]\nshape = \"box\"\n"),
             Contains("[body.1] parts: a sphere has none; accepted: no such key; or shape = \"compound\"") &&
                 !Contains("did you mean"));
  CHECK_THAT(wrong("[[body]]\nshape = \"sphere\"\nradius_m = 1\nmass_kg = 1\nspin = 1\n"), !Contains("parts"));
}

TEST_CASE("More contacts at the start than the world has room for are a problem, in one line with the pair") {
  // Two mats of 40 bars, one across the other: 1600 contacts, where 80 parts have room for 640.
  const auto mats = [](int bars) {
    std::string text;
    for (const bool across : {false, true}) {
      std::string parts;
      for (int i = 0; i < bars; ++i) {
        const std::string at = std::to_string(0.02 * i - 0.4);
        parts +=
            across ? box("[0.01, 1, 0.01]", "[" + at + ", 0, 0.01]") : box("[1, 0.01, 0.01]", "[0, " + at + ", 0]");
      }
      text += compound("mass_kg = 1", parts);
    }
    return text;
  };
  const SceneReport many = report_on(good(mats(40)), {}, 1e-3), few = report_on(good(mats(10)), {}, 1e-3);
  CHECK(many.start.contacts == 1600);
  CHECK(many.capacity.global_contacts == 8 * 81);
  const auto of_room = [](const SceneReport& report) {
    return std::count_if(report.problems.begin(), report.problems.end(), [](const std::string& text) {
      return text.find("contacts at the start") != std::string::npos;
    });
  };
  REQUIRE(of_room(many) == 1);
  CHECK_FALSE(many.good());
  CHECK_THAT(to_text(many), Contains("1600 contacts at the start, 1600 of them between") &&
                                Contains("at most 648, beyond which the shallowest are left out"));
  CHECK(of_room(few) == 0);
}

TEST_CASE(
    "A list of parts that is none, or too long, is one mistake, and moments of a cylinder name what may have more") {
  std::string many;
  for (int i = 0; i < 129; ++i) many += box("[0.1, 0.1, 0.1]", "[0, 0, 0]");
  const std::string of_many = wrong(compound("mass_kg = 1", many)),
                    of_none = wrong(compound("mass_kg = 1\nparts = {}", ""));
  CHECK_THAT(of_many, Contains("[body.1] parts: ") && Contains("an array of at most 128") && !Contains("are none"));
  CHECK_THAT(of_none, Contains("[body.1] parts: ") && Contains("[[body.parts]] for each") && !Contains("are none"));
  CHECK_THAT(wrong("[[body]]\nshape = \"cylinder\"\nradius_m = 1\nlength_m = 1\nmass_kg = 1\n"
                   "inertia_kg_m2 = [1, 1, 1, 0.1, 0, 0]\n"),
             Contains("need a hull or a compound") && Contains("or shape = \"hull\" or \"compound\""));
}

TEST_CASE("The text of a scene with compounds loads to the same bits") {
  const Scene scene = good(compound("mass_kg = 1", kHalves));
  const auto again = parse_scene(scene.source, "x.toml");
  REQUIRE(again.ok());
  CHECK(again.value().bodies[1].motion == scene.bodies[1].motion);
  CHECK(std::equal(again.value().compounds[0].parts.begin(), again.value().compounds[0].parts.end(),
                   scene.compounds[0].parts.begin(), scene.compounds[0].parts.end()));
}
