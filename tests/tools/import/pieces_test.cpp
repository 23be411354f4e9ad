// Concave solids in convex pieces: a bowl, a cup with a handle, a ring, a gear; what rests in them and goes through
// them.
#include <random>
#include <regex>

#include "tactus/tactus.h"
#include "tests/tools/import/import_bench.h"
#include "tools/import/pieces.h"
#include "tools/import/solid_distance.h"

using namespace tactus;
using namespace tactus::test;
using namespace tactus::scene_import;
using Catch::Matchers::Contains;

namespace {

struct RadiusHeight {
  double r, z;
};

// A solid of revolution about z; its section is inside to the left of the profile's direction. r = 0 is one corner.
sim::TriangleSoup turned(const std::vector<RadiusHeight>& profile, unsigned segments, bool closed) {
  sim::TriangleSoup soup;
  std::vector<std::vector<std::uint32_t>> rings;
  for (const auto& [r, z] : profile) {
    std::vector<std::uint32_t> ring;
    for (unsigned i = 0; i < segments; ++i) {
      if (r > 0 || i == 0) {
        const double angle = 2 * kPi * i / segments;
        soup.corners.push_back({r * std::cos(angle), r * std::sin(angle), z});
      }
      ring.push_back(static_cast<std::uint32_t>(soup.corners.size() - 1));
    }
    rings.push_back(std::move(ring));
  }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) soup.triangles.push_back({a, b, c});
  };
  for (std::size_t k = 0; k + (closed ? 0 : 1) < rings.size(); ++k) {
    const auto &low = rings[k], &high = rings[(k + 1) % rings.size()];
    for (unsigned i = 0; i < segments; ++i) {
      const unsigned next = (i + 1) % segments;
      add(low[i], low[next], high[next]);
      add(low[i], high[next], high[i]);
    }
  }
  return soup;
}

// Foot of radius 30 mm, rim of 60 mm; the hollow is a part of a sphere of 70 mm, its lowest point 6 mm up.
sim::TriangleSoup bowl(unsigned segments) {
  std::vector<RadiusHeight> profile{{0, 0}, {0.03, 0}, {0.066, 0.04}};
  for (int i = 6; i >= 1; --i) {
    const double angle = 0.17 * i;
    profile.push_back({0.07 * std::sin(angle), 0.006 + 0.07 * (1 - std::cos(angle))});
  }
  profile.push_back({0, 0.006});
  return turned(profile, segments, false);
}

sim::TriangleSoup ring(unsigned segments) {
  return turned({{0.03, 0}, {0.05, 0}, {0.05, 0.02}, {0.03, 0.02}}, segments, true);
}

// A disc with square teeth and a bore: a ring whose outer corners are at two radii by turns.
sim::TriangleSoup gear() {
  sim::TriangleSoup soup = ring(48);
  for (std::size_t i = 0; i < 48; ++i)
    if (i % 4 < 2)
      for (const std::size_t at : {48 + i, 96 + i}) {
        soup.corners[at].x *= 1.2;
        soup.corners[at].y *= 1.2;
      }
  return soup;
}

void add(const sim::TriangleSoup& part, const Vec3d& at, sim::TriangleSoup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.corners.size());
  for (const Vec3d& corner : part.corners) soup.corners.push_back(corner + at);
  for (const auto& t : part.triangles) soup.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

// Wall of 4 mm, floor of 5 mm; the handle is a ring that goes into the wall.
sim::TriangleSoup cup() {
  sim::TriangleSoup soup =
      turned({{0, 0}, {0.04, 0}, {0.04, 0.09}, {0.036, 0.09}, {0.036, 0.005}, {0, 0.005}}, 16, false);
  sim::TriangleSoup handle = turned({{0.015, -0.004}, {0.022, -0.004}, {0.022, 0.004}, {0.015, 0.004}}, 12, true);
  for (Vec3d& corner : handle.corners) corner = {corner.x, -corner.z, corner.y};
  add(handle, {0.053, 0, 0.045}, soup);
  return soup;
}

