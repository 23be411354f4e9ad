// Hard cases of impacts, initial overlaps, chains of falling bodies, and bodies added and removed.
#include <algorithm>
#include <cmath>

#include "rt/base/check.h"
#include "sim/geometry/mesh_builder.h"
#include "sim/loader/generators.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

// A ball at 10 m/s on a plate of 2 mm. Contacts have no restitution.
Outcome impact_on_a_plate(const Setting& setting) {
  CaseWorld world(setting);
  world.settings.gravity = {};
  world.add(physics::make_fixed_body(kGround, physics::Shape::box({0.1, 0.1, 0.001}), 0.5, {{0, 0, -0.001}, {}}));
  const double radius = 0.01, mass = 0.2;
  world.add_sphere(0, radius, mass, 0.5, {0, 0, 0.1034}, {0, 0, -10});
  const double energy = world.world.kinetic_energy();
  double deepest = 0, rebound = 0, most_energy = 0;
  for (int k = world.steps_in(0.2); k > 0; --k) {
    world.step();
    deepest = std::max({deepest, radius - world.position(0).z, world.report.deepest_m});
    rebound = std::max(rebound, world.velocity(0).linear.z);
    most_energy = std::max(most_energy, world.world.kinetic_energy());
  }
  Outcome outcome;
  outcome.at_most("deepest overlap, m", deepest, 0.5e-3);
  outcome.at_most("speed away from the plate, m/s", rebound, 1e-9);
  outcome.at_most("gain of kinetic energy, J", most_energy - energy, 1e-9);
  outcome.holds("does not pass", world.position(0).z > 0.9 * radius);
  world.close(outcome);
  return outcome;
}

// A rod that touches at an angle at which rigid friction has no solution: tan 2, mu above 4/3.
Outcome painleve_rod(const Setting& setting) {
  Outcome outcome;
  double most_speed = 0, gain = 0;
  for (const double friction : {1.5, 1.75, 2.0}) {
    CaseWorld world(setting);
    world.add_ground(kGround, friction);
    const double angle = std::atan(2.0), half = 0.5;
    const Quatd tilt = quat_from_rotation_vector(Vec3d{0, angle, 0});  // x axis points down and forward
    world.add_box(0, {half, 0.005, 0.005}, 1, friction, {{0, 0, half * std::sin(angle) + 0.0025}, tilt},
                  {{3, 0, 0}, {}});
    const double energy = world.world.kinetic_energy() + world.world.potential_energy(world.settings.gravity);
    for (int k = world.steps_in(2); k > 0; --k) {
      world.step();
      most_speed = std::max(most_speed, norm(world.velocity(0).linear));
      gain =
          std::max(gain, world.world.kinetic_energy() + world.world.potential_energy(world.settings.gravity) - energy);
    }
    const std::uint64_t last = outcome.hash;
    world.close(outcome);
    outcome.hash ^= last;
  }
  // Falling by its own half length adds at most g x half to v^2 / 2.
  outcome.at_most("fastest, m/s", most_speed, std::sqrt(9 + 2 * kGravity * 0.5));
  outcome.at_most("gain of energy, J", gain, 1e-6);
  return outcome;
}

Outcome spawned_overlap(const Setting& setting) {
  CaseWorld world(setting);
  world.settings.gravity = {};
  world.add_sphere(0, 0.05, 0.3, 0.5, {0, 0, 0});
  world.add_sphere(1, 0.05, 0.3, 0.5, {0.09, 0, 0});
  double most = 0, apart = 0.09, fastest = 0;
  for (int k = world.steps_in(0.5); k > 0; --k) {
    world.step();
    most = std::max(most, world.world.kinetic_energy());
    const double now = world.position(1).x - world.position(0).x;
    fastest = std::max(fastest, (now - apart) / world.settings.dt);
    apart = now;
  }
  const double push = world.settings.max_push_speed;
  Outcome outcome;
  outcome.at_most("kinetic energy, J", most, 0.5 * 0.6 * push * push);
  outcome.at_most("pushed out at, m/s", fastest, push * (1 + 1e-9));
  outcome.near("ends apart by, m", apart, 0.1, 2e-5);
  world.close(outcome);
  return outcome;
}

// Expected duration of the wave: the same model in steps of 1/16 ms with 4 sub-steps.
constexpr double kDominoWave_s = 1.38875;

Outcome domino_chain(const Setting& setting) {
  sim::DominoRowSpec spec;
  spec.count = 50;
  spec.friction = 0.5;
  CaseWorld world(setting, 1000,
                  {.bodies = 64, .fixed_bodies = 4, .pairs = 1024, .contacts = 512, .border_contacts = 0});
  world.add_ground(kGround, 0.5);
  sim::Bodies dominoes = sim::make_domino_row(spec);
  for (std::size_t k = 0; k < dominoes.size(); ++k) {
    dominoes[k].id = static_cast<BodyId>(k);
    world.add(dominoes[k]);
  }
  world.run(0.2);
  world.velocity(0).angular.y = 6;
  world.velocity(0).linear.x = 6 * 0.5 * spec.domino_m.z;
  double first = -1, last = -1;
  for (int k = 0; k < world.steps_in(4); ++k) {
    world.step();
    const double time = k * setting.step_s;
    if (first < 0 && tilt_of(world.body(5).motion.pose.rotation) > 0.2) first = time;
    if (last < 0 && tilt_of(world.body(45).motion.pose.rotation) > 0.2) last = time;
  }
  int fallen = 0;
  for (const auto& body : world.world.bodies()) fallen += tilt_of(body.motion.pose.rotation) > 0.5;
  Outcome outcome;
  outcome.relative("dominoes fallen", fallen, spec.count, 0);
  outcome.relative("from the 5th to the 45th, s", last - first, kDominoWave_s, 0.02);
  world.close(outcome);
  return outcome;
}

