// Hulls in scene files: what a body gets from them, what a tape needs, and every mistake with its place.
#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;

namespace {

const std::string kProxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\nposition_m = [5, 5, 5]\n";
const std::string kCube =
    "points_m = "
    "[[0,0,0],[0.2,0,0],[0,0.2,0],[0,0,0.2],[0.2,0.2,0],[0.2,0,0.2],[0,0.2,0.2],[0.2,0.2,0.2],[0.1,0.1,0.1]]\n";

std::string hull(const std::string& keys) { return "[[body]]\nshape = \"hull\"\n" + keys; }

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

// A folder with a scene and the files beside it, gone at the end.
struct Folder {
  Folder() : path(std::filesystem::temp_directory_path() / fmt::format("tactus_hulls_{}", ::getpid())) {
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
  std::filesystem::path path;
};

}  // namespace

TEST_CASE("A hull from points has the mass, place and moments of the solid") {
  const Scene scene = good(hull(kCube + "density_kg_per_m3 = 1000\nposition_m = [1, 2, 3]\n"));
  REQUIRE(scene.hulls.size() == 1);
  const auto& body = scene.bodies[1];
  CHECK(body.shape.kind == physics::ShapeKind::kHull);
  CHECK(body.mass == Approx(8.0).epsilon(1e-12));
  CHECK(norm(body.motion.pose.position - Vec3d{1.1, 2.1, 3.1}) < 1e-12);
  CHECK(body.inertia.x == Approx(8.0 * 0.04 / 6).epsilon(1e-12));
  CHECK(scene.hulls[0].topology.vertices == 8);
  const auto report = report_on(scene, {}, 1e-3);
  CHECK(report.bodies.hulls == 1);
  CHECK_THAT(to_text(report), Contains("1 hulls"));
  CHECK(good(hull(kCube + "fixed = true\n")).bodies[1].kind == physics::BodyKind::kFixed);
}

TEST_CASE("A hull from a file is there once for all its bodies, and the scene's source needs no file any more") {
  const Folder folder;
  folder.write("cube \"1\".obj",
               "v 0 0 0\nv 200 0 0\nv 0 200 0\nv 0 0 200\nv 200 200 0\nv 200 0 200\nv 0 200 200\n"
               "v 200 200 200\nv 33.3 0.1 7\n");
  const std::string body = hull("file = 'cube \"1\".obj'\nfile_unit_m = 0.001\nmass_kg = 2\n");
  folder.write("x.toml", body + body + hull("file = 'cube \"1\".obj'\nfile_unit_m = 0.01\nmass_kg = 2") + kProxy);
  const auto loaded = load_scene(folder.path / "x.toml");
  INFO(loaded.message());
  REQUIRE(loaded.ok());
  const Scene& scene = loaded.value();
  REQUIRE(scene.hulls.size() == 2);
  CHECK(scene.bodies[1].shape == scene.bodies[2].shape);
  CHECK(scene.hulls[1].volume == Approx(8.0).epsilon(1e-9));

  std::filesystem::remove(folder.path / "cube \"1\".obj");
  const auto again = parse_scene(scene.source, "y");
  INFO(again.message() << scene.source);
  REQUIRE(again.ok());
  REQUIRE(again.value().hulls.size() == 2);
  CHECK(again.value().hulls == scene.hulls);
  CHECK(again.value().source == scene.source);
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) CHECK(again.value().bodies[k].motion == scene.bodies[k].motion);
}