std::string obj_of(const sim::TriangleSoup& soup) {
  std::string text;
  for (const Vec3d& c : soup.corners) text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", c.x, c.y, c.z);
  for (const auto& t : soup.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

struct Surface {
  std::vector<sim::TriangleSoup> pieces;
  double volume_m3{0};
};

Surface surface_of_all(const Pieces& pieces) {
  Surface out;
  for (const HullPoints& hull : pieces.hulls) {
    auto surface = surface_of(hull.points);
    REQUIRE(surface.ok());
    out.volume_m3 += solid_of(surface.value()).mass;
    out.pieces.push_back(std::move(surface).value());
  }
  return out;
}

double depth_outside(const Vec3d& p, const sim::TriangleSoup& convex) {
  double most = -1;
  for (const auto& t : convex.triangles) {
    const Vec3d &a = convex.corners[t[0]], &b = convex.corners[t[1]], &c = convex.corners[t[2]];
    const Vec3d normal = normalized_or(cross(b - a, c - a), Vec3d{});
    most = std::max(most, dot(normal, p - a));
  }
  return most;
}

Vec3d on_triangle(const sim::TriangleSoup& soup, const std::array<std::uint32_t, 3>& t, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const double r = std::sqrt(share(random)), s = share(random);
  return (1 - r) * soup.corners[t[0]] + r * (1 - s) * soup.corners[t[1]] + r * s * soup.corners[t[2]];
}

// The pieces are as near to the solid as they say, on random points of both; volumes agree likewise.
void check_near(const sim::TriangleSoup& solid, const Pieces& pieces) {
  const Surface surface = surface_of_all(pieces);
  const SolidDistance distance(solid);
  std::mt19937 random(3);
  double uncovered = 0, beyond = 0, area = 0;
  for (const auto& t : solid.triangles) {
    area += 0.5 * norm(cross(solid.corners[t[1]] - solid.corners[t[0]], solid.corners[t[2]] - solid.corners[t[0]]));
    for (int i = 0; i < 5; ++i) {
      const Vec3d p = on_triangle(solid, t, random);
      double least = 1;
      for (const auto& piece : surface.pieces) least = std::min(least, depth_outside(p, piece));
      uncovered = std::max(uncovered, least);
    }
  }
  for (const auto& piece : surface.pieces)
    for (const auto& t : piece.triangles)
      for (int i = 0; i < 30; ++i) {
        const Vec3d p = on_triangle(piece, t, random);
        if (!distance.is_inside(p)) beyond = std::max(beyond, distance.nearest(p).distance_m);
      }
  CHECK(beyond <= pieces.deviation_m + 1e-9);
  CHECK(uncovered <= std::max(pieces.deviation_m, 1e-6));
  const double volume = solid_of(solid).mass;
  CHECK(surface.volume_m3 > (1 - 1e-4) * volume);
  CHECK(surface.volume_m3 < volume + area * pieces.deviation_m);
}

// The state of the scene's last body after `seconds`.
Vector3 last_after(const std::filesystem::path& file, double seconds) {
  Session session;
  const Error error = session.open(file, Options{});
  INFO(error.message());
  REQUIRE_FALSE(error);
  REQUIRE_FALSE(session.step(static_cast<std::uint64_t>(1000 * seconds)));
  return session.bodies().back().position_m;
}

}  // namespace

TEST_CASE("a bowl, a cup with a handle, a ring and a gear are divided as near as is wanted, in few pieces") {
  const sim::TriangleSoup bowl_of_16 = bowl(16), ring_of_24 = ring(24), cup_of_16 = cup(), gear_of_12 = gear();
  struct Case {
    const char* name;
    const sim::TriangleSoup& solid;
    double deviation_m;
    std::size_t most;
  };
  for (const Case& c : {Case{"bowl", bowl_of_16, 1e-3, 80}, Case{"bowl, roughly", bowl_of_16, 4e-3, 32},
                        Case{"ring", ring_of_24, 1e-4, 24}, Case{"ring, roughly", ring_of_24, 2e-3, 16},
                        Case{"gear", gear_of_12, 1e-3, 48}}) {
    CAPTURE(c.name);
    REQUIRE(open_edges(c.solid) == 0);
    const auto pieces = decompose(c.solid, 128, c.deviation_m);
    REQUIRE(pieces.ok());
    CHECK(pieces.value().deviation_m <= c.deviation_m);
    CHECK(pieces.value().hulls.size() <= c.most);
    check_near(c.solid, pieces.value());
  }
  // Two shells that overlap, as many programs write a cup and its handle; volumes would count the overlap twice.
  const auto pieces = decompose(cup_of_16, 40, 1e-3);
  REQUIRE(pieces.ok());
  CHECK(pieces.value().deviation_m <= 2e-3);
  CHECK(pieces.value().hulls.size() <= 40);
  // Through the handle and in the cup there is nothing.
  const Surface surface = surface_of_all(pieces.value());
  for (const Vec3d& hollow : {Vec3d{0.053, 0, 0.045}, Vec3d{0, 0, 0.05}, Vec3d{0.03, 0, 0.01}})
    for (const auto& piece : surface.pieces) CHECK(depth_outside(hollow, piece) > 1e-3);
}

TEST_CASE("the same mesh gives the same pieces, and too few pieces give a larger deviation, which is said") {
  const sim::TriangleSoup solid = bowl(12);
  const auto first = decompose(solid, 12, 1e-3), second = decompose(solid, 12, 1e-3);
  REQUIRE((first.ok() && second.ok()));
  REQUIRE(first.value().hulls.size() == second.value().hulls.size());
  for (std::size_t i = 0; i < first.value().hulls.size(); ++i)
    CHECK(first.value().hulls[i].points == second.value().hulls[i].points);
  CHECK(first.value().hulls.size() <= 12);
  CHECK(first.value().deviation_m > 1e-3);
  check_near(solid, first.value());
}

TEST_CASE("a hollow that no opening shows stays hollow") {
  sim::TriangleSoup solid{{}, {}};
  const auto box = [](double half, bool inward) {
    sim::TriangleSoup out = turned({{0, -half}, {half, -half}, {half, half}, {0, half}}, 4, false);
    if (inward)
      for (auto& t : out.triangles) std::swap(t[1], t[2]);
    return out;
  };
  add(box(0.05, false), {}, solid);
  add(box(0.04, true), {}, solid);
  const auto pieces = decompose(solid, 32, 1e-3);
  REQUIRE(pieces.ok());
  for (const auto& piece : surface_of_all(pieces.value()).pieces) CHECK(depth_outside({}, piece) > 0.02);
}

TEST_CASE("a ball rests at the bottom of an imported bowl, within the deviation") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const sim::TriangleSoup solid = bowl(16);
  auto options = options_for(scratch.write("bowl.obj", obj_of(solid)));
  options.proxy_position = Vec3d{0, 5, 5};
  auto made = imported(options);
  const std::string changed = fmt::format("{}", fmt::join(made.account.changed, "\n"));
  CHECK_THAT(changed, Contains("convex pieces, at most "));
  const double deviation_m = 1e-3 * std::stod(changed.substr(changed.find("at most ") + 8));
  CHECK(deviation_m <= 1.2e-3);  // 64 pieces
  check_near(solid, decompose(solid, kDefaultPieces, 1e-3).value());
  const auto scene = loaded(made);
  const MassProperties exact = solid_of(solid), own = mass_of(scene.bodies[1]);
  CHECK(own.mass == Approx(1000 * exact.mass).epsilon(1e-5));
  CHECK(norm(own.centre - exact.centre) < 1e-7);
  CHECK(largest_difference(own.inertia, scaled(1000, exact.inertia)) < 1e-5 * trace(own.inertia));

  options.pieces = {4, 1e-3};
  CHECK_THAT(refusal(options),
             Contains("bowl.obj: ") && Contains("its 4 pieces are up to ") && Contains("; accepted: more --pieces"));

  constexpr double kBall_m = 0.012;
  made.files.text += fmt::format(
      "\n[[body]]\nshape = \"plane\"\nfriction = 0.5\n\n[[body]]\nshape = \"sphere\"\nradius_m = {}\nmass_kg = 0.02\n"
      "friction = 0.5\nposition_m = [0.02, 0.01, 0.06]\n",
      kBall_m);
  const Vector3 at = last_after(written(made, scratch), 20);  // it rolls to and fro: nothing resists its rolling
  CHECK(std::hypot(at[0], at[1]) < 0.012);
  // On the mesh itself, at that place: the lowest height at which the ball does not overlap. The floor's slope there is
  // at most 0.012 / (0.07 - 0.012), so a deviation raises the ball by 1.03 times as much at most.
  const SolidDistance distance(solid);
  double low = 0.006, high = 0.05;
  for (int i = 0; i < 40; ++i) {
    const double z = 0.5 * (low + high);
    (distance.nearest({at[0], at[1], z}).distance_m < kBall_m ? low : high) = z;
  }
  CHECK(at[2] > high - 1e-4);
  CHECK(at[2] < high + 1.03 * deviation_m + 1e-4);
}

