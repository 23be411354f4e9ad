// Hulls and how far they are from what they stand for; meshes, pieces, and files of shapes.
#include <random>

#include "sim/geometry/hull_builder.h"
#include "tests/tools/import/import_bench.h"
#include "tools/import/compiled_model.h"
#include "tools/import/pieces.h"

using namespace tactus;
using namespace tactus::test;
using namespace tactus::scene_import;
using Catch::Matchers::Contains;

namespace {

// Points of an ellipsoid's surface.
std::vector<Vec3d> on_ellipsoid(const Vec3d& half_axes, int count) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i)
    points.push_back(
        scale(half_axes, normalized_or(Vec3d{normal(random), normal(random), normal(random)}, Vec3d{1, 0, 0})));
  return points;
}

double farthest(const std::vector<Vec3d>& points, const std::vector<Vec3d>& hull) {
  const auto surface = surface_of(hull);
  REQUIRE(surface.ok());
  double most = 0;
  for (const Vec3d& p : points) most = std::max(most, distance_to(p, surface.value()));
  return most;
}

void check_same(const MassProperties& ours, const MassProperties& expected) {
  CHECK(ours.mass == Approx(expected.mass).epsilon(1e-9));
  CHECK(norm(ours.centre - expected.centre) < 1e-9);
  CHECK(largest_difference(ours.inertia, expected.inertia) < 1e-9 * trace(expected.inertia));
}

// The scene's only body is a compound, and the account says so.
void check_pieces(const Imported& made, std::size_t most) {
  const auto scene = loaded(made);
  REQUIRE(scene.compounds.size() == 1);
  const std::size_t count = scene.compounds[0].parts.size();
  CHECK(count >= 2);
  CHECK(count <= most);
  CHECK_THAT(fmt::format("{}", fmt::join(made.account.changed, "\n")),
             Contains(fmt::format("{} shapes, one compound body", count)));
}

}  // namespace

TEST_CASE("an ellipsoid's hull is as far from it as it says") {
  const Vec3d half{0.05, 0.03, 0.02};
  const HullPoints hull = ellipsoid_hull(half);
  CHECK(hull.points.size() == 62);
  const double inward = farthest(on_ellipsoid(half, 3000), hull.points);
  CHECK(inward <= 1.001 * hull.deviation_m);
  CHECK(inward > 0.5 * hull.deviation_m);
  CHECK(hull.deviation_m < 0.04 * half.x);
}

TEST_CASE("a cylinder is a cylinder, turned as MuJoCo has it") {
  TACTUS_NEEDS_COMPILER();
  const auto made = imported("shapes.xml");
  const auto scene = loaded(made);
  const physics::Body& body = scene.bodies[4];
  CHECK(body.shape == physics::Shape::cylinder(0.03, 0.05));
  CHECK(norm(rotate(body.motion.pose.rotation, Vec3d{0, 0, 1}) -
             Vec3d{std::sin(35 * kPi / 180), 0, std::cos(35 * kPi / 180)}) < 1e-12);
  CHECK(body.inertia == physics::inertia_of(body.shape, body.mass));
  CHECK_THAT(fmt::format("{}", fmt::join(made.account.changed, "\n")), !Contains("cylinder"));
}

TEST_CASE("a number is written without the rounding of its computation") {
  CHECK(decimal(8.673617379884035e-18, 1e-16) == "0");
  CHECK(decimal(-0.0, 0) == "0");
  CHECK(decimal(0.08000000000000002, 1e-15) == "0.08");
  CHECK(decimal(0.07999999999999996, 1e-15) == "0.08");
  CHECK(decimal(-1.0000000000000002) == "-1");
  // What is larger than the rounding stays, bit by bit.
  CHECK(std::strtod(decimal(8.673617379884035e-18, 0).c_str(), nullptr) == 8.673617379884035e-18);
  CHECK(decimal(0.08000000000000002, 1e-18) == "0.08000000000000002");
  CHECK(decimal(1.0 / 3, 1e-15) == "0.3333333333333333");
  CHECK(decimal(kPi, kRounding) == "3.141592653589793");
  CHECK(decimal(0.10000000149011612, 0.1 * kSingleRounding) == "0.1");
}