// Removes bodies that support a heap, and inserts bodies that overlap others.
Outcome come_and_go(const Setting& setting) {
  CaseWorld world(setting);
  world.add_ground(kGround, 0.5);
  for (BodyId id = 0; id < 8; ++id) world.add_box(id, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.05 + 0.1 * id}, {}});
  world.run(1);
  world.energy_is_checked = false;  // the case itself adds and removes energy
  double fastest = 0;
  for (int round = 0; round < 40; ++round) {
    const BodyId id = static_cast<BodyId>((round * 5) % 8);
    const physics::Body taken = world.body(id);
    world.world.remove(id);
    world.run(0.02);
    auto back = taken;
    back.motion.velocity = {};
    world.add(back);
    world.run(0.03);
    fastest = std::max(fastest, world.fastest());
  }
  Outcome outcome;
  // Bound: a fall of 0.8 m. It covers a cube's fall for 20 ms, the push speed of overlaps and a collapse of the heap.
  outcome.at_most("fastest, m/s", fastest, std::sqrt(2 * kGravity * 0.8));
  world.run(3);
  outcome.at_most("speed at the end, m/s", world.fastest(), 1e-3);
  world.close(outcome);
  return outcome;
}

// A mesh with the defects that a file may contain: triangles of zero area, duplicates, a needle, a corner on an edge,
// and a patch facing down. A box and a ball slide over it.
sim::TriangleSoup bad_grid() {
  sim::TriangleSoup soup;
  constexpr unsigned kCells = 12;
  constexpr double kCell_m = 0.05;
  const auto corner = [&](double x, double y) {
    soup.corners.push_back({x, y, 0});
    return static_cast<unsigned>(soup.corners.size() - 1);
  };
  for (unsigned j = 0; j < kCells; ++j)
    for (unsigned i = 0; i < kCells; ++i) {
      const double x = (i - 0.5 * kCells) * kCell_m, y = (j - 0.5 * kCells) * kCell_m;
      const unsigned a = corner(x, y), b = corner(x + kCell_m, y), c = corner(x + kCell_m, y + kCell_m),
                     d = corner(x, y + kCell_m);
      if ((i + j) % 5 == 0) {  // a corner on an edge that its neighbour does not have, beside a needle
        const unsigned m = corner(x + 0.5 * kCell_m, y), needle = corner(x + 0.5 * kCell_m, y + 5e-8);
        soup.triangles.push_back({a, m, d});
        soup.triangles.push_back({m, c, d});
        soup.triangles.push_back({m, b, c});
        soup.triangles.push_back({a, m, needle});
      } else {
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
      }
      if ((i * 7 + j) % 6 == 0) {
        soup.triangles.push_back({a, b, b});
        soup.triangles.push_back({a, b, c});
      }
    }
  const double y = -0.5 * kCells * kCell_m;
  const unsigned a = corner(y, y), b = corner(y + kCell_m, y), c = corner(y, y + kCell_m);
  soup.triangles.push_back({a, c, b});  // facing down, in place of the first cell
  return soup;
}

Outcome bad_mesh(const Setting& setting) {
  auto made = sim::build_mesh(sim::weld(bad_grid()), physics::kFirstPatchId);
  TACTUS_CHECK(made.ok(), 0, 0);
  const physics::Mesh meshes[] = {made.value().mesh};
  physics::Capacities capacities;
  capacities.mesh_triangles = 4096;
  CaseWorld world(setting, 1000, capacities, {{}, meshes, {}});
  world.add(physics::make_fixed_body(kGround, physics::Shape::mesh(meshes[0].half_extents, 0), 0.1,
                                     made.value().given_from_body));
  world.add_box(0, {0.03, 0.02, 0.01}, 0.2, 0.1, {{-0.1, 0.013, 0.01}, quat_from_rotation_vector(Vec3d{0, 0, 0.3})});
  world.add_sphere(1, 0.02, 0.2, 0.1, {-0.15, -0.083, 0.02});
  world.run(0.5);
  world.velocity(0).linear.x = 0.6;
  world.velocity(1).linear.x = 0.5;
  double bump = 0;
  for (int k = world.steps_in(0.4); k > 0; --k) {
    world.step();
    bump = std::max({bump, std::abs(world.velocity(0).linear.z), std::abs(world.velocity(1).linear.z)});
  }
  Outcome outcome;
  outcome.at_most("speed up or down while it slides, m/s", bump, 1e-3);
  outcome.holds("slid", world.position(1).x > -0.05);
  world.close(outcome);
  return outcome;
}

}  // namespace

std::vector<HardCase> impact_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms.
  return {
      {15, "rod at an angle without a rigid solution", true, painleve_rod},
      {17, "10 m/s on a plate of 2 mm", true, impact_on_a_plate},
      {20, "sliding over a mesh of bad triangles", true, bad_mesh},
      {22, "fifty dominoes", true, domino_chain},
      {39, "starts 10 mm deep in another", true, spawned_overlap},
      {43, "bodies that come and go", true, come_and_go},
  };
}

}  // namespace tactus::hard_cases