TEST_CASE("a peg falls through an imported ring, and a thicker one does not") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  auto options = options_for(scratch.write("ring.obj", obj_of(ring(24))));
  options.proxy_position = Vec3d{0, 5, 5};
  auto made = imported(options);
  // The ring never moves here.
  made.files.text = std::regex_replace(
      made.files.text, std::regex("(shape = \"compound\"\n)mass_kg[^\n]*\ninertia[^\n]*\ncentre[^\n]*\n"),
      "$1fixed = true\nposition_m = [0, 0, 0.5]\n");
  made.files.text = std::regex_replace(made.files.text, std::regex("position_m = \\[0, 0, 0\\]\n"), "");
  const std::string ring_alone = made.files.text;
  const auto drop = [&](double radius_m) {
    made.files.text = ring_alone + fmt::format(
                                       "\n[[body]]\nshape = \"capsule\"\nradius_m = {}\nlength_m = 0.1\n"
                                       "mass_kg = 0.1\nposition_m = [0, 0, 0.6]\n",
                                       radius_m);
    return last_after(written(made, scratch), 0.4)[2];
  };
  // The hollow's narrowest radius is 30 mm x cos(7.5 degrees) = 29.7 mm, less the deviation of 1 mm at most.
  CHECK(drop(0.0285) == Approx(0.6 - 0.5 * 9.81 * 0.4 * 0.4).margin(0.01));
  CHECK(drop(0.0305) > 0.5);
}
