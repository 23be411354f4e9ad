#include "tools/experiment/coupling/coupled_worlds.h"

#include <catch2/catch.hpp>

#include "tests/system/session_bench.h"
#include "tools/experiment/coupling/reference_run.h"
#include "tools/session/find_description.h"
#include "tools/session/session.h"

using namespace tactus;
using namespace tactus::experiment;
using haptics::CouplingScheme;

namespace {

constexpr std::size_t kStart = 400, kTicks = 500;

struct Bench {
  sim::Scene scene = test::scene_text(test::kPressScene);
  hal::DeviceProfile profile = session::find_description(scene.device.profile, {}).value();

  session::RunOptions options(CouplingScheme coupling, unsigned ratio = 8) const {
    auto options = test::virtual_options();
    options.coupling = coupling;
    options.ratio = ratio;
    return options;
  }
  CoupledWorlds worlds(CouplingScheme coupling) const { return {scene, options(coupling), profile.properties}; }
  ScriptedArm arm() const {
    return {profile, session::make_hand(scene),
            session::loop_config(scene, options(CouplingScheme::kDirect), profile.properties).placement, 1e-3};
  }
  ReferenceRun reference() const {
    auto direct = worlds(CouplingScheme::kDirect);
    auto hand = arm();
    const WindowPlace place{kStart, true};
    const unsigned ratio = 8;
    return record_reference(direct, hand, kTicks, {&place, 1}, {&ratio, 1});
  }
};

}  // namespace

TEST_CASE("A direct run that goes on from a keyframe has the force of the run that it was taken from, bit by bit") {
  const Bench bench;
  const ReferenceRun reference = bench.reference();
  auto again = bench.worlds(CouplingScheme::kDirect);
  again.start_from({}, reference.windows[0].now, {});
  bool same = true;
  for (std::size_t k = kStart; k < kTicks; ++k)
    same = same && again.tick(reference.ideal[k]).on_device.force == reference.force[k];
  CHECK(same);
  CHECK(norm(reference.force.back()) > 0.5);  // it is pressing
}

TEST_CASE("A sub-world that has all bodies goes on from a keyframe as the direct run does") {
  const Bench bench;
  const ReferenceRun reference = bench.reference();
  auto sub_world = bench.worlds(CouplingScheme::kSubWorld);
  sub_world.start_from(reference.windows[0].before[0], reference.windows[0].now, reference.mean_on_proxy(kStart, 8));
  double most = 0;
  for (std::size_t k = kStart; k < kTicks; ++k)
    most = std::max(most, norm(sub_world.tick(reference.ideal[k]).on_device.force - reference.force[k]));
  CHECK(most < 1e-12);
  CHECK(sub_world.sub_world().members() == 2);
}

TEST_CASE("In a small scene, bodies that nothing connects to a member move as in the direct run, bit by bit") {
  Bench bench;
  const std::string falling = R"(
[[body]]
shape = "box"
size_m = [0.04, 0.05, 0.06]
mass_kg = 0.3
friction = 0.4
position_m = [1, 0.002, 0.05]
rotation_vector_rad = [0.2, 0.1, 0]
[[body]]
shape = "capsule"
radius_m = 0.01
length_m = 0.05
mass_kg = 0.05
friction = 0.3
position_m = [1.01, 0, 0.12]
rotation_vector_rad = [1.2, 0, 0]
[[body]]
shape = "sphere"
radius_m = 0.004
mass_kg = 0.01
friction = 0.6
position_m = [0.5, 0, 0.004]
velocity_m_per_s = [0.4, 0.3, 0]
[[body]]
shape = "box"
size_m = [0.1, 0.02, 0.1]
mass_kg = 2
friction = 0.5
position_m = [0.7, 0.1, 0.05]
)";
  std::string text = test::kPressScene;
  text.insert(text.find("[hand]"), falling.substr(1));
  bench.scene = test::scene_text(text);
  auto direct = bench.worlds(CouplingScheme::kDirect), sub_world = bench.worlds(CouplingScheme::kSubWorld);
  direct.start_at_rest();
  sub_world.start_at_rest();
  auto hand = bench.arm();
  std::vector<physics::Body> in_direct, in_sub_world;
  bool same = true;
  for (int k = 0; k < 1600; ++k) {
    if (sub_world.at_synchronisation()) {
      direct.bodies(in_direct);
      sub_world.bodies(in_sub_world);
      for (std::size_t i = 2; i < in_direct.size(); ++i) same = same && in_direct[i].motion == in_sub_world[i].motion;
    }
    const haptics::DeviceTarget target = hand.encoded();
    const Wrenchd on_device = direct.tick(target).on_device;
    sub_world.tick(target);
    hand.advance(on_device);
  }
  CHECK(same);
  CHECK(in_direct.size() == 6);
  CHECK(sub_world.sub_world().members() == 2);
  CHECK(norm(in_direct[4].motion.pose.position - Vec3d{0.5, 0, 0.004}) > 0.2);  // the ball rolled, to the upright box
}

