// Meshes in scene files: what a body gets from them, what a tape needs, every mistake with its place, and that the
// triangles of a snapshot are those of the tree.
#include <fmt/format.h>
#include <unistd.h>

#include <fstream>

#include "rt/haptics/coupling/snapshot_bytes.h"
#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"
#include "tests/sim/geometry/mesh_support.h"
#include "tests/sim/global_world_bench.h"

using namespace tactus;
using namespace tactus::sim;
using namespace tactus::sim::support;
using Catch::Matchers::Contains;

namespace {

const std::string kProxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\nposition_m = [5, 5, 5]\n";
const std::string kSquare = "v 0 0 0\nv 200 0 0\nv 200 200 0\nv 0 200 0\nv 100 100 0\n";
const std::string kFaces = "f 1 2 3\nf 1 3 4\n";

std::string mesh(const std::string& keys) { return "[[body]]\nshape = \"mesh\"\n" + keys; }

// A folder with a scene and the files beside it, gone at the end.
struct Folder {
  Folder() : path(std::filesystem::temp_directory_path() / fmt::format("tactus_meshes_{}", ::getpid())) {
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
  Result<Scene> load(const std::string& text) const {
    write("x.toml", text + kProxy);
    return load_scene(path / "x.toml");
  }
  Scene good(const std::string& text) const {
    auto scene = load(text);
    INFO(scene.message());
    REQUIRE(scene.ok());
    return std::move(scene).value();
  }
  std::string wrong(const std::string& text) const {
    const auto scene = load(text);
    REQUIRE_FALSE(scene.ok());
    return scene.message();
  }
  std::filesystem::path path;
};

const haptics::DeviceProperties kDevice{};

}  // namespace

TEST_CASE("a mesh from a file is where its corners are, fixed, and counted by the report") {
  const Folder folder;
  folder.write("a.obj", kSquare + kFaces + "v 0 0 0\nf 6 2 3\nf 1 5 3\n");
  const Scene scene =
      folder.good(mesh("file = \"a.obj\"\nfile_unit_m = 0.001\nposition_m = [1, 2, 3]\n") + mesh("file = \"a.obj\"\n"));
  REQUIRE(scene.meshes.size() == 2);
  const auto& body = scene.bodies[1];
  CHECK(body.kind == physics::BodyKind::kFixed);
  CHECK(body.shape.kind == physics::ShapeKind::kMesh);
  CHECK(norm(body.motion.pose.position - Vec3d{1.1, 2.1, 3}) < 1e-12);
  CHECK(norm(scene.meshes[0].half_extents - Vec3d{0.1, 0.1, 0}) < 1e-12);
  CHECK(norm(scene.meshes[1].half_extents - Vec3d{100, 100, 0}) < 1e-9);
  CHECK(scene.meshes[1].first_patch_id == scene.meshes[0].first_patch_id + scene.meshes[0].patches.size());
  CHECK(scene.mesh_accounts[0].body == 1);
  const auto report = report_on(scene, kDevice, 1e-3);
  CHECK(report.bodies.meshes == 2);
  CHECK_THAT(to_text(report), Contains("2 meshes"));
  CHECK_THAT(to_text(report), Contains("a.obj: 2 triangles, 5 corners, 1 flat patches; 4 open edges; 1 corners merged"
                                       "; 1 triangles without area left out; 1 doubled triangles left out"));
}

TEST_CASE("a body on too many triangles of uneven ground is a problem of the scene, on flat ground it is none") {
  const Folder folder;
  const std::string ground = mesh("file = \"ground.obj\"\n");
  const auto box = [](double height_m) {
    return fmt::format("[[body]]\nshape = \"box\"\nsize_m = [0.1, 0.1, 0.02]\nmass_kg = 1\nposition_m = [0, 0, {}]\n",
                       0.01 + height_m);
  };
  const auto problems_on = [&](double height_m) {
    Random random(8);
    std::string obj;
    const TriangleSoup soup = height_field(
        60, 0.002, [&](double, double) { return random(-height_m, height_m); }, [] { return true; });
    for (const Vec3d& c : soup.corners) obj += fmt::format("v {} {} {}\n", c.x, c.y, c.z);
    for (const auto& t : soup.triangles) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    folder.write("ground.obj", obj);
    auto problems = report_on(folder.good(ground + box(height_m)), kDevice, 1e-3).problems;
    std::erase_if(problems, [](const std::string& text) { return text.find("triangles") == std::string::npos; });
    return problems;
  };
  CHECK(problems_on(0).empty());
  const auto uneven = problems_on(2e-5);
  REQUIRE(uneven.size() == 1);
  CHECK_THAT(uneven[0], Contains("body 2") && Contains("too many triangles of body 1") && Contains("at most 256") &&
                            Contains("flat or of larger triangles"));
}

TEST_CASE("a scene keeps the triangles of its files: its source alone gives the same meshes") {
  const Folder folder;
  Random random(3);
  std::string obj;
  const TriangleSoup soup = height_field(
      6, 37.123, [&](double, double) { return random(0, 5); }, [] { return true; });
  for (const Vec3d& c : soup.corners) obj += fmt::format("v {} {} {}\n", c.x, c.y, c.z);
  for (const auto& t : soup.triangles) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  folder.write("hills.obj", obj);
  const Scene scene = folder.good(mesh("file = \"hills.obj\"\nfile_unit_m = 0.001\n"));
  const auto again = parse_scene(scene.source, "x.toml");
  INFO(again.message());
  REQUIRE(again.ok());
  const auto &a = scene.meshes[0], &b = again.value().meshes[0];
  const auto same = [](auto x, auto y) { return std::equal(x.begin(), x.end(), y.begin(), y.end()); };
  CHECK(same(a.corners, b.corners));
  CHECK(same(a.triangles, b.triangles));
  CHECK(same(a.normals, b.normals));
  CHECK(same(a.order, b.order));
  CHECK(scene.bodies[1].motion.pose == again.value().bodies[1].motion.pose);
  CHECK(again.value().source == scene.source);
}

TEST_CASE("each mistake about a mesh is one line with its place, the key and what is accepted") {
  const Folder folder;
  folder.write("a.obj", kSquare + kFaces);
  folder.write("empty.obj", "");
  folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  folder.write("a.txt", "x");
  const auto file = [](const std::string& name) { return "file = \"" + name + "\"\n"; };
  CHECK_THAT(folder.wrong(mesh("")), Contains("x.toml:1:1: [body.1] file"));
  CHECK_THAT(folder.wrong(mesh(file("b.obj"))),
             Contains("x.toml:3:8: [body.1] file:") && Contains("there is no such file"));
  CHECK_THAT(folder.wrong(mesh(file("a.txt"))), Contains("accepted: a name that ends in .obj or .stl"));
  CHECK_THAT(folder.wrong(mesh(file("empty.obj"))), Contains("holds no triangles"));
  CHECK_THAT(folder.wrong(mesh(file("flat.obj"))), Contains("holds no triangle with an area"));
  CHECK_THAT(folder.wrong(mesh(file("a.obj") + "fixed = false\n")), Contains("a mesh never moves"));
  CHECK_THAT(folder.wrong(mesh(file("a.obj") + "mass_kg = 1\n")), Contains("a mesh never moves, so it has none"));
  CHECK_THAT(folder.wrong(mesh(file("a.obj") + "file_unit_m = 100\n")), Contains("is file_unit_m right?"));
  CHECK_THAT(folder.wrong(mesh(file("a.obj") + "points_m = []\n")), Contains("points_m"));
  CHECK_FALSE(parse_scene(mesh(file("a.obj")) + kProxy, "x.toml").ok());
  const std::string kept = "[[mesh_file]]\nname = \"a.obj\"\ncorners_m = [0, 0, 0, 1, 0, 0, 0, 1, 0]\ntriangles = ";
  CHECK(parse_scene(mesh(file("a.obj")) + kept + "[0, 1, 2]\n" + kProxy, "x.toml").ok());
  for (const char* triangles : {"[0, 1]", "[0, 1, 3]", "[0, 1, 0.5]", "[]", "[0, 1, \"a\"]", "[0, 1, -1]"})
    CHECK_FALSE(parse_scene(mesh(file("a.obj")) + kept + triangles + "\n" + kProxy, "x.toml").ok());
}

TEST_CASE("the triangles of a snapshot are those that the tree finds, and they survive the tape") {
  const auto loaded = load_scene(std::filesystem::path(TACTUS_SOURCE_DIR "/sim/scenes/terrain.toml"));
  INFO(loaded.message());
  REQUIRE(loaded.ok());
  const Scene& scene = loaded.value();
  GlobalWorld global(scene, tactus::test::capped_border());
  const auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  global.first_snapshot(*snapshot);
  REQUIRE(snapshot->near_regions.size() > 0);
  CHECK(snapshot->dropped == 0);
  const physics::NearTriangles near{snapshot->near_regions.span(), snapshot->near_triangles.span()};
  Random random(1);
  std::size_t triangles = 0;
  for (const auto& region : snapshot->near_regions) {
    const Vec3d size = region.box.upper - region.box.lower;
    for (int n = 0; n < 50; ++n) {
      // Some inside the region, some across its rim: both ways must give the same.
      const Vec3d at = region.box.lower + Vec3d{random(0, 1) * size.x, random(0, 1) * size.y, random(0, 1) * size.z};
      const Vec3d half = size * random(0.01, 0.4);
      const physics::Aabb box{at - half, at + half};
      physics::TriangleList from_list, from_tree;
      near.find(scene.meshes[0], region.body, 0, box, from_list);
      find_triangles(scene.meshes[0], box, from_tree);
      REQUIRE(std::vector<std::uint32_t>(from_list.triangles.begin(), from_list.triangles.end()) ==
              std::vector<std::uint32_t>(from_tree.triangles.begin(), from_tree.triangles.end()));
      triangles += from_list.triangles.size();
    }
  }
  CHECK(triangles > 0);

  std::vector<std::byte> bytes(haptics::snapshot_bytes_bound());
  ByteWriter out(bytes);
  haptics::write_snapshot(out, *snapshot);
  REQUIRE(out.ok());
  const auto again = std::make_unique<haptics::WorldSnapshot>();
  const auto read = [&](physics::Meshes meshes) {
    ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
    return haptics::read_snapshot(in, *again, {scene.hulls, meshes, {}}) && in.remaining() == 0;
  };
  REQUIRE(read(scene.meshes));
  CHECK(std::equal(snapshot->near_triangles.begin(), snapshot->near_triangles.end(), again->near_triangles.begin()));
  CHECK(again->near_regions.size() == snapshot->near_regions.size());
  CHECK_FALSE(read({}));  // a mesh that is not there
}

TEST_CASE("a body that has left its region, or has none, finds the same triangles: a late world changes no bit") {
  const auto scene = load_scene(std::filesystem::path(TACTUS_SOURCE_DIR "/sim/scenes/terrain.toml"));
  REQUIRE(scene.ok());
  const auto final_hash = [&](bool with_regions) {
    physics::Capacities capacities;
    capacities.mesh_triangles = 4096;
    physics::World world(capacities, scene.value().shapes());
    for (const auto& body : scene.value().bodies) world.insert(body);
    std::vector<physics::NearRegion> regions;
    std::vector<std::uint32_t> triangles;
    for (const auto& body : world.bodies()) {  // small: bodies leave them as they roll
      const auto pose = physics::relative_pose(world.fixed_bodies()[0].motion.pose, body.motion.pose);
      const auto box = physics::bounds_of(body.shape, pose, 0.02);
      physics::TriangleList found;
      find_triangles(scene.value().meshes[0], box, found);
      regions.push_back({body.id, 0, static_cast<std::uint32_t>(triangles.size()), found.triangles.size(), box});
      triangles.insert(triangles.end(), found.triangles.begin(), found.triangles.end());
    }
    if (with_regions) world.near_triangles = {regions, triangles};
    physics::StepSettings settings;
    settings.gravity = {0, 0, -9.81};
    for (int i = 0; i < 1500; ++i) {
      world.begin_step(settings);
      find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
      world.finish_step(settings);
    }
    return world.state_hash();
  };
  CHECK(final_hash(true) == final_hash(false));
}