TEST_CASE("no number of a written scene is noise") {
  TACTUS_NEEDS_COMPILER();
  for (const char* name : {"shapes.xml", "several.xml", "gripper.xml", "cabinet.urdf", "fixed.xml", "roll.xml"}) {
    CAPTURE(name);
    const auto made = imported(name);
    std::string text = made.files.text;
    for (const auto& [file, shape] : made.files.shapes) text += shape;
    unsigned numbers = 0;
    for (std::size_t at = 0; (at = text.find_first_of("-0123456789", at)) != std::string::npos; ++numbers) {
      char* end = nullptr;
      const double number = std::strtod(text.c_str() + at, &end);
      CAPTURE(number);
      CHECK((number == 0 || std::abs(number) > 1e-9));
      at = std::max(at + 1, static_cast<std::size_t>(end - text.c_str()));
    }
    CHECK(numbers > 30);
  }
}

TEST_CASE("a hull of many vertices is thinned to 64, and says by how much") {
  const auto points = on_ellipsoid({0.1, 0.1, 0.1}, 2000);
  const auto hull = hull_of(points);
  REQUIRE(hull.ok());
  CHECK(hull.value().points.size() == 64);
  CHECK(farthest(points, hull.value().points) == Approx(hull.value().deviation_m).epsilon(1e-9));
  CHECK(hull.value().deviation_m < 0.01);
  const std::vector<Vec3d> corners{{0, 0, 0}, {0.3, 0, 0}, {0, 0.2, 0}, {0, 0, 0.1}};
  CHECK(hull_of(corners).value().deviation_m == 0);
}

TEST_CASE("parts and wholes add up") {
  const MassProperties a = principal_mass(2, {0.1, 0, 0.3}, normalized(Quatd{1, 0.2, 0.3, -0.1}), {0.01, 0.02, 0.025});
  const MassProperties b =
      principal_mass(0.5, {-0.1, 0.2, 0}, normalized(Quatd{1, -0.2, 0, 0.5}), {0.003, 0.004, 0.005});
  // In any frame, in either order.
  const Posed frame{{0.3, -0.2, 0.1}, normalized(Quatd{1, 0.4, -0.3, 0.2})};
  const MassProperties whole = a + b, other = in_world(in_frame(b, frame) + in_frame(a, frame), frame);
  CHECK(whole.mass == Approx(2.5).epsilon(1e-12));
  CHECK(norm(whole.centre - (0.8 * a.centre + 0.2 * b.centre)) < 1e-12);
  CHECK(norm(whole.centre - other.centre) < 1e-12);
  CHECK(largest_difference(whole.inertia, other.inertia) < 1e-12);
  // The trace gains twice the reduced mass times the square of the distance.
  CHECK(trace(whole.inertia) ==
        Approx(trace(a.inertia) + trace(b.inertia) + 2 * 0.4 * norm_squared(a.centre - b.centre)).epsilon(1e-12));
  CHECK_FALSE(is_a_body(principal_mass(1, {}, {}, {1, 1, 3})));
}

TEST_CASE("an open surface is counted by its edges") {
  sim::TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}}};
  CHECK(open_edges(soup) == 3);
  soup.triangles.push_back({1, 2, 3});
  CHECK(open_edges(soup) == 0);
  std::swap(soup.triangles.back()[0], soup.triangles.back()[1]);
  CHECK(open_edges(soup) == 3);  // inside out
  CHECK(solid_of(soup).mass != Approx(1.0 / 6));
}

TEST_CASE("what never moves is taken over: plane, box, mesh, height field, mocap") {
  TACTUS_NEEDS_COMPILER();
  const auto made = imported("fixed.xml");
  const auto scene = loaded(made);
  CHECK(made.account.bodies == 7);
  CHECK(made.files.shapes.size() == 2);
  // Two rows of three cells, two triangles each; the second row's second point is 0.1 m up.
  CHECK(made.files.shapes[1].second.find("v -0.1 0 0.1\n") != std::string::npos);
  CHECK(scene.meshes.size() == 2);
  CHECK_THAT(made.files.text, Contains("kinematic = true"));
  const auto& ball = scene.bodies[2];
  CHECK(ball.friction == Approx(0.6));
  CHECK_THAT(made.files.text, Contains("contact_radius_m = 0.0075"));  // 3/2 x 0.003 / 0.6
  CHECK_THAT(made.files.text, Contains("rolling_friction_m = 0.0002"));
}