TEST_CASE("Every mistake in a hull says what is wrong and what would do") {
  CHECK_THAT(wrong(hull("mass_kg = 1\n")), Contains("points_m: missing"));
  CHECK_THAT(wrong(hull("points_m = 3\nmass_kg = 1\n")), Contains("x.toml:3:12") && Contains("not an array"));
  CHECK_THAT(wrong(hull("points_m = []\nmass_kg = 1\n")), Contains("0 points make no solid"));
  CHECK_THAT(wrong(hull("points_m = [[0, 0, 0], [1, 2]]\nmass_kg = 1\n")),
             Contains("x.toml:3:24: [body.1] points_m: an array of 2 is not a place"));
  CHECK_THAT(wrong(hull("points_m = [[0, 0, nan], [1, 2, 3]]\nmass_kg = 1\n")), Contains("is not a place"));
  CHECK_THAT(wrong(hull("points_m = [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]\nmass_kg = 1\n")),
             Contains("lie in a plane") && Contains("at least 0.0001 m thick"));
  CHECK_THAT(wrong(hull("points_m = [[0,0,0],[5000,0,0],[0,1,0],[1,1,1]]\nmass_kg = 1\n")),
             Contains("has a point at [5000, 0, 0] m"));
  CHECK_THAT(wrong(hull("file = \"x.obj\"\nmass_kg = 1\n")), Contains("only a scene that is a file itself"));
  CHECK_THAT(wrong(hull("file = \"x.obj\"\nmass_kg = 1\n" + kCube)), Contains("there is a file already"));
  CHECK_THAT(wrong(hull(kCube + "file_unit_m = 1\nmass_kg = 1\n")), Contains("there is no file"));
  CHECK_THAT(wrong("[[body]]\nshape = \"torus\"\n"),
             Contains("\"torus\" is not known") &&
                 Contains("box, sphere, capsule, cylinder, cone, hull, compound, plane, mesh"));

  const Folder folder;
  const auto loading = [&](const std::string& keys) {
    folder.write("x.toml", hull(keys + "mass_kg = 1\n") + kProxy);
    const auto scene = load_scene(folder.path / "x.toml");
    REQUIRE_FALSE(scene.ok());
    return scene.message();
  };
  CHECK_THAT(loading("file = \"none.stl\"\n"),
             Contains("x.toml:3:8: [body.1] file: ") && Contains("there is no such file"));
  CHECK_THAT(loading("file = \"x.toml\"\n"), Contains("ends in .obj or .stl"));
  folder.write("bad.obj", "v 0 0 0\nv 1 x 0\n");
  CHECK_THAT(loading("file = \"bad.obj\"\n"), Contains("bad.obj:2: \"x\" in y"));
  folder.write("ball.obj", [] {
    std::string text;
    for (int k = 0; k < 100; ++k) {
      const auto [s, c] = sin_cos(2.399963 * k);
      const double z = 1 - (2 * k + 1) / 100.0, r = std::sqrt(1 - z * z);
      text += fmt::format("v {} {} {}\n", r * c, r * s, z);
    }
    return text;
  }());
  CHECK_THAT(loading("file = \"ball.obj\"\n"),
             Contains("the hull has 100 vertices; accepted: at most 64") && Contains("coarser"));
}

namespace {

// Solid shapes as OBJ text, outward faces.
std::string obj_box(const Vec3d& low, const Vec3d& high, unsigned first, bool lid = true) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += fmt::format("v {} {} {}\n", (i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                        (i & 4) != 0 ? high.z : low.z);
  const auto face = [&](unsigned a, unsigned b, unsigned c, unsigned d) {
    text += fmt::format("f {} {} {} {}\n", a + first, b + first, c + first, d + first);
  };
  face(1, 3, 4, 2);
  face(1, 2, 6, 5);
  face(3, 7, 8, 4);
  face(1, 5, 7, 3);
  face(2, 4, 8, 6);
  if (lid) face(5, 6, 8, 7);
  return text;
}

std::vector<std::string> warnings_for(const std::string& obj, const std::string& keys = "file_unit_m = 0.001\n") {
  const Folder folder;
  folder.write("shape.obj", obj);
  folder.write("x.toml", hull("file = \"shape.obj\"\nmass_kg = 1\n" + keys) + kProxy);
  text::Diagnostics found;
  const auto scene = load_scene(folder.path / "x.toml", &found);
  INFO(scene.message());
  REQUIRE(scene.ok());
  // What is taken from the tape is not compared again.
  text::Diagnostics again;
  REQUIRE(parse_scene(scene.value().source, "y", &again).ok());
  CHECK(again.warnings.empty());
  std::vector<std::string> list;
  for (const auto& w : found.warnings) list.push_back(fmt::format("{}:{} {}; {}", w.line, w.where, w.what, w.accepted));
  return list;
}

}  // namespace

TEST_CASE("A convex closed file is taken as a hull without a word, and so are corners alone") {
  CHECK(warnings_for(obj_box({0, 0, 0}, {100, 60, 30}, 0)).empty());
  CHECK(warnings_for("v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\n").empty());
}