TEST_CASE("A proxy a micrometre away is felt by the stiffness of the coupling") {
  const Bench bench;
  const ReferenceRun reference = bench.reference();
  auto apart = bench.worlds(CouplingScheme::kDirect);
  apart.start_from({}, reference.windows[0].now, {}, {1e-6, 0, 0});
  const double first = norm(apart.tick(reference.ideal[kStart]).on_device.force - reference.force[kStart]);
  CHECK(first > 0.5 * 1500e-6);
  CHECK(first < 1.5 * 1500e-6);
}

TEST_CASE("All bodies move with the energy of their speeds, wherever they are simulated") {
  Bench bench;
  for (auto& body : bench.scene.bodies)
    if (body.kind == physics::BodyKind::kDynamic) body.motion.velocity.linear = {0, 0.1, 0};
  const double expected_J = 0.5 * (0.2 + 1) * 0.1 * 0.1;
  for (const auto coupling :
       {CouplingScheme::kDirect, CouplingScheme::kSubWorld, CouplingScheme::kStatic, CouplingScheme::kInterpolation}) {
    auto worlds = bench.worlds(coupling);
    worlds.start_at_rest();
    CHECK(worlds.motion().kinetic_J == Approx(expected_J));
    CHECK(worlds.motion().speed_squared == Approx(2 * 0.1 * 0.1));
  }
}

TEST_CASE("Planes hold the hand as the bodies do that they stand for, and the bodies bear its force") {
  const Bench bench;
  const auto held_N = [&](CouplingScheme coupling, double& block_z_m) {
    auto worlds = bench.worlds(coupling);
    auto hand = bench.arm();
    worlds.start_at_rest();
    double sum_N = 0;
    for (std::size_t k = 0; k < 1500; ++k) {
      if (k > 0) hand.advance(worlds.last().on_device);
      const double force_N = worlds.tick(hand.ideal()).on_device.force.z;
      if (k >= 1000) sum_N += force_N / 500;
    }
    if (worlds.global() != nullptr) block_z_m = worlds.global()->bodies()[1].motion.pose.position.z;
    return sum_N;
  };
  double block_z_m = 0;
  const double direct_N = held_N(CouplingScheme::kDirect, block_z_m);
  CHECK(direct_N > 1);
  for (const auto coupling : {CouplingScheme::kPlane, CouplingScheme::kPlanes, CouplingScheme::kLinearised}) {
    CHECK(held_N(coupling, block_z_m) == Approx(direct_N).epsilon(0.05));
    CHECK(block_z_m == Approx(0.05).margin(1e-4));  // pressed on, but neither pushed into the ground nor thrown
  }
}

TEST_CASE("An arm without force stays, and a force moves it after the device's delay, not before") {
  Bench bench;
  bench.scene.hand.path.resize(1);
  auto arm = bench.arm();
  const Vec3d start = arm.ideal().pose.position;
  const unsigned delay = bench.profile.transport_delay_ticks;
  const double quantum_m = bench.profile.properties.position_quantum_m;
  CHECK(norm(arm.encoded().pose.position - start) <= quantum_m);
  for (unsigned k = 0; k < delay; ++k) arm.advance({{5, 0, 0}, {}});
  CHECK(norm(arm.ideal().pose.position - start) < 1e-12);
  arm.advance({{5, 0, 0}, {}});
  const double moved = arm.ideal().pose.position.x - start.x;
  CHECK(moved > 0);
  // Four sub-steps from rest under 5 N, against a hand that resists: at most 5/8 of a T^2.
  CHECK(moved < 0.625 * 5.0 / 0.5 * 1e-6);
}