TEST_CASE("shapes of one body that never move are one fixed compound where their friction is one") {
  TACTUS_NEEDS_COMPILER();
  const auto made = imported("roll.xml");
  const auto scene = loaded(made);
  REQUIRE(scene.bodies.size() == 4);
  const physics::Body& incline = scene.bodies[3];
  CHECK(incline.kind == physics::BodyKind::kFixed);
  REQUIRE(incline.shape.kind == physics::ShapeKind::kCompound);
  CHECK(scene.compounds[incline.shape.index].parts.size() == 2);
  CHECK(incline.friction == 0.8);
  CHECK_THAT(fmt::format("{}", fmt::join(made.account.changed, "\n")),
             Contains("body \"incline\": 2 shapes that never move, one fixed compound body"));
  // Two frictions, two bodies; the world's own shapes stay what they are, by their names.
  CHECK(imported("incline.xml").account.bodies == 4);
  const Scratch scratch;
  const auto world = imported(
      options_for(scratch.write("walls.xml",
                                "<mujoco><worldbody><geom name='left' type='box' size='.1 1 1' pos='-1 0 0'/>"
                                "<geom name='right' type='box' size='.1 1 1' pos='1 0 0'/></worldbody></mujoco>")));
  CHECK(world.account.bodies == 2);
  CHECK_THAT(world.files.text, Contains("name = \"left\"") && Contains("name = \"right\""));
}

TEST_CASE("defaults, includes and copies are MuJoCo's") {
  TACTUS_NEEDS_COMPILER();
  const auto made = imported("included.xml");
  CHECK(made.account.bodies == 4);
  CHECK(loaded(made).bodies[1].mass == Approx(0.6).epsilon(1e-12));
}

TEST_CASE("a concave file becomes its hull, with the gap, or pieces, within the deviation", "[slow]") {
  TACTUS_NEEDS_ASSIMP();
  auto options = options_for(kModels / "bracket.obj");
  options.shapes.unit_m = 0.001;
  options.pieces.most = 1;
  const auto whole = imported(options);
  CHECK(whole.account.bodies == 1);
  const std::string changed = fmt::format("{}", fmt::join(whole.account.changed, "\n"));
  CHECK_THAT(changed, Contains("concave"));
  const auto scene = loaded(whole);
  CHECK(scene.bodies[1].mass == Approx(1000 * (0.06 * 0.01 + 0.01 * 0.03) * 0.02).epsilon(1e-6));

  options.pieces = {8, 0.0005};
  const auto divided = imported(options);
  CHECK(divided.account.bodies == 1);
  check_same(mass_of(loaded(divided).bodies[1]), mass_of(scene.bodies[1]));
  check_pieces(divided, 8);
}

TEST_CASE("a mesh in pieces has the mass, centre and moments that MuJoCo gives the whole") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  std::filesystem::copy_file(kModels / "bracket.obj", scratch.path / "bracket.obj");
  auto options = options_for(scratch.write(
      "bracket.xml",
      "<mujoco><asset><mesh name='bracket' file='bracket.obj' scale='.001 .001 .001' inertia='exact'/></asset>"
      "<worldbody><body name='bracket' pos='0 0 1' euler='10 20 30'><freejoint/><geom type='mesh' mesh='bracket'/>"
      "<geom size='.01' pos='0 0 .1'/></body></worldbody></mujoco>"));
  options.pieces = {8, 0.0005};
  const auto made = imported(options);
  Account account;
  const auto model = compile_model(compiler(), options.file, {}, account);
  REQUIRE(model.ok());
  check_same(mass_of(loaded(made).bodies[1]), model.value().bodies[1].mass);
  check_pieces(made, 9);
}

TEST_CASE("nodes of glTF are bodies, y is up, and custom properties count") {
  TACTUS_NEEDS_ASSIMP();
  const auto made = imported("blocks.gltf");
  const auto scene = loaded(made);
  REQUIRE(scene.bodies.size() == 4);
  CHECK(scene.bodies[1].mass == Approx(0.3).epsilon(1e-6));
  CHECK(scene.bodies[1].friction == Approx(0.4).epsilon(1e-6));
  CHECK(norm(scene.bodies[1].motion.pose.position - Vec3d{0, 0, 0.5}) < 1e-6);
  CHECK(scene.bodies[2].mass == Approx(1000 * 0.1 * 0.06 * 0.04).epsilon(1e-5));
  CHECK(norm(scene.bodies[2].motion.pose.position - Vec3d{0.3, -0.1, 0.5}) < 1e-6);
  CHECK(scene.bodies[3].kind == physics::BodyKind::kFixed);
}