TEST_CASE("The largest gap between a file's surface and its hull is reported, in mm, with its place") {
  // Two cubes of 20 mm, 60 mm apart: in the middle of the hull's sides the nearest surface is 30 mm away.
  const auto apart = warnings_for(obj_box({0, 0, 0}, {20, 20, 20}, 0) + obj_box({80, 0, 0}, {100, 20, 20}, 8));
  REQUIRE(apart.size() == 1);
  CHECK_THAT(apart[0], Contains("3:[body.1] file is not convex") && Contains("up to 30 mm, at [0.05, ") &&
                           Contains("several bodies"));
  // A change of 40 x 40 mm from a corner of a cube of 100 mm: the corner inside is 40 / sqrt 2 mm below the hull.
  const auto change = warnings_for(
      "v 0 0 0\nv 100 0 0\nv 100 60 0\nv 60 60 0\nv 60 100 0\nv 0 100 0\n"
      "v 0 0 100\nv 100 0 100\nv 100 60 100\nv 60 60 100\nv 60 100 100\nv 0 100 100\n"
      "f 1 6 5 4\nf 1 4 3 2\nf 7 8 9 10\nf 7 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 "
      "1 7 12\n");
  REQUIRE(change.size() == 1);
  CHECK_THAT(change[0], Contains("up to 28.3 mm, at [0.06, 0.06, "));
}

TEST_CASE("A file whose surface is open is said to be open, with what the hull closes") {
  // A box of 100 x 60 x 30 mm without its lid: the middle of the lid is 30 mm from the walls and from the bottom.
  const auto open = warnings_for(obj_box({0, 0, 0}, {100, 60, 30}, 0, false));
  REQUIRE(open.size() == 2);
  CHECK_THAT(open[0] + open[1], Contains("its surface is open: it ends at 4 edges") && Contains("up to 30 mm"));
  const auto broken = warnings_for(obj_box({0, 0, 0}, {100, 60, 30}, 0) + "f 1 2 99\n");
  REQUIRE(broken.size() == 1);
  CHECK_THAT(broken[0], Contains("its hull is not compared with its triangles") && Contains(":15: \"99\" is none of"));
}

TEST_CASE("a hull has the centre of mass and the moments that its body gives, and stays where it is") {
  const std::string own =
      "mass_kg = 2\ncentre_of_mass_m = [0.05, 0.12, 0.1]\ninertia_kg_m2 = [0.02, 0.03, 0.04, 0.001, -0.002, 0.003]\n";
  const Scene scene = good(hull(kCube + own + "position_m = [1, 2, 3]\n"));
  const auto& body = scene.bodies[1];
  CHECK(norm(body.motion.pose.position - Vec3d{1.05, 2.12, 3.1}) < 1e-12);
  // The matrix back from the principal moments, one entry of each kind.
  const auto entry = [&body](const Vec3d& u, const Vec3d& v) {
    const Vec3d in_body = rotate_inverse(body.motion.pose.rotation, v);
    return dot(rotate_inverse(body.motion.pose.rotation, u), scale(body.inertia, in_body));
  };
  CHECK(entry({1, 0, 0}, {1, 0, 0}) == Approx(0.02).epsilon(1e-9));
  CHECK(entry({0, 0, 1}, {0, 0, 1}) == Approx(0.04).epsilon(1e-9));
  CHECK(entry({1, 0, 0}, {0, 0, 1}) == Approx(-0.002).epsilon(1e-8));
  const physics::Hull& used = scene.hulls[body.shape.index];
  for (std::uint32_t i = 0; i < used.topology.vertices; ++i) {
    const Vec3d corner = body.motion.pose.position + rotate(body.motion.pose.rotation, used.vertex(i)) - Vec3d{1, 2, 3};
    for (int axis = 0; axis < 3; ++axis) CHECK(std::min(std::abs(corner[axis]), std::abs(corner[axis] - 0.2)) < 1e-12);
  }
  // A box may have moments, not products, and what no rigid body has is refused.
  const std::string box = "[[body]]\nshape = \"box\"\nsize_m = [1, 1, 1]\nmass_kg = 1\ninertia_kg_m2 = ";
  CHECK(good(box + "[0.1, 0.2, 0.25]\n").bodies[1].inertia.z == 0.25);
  CHECK_THAT(wrong(box + "[0.1, 0.2, 0.25, 0.01, 0, 0]\n"), Contains("turned axes of inertia need a hull"));
  CHECK_THAT(wrong(box + "[0.1, 0.1, 0.3]\n"), Contains("no rigid body has these moments"));
  CHECK_THAT(wrong(box + "[0.1, 0.1]\n"), Contains("is no list of moments"));
  CHECK_THAT(wrong(hull(kCube + "mass_kg = 1\ncentre_of_mass_m = [0.3, 0, 0]\ninertia_kg_m2 = [1, 1, 1]\n")),
             Contains("is not inside the hull"));
  CHECK_THAT(wrong(hull(kCube + "mass_kg = 1\ncentre_of_mass_m = [0.1, 0.1, 0.1]\n")),
             Contains("no moments of inertia about it"));
}
