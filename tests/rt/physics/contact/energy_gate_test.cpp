#include "rt/physics/contact/energy_gate.h"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;
using namespace tactus::physics;

namespace {

constexpr double kMass = 2, kInertia = 0.5, kBlow_m_per_s = 0.05;

// Equal bodies that have already got what was given.
struct Bench {
  std::vector<SolverBody<double>> motion;
  std::vector<SymMat3d> inverse_inertia;
  std::vector<Twistd> given;
  EnergyGate<double> gate{8};

  void add(const Vec3d& before, const Twistd& change) {
    SolverBody<double> body;
    body.inverse_mass = 1 / kMass;
    body.v = before + change.linear;
    body.w = change.angular;
    motion.push_back(body);
    given.push_back(change);
    inverse_inertia.push_back(SymMat3d::identity(1 / kInertia));
  }
  SolverBodies<double> bodies() { return {motion, inverse_inertia}; }
  bool hold_back(std::initializer_list<std::array<std::uint32_t, 2>> links) {
    gate.begin_islands(static_cast<std::uint32_t>(motion.size()));
    for (const auto& link : links) gate.link(bodies(), link[0], link[1]);
    return gate.hold_back(bodies(), given, kBlow_m_per_s);
  }
};

}  // namespace

TEST_CASE("what undoes a motion passes the energy gate to the last bit") {
  Bench bench;
  bench.add({0, 0, -0.3}, {{0, 0, 0.3}, {}});
  bench.add({0, 0, -0.3}, {{0, 0, 0.55}, {}});  // thrown back, with less than it came with
  const auto before = bench.motion;
  CHECK_FALSE(bench.hold_back({{0, 1}}));
  for (std::size_t i = 0; i < 2; ++i) CHECK(bench.motion[i].v == before[i].v);
  CHECK(bench.gate.share(bench.bodies(), 0, 1) == 1);
}

TEST_CASE("what gives energy is scaled to where the energy is smallest: nothing left where it only pushes on") {
  Bench bench;
  bench.add({0, 0, -0.3}, {{0, 0, 0.9}, {}});
  CHECK(bench.hold_back({}));
  CHECK(bench.motion[0].v.z == Approx(0).margin(1e-15));
  CHECK(bench.given[0].linear.z == Approx(0.3));
  CHECK(bench.gate.share(bench.bodies(), 0, 0) == Approx(1.0 / 3));

  Bench onward;
  onward.add({0, 0, 0.3}, {{0, 0, 0.1}, {0, 2, 0}});
  CHECK(onward.hold_back({}));
  CHECK(onward.motion[0].v.z == Approx(0.3));
  CHECK(onward.motion[0].w == Vec3d{});
}

TEST_CASE("the energy gate weighs an island as one, and leaves the next one as it is") {
  Bench bench;
  bench.add({0, 0, -1}, {{0, 0, 0.5}, {}});  // slowed down by pushing the next: together they lose energy
  bench.add({0, 0, 0}, {{0, 0, -0.5}, {}});
  bench.add({0, 0, 0}, {{0, 0, 0.5}, {}});  // pushed apart from rest
  bench.add({0, 0, 0}, {{0, 0, -0.5}, {}});
  CHECK(bench.hold_back({{0, 1}, {2, 3}}));
  CHECK(bench.motion[0].v.z == -0.5);
  CHECK(bench.motion[1].v.z == -0.5);
  CHECK(bench.motion[2].v.z == 0);
  CHECK(bench.motion[3].v.z == 0);
  CHECK(bench.gate.share(bench.bodies(), 0, 1) == 1);
  CHECK(bench.gate.share(bench.bodies(), 2, 3) == 0);
}

TEST_CASE("a body that nothing moves links no islands and takes no part") {
  Bench bench;
  bench.add({0, 0, 0}, {{0, 0, 0.5}, {}});
  bench.add({0, 0, 3}, {{0, 0, 1}, {}});
  bench.motion[1].inverse_mass = 0;
  bench.add({0, 0, -1}, {{0, 0, 1}, {}});
  CHECK(bench.hold_back({{0, 1}, {1, 2}}));
  CHECK(bench.motion[0].v.z == 0);
  CHECK(bench.motion[2].v.z == 0);
  CHECK(bench.gate.share(bench.bodies(), 1, 2) == 1);
  CHECK(bench.gate.share(bench.bodies(), 0, 1) == 0);
}

TEST_CASE("a heap keeps the warm start on which it rests, whatever falls on one body of it") {
  Bench bench;
  for (int i = 0; i < 7; ++i) bench.add({0, 0, 0.01}, {{0, 0, 0.04}, {}});
  bench.add({0, 0, 0}, {{0, 0, -0.06}, {}});
  CHECK_FALSE(bench.hold_back({{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 7}}));
  CHECK(bench.motion[7].v.z == -0.06);
}
