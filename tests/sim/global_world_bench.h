// A global world by itself: its scene, the snapshot that it gave last and the report that it gets next.
// Frame: world, z up. Units: SI.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>

#include "sim/global_world.h"

namespace tactus::test {

inline constexpr double kGlobalStep_s = 0.01;  // of a scene that sets no other

inline sim::GlobalOptions capped_border() {
  sim::GlobalOptions options;
  options.border_mode = physics::BorderMode::kCapped;
  return options;
}

// Snapshot and report are too large for a stack.
struct GlobalWorldBench {
  sim::Scene scene;
  sim::GlobalWorld world;
  std::unique_ptr<haptics::WorldSnapshot> snapshot = std::make_unique<haptics::WorldSnapshot>();
  std::unique_ptr<haptics::SubWorldReport> report = std::make_unique<haptics::SubWorldReport>();

  explicit GlobalWorldBench(const sim::Scene& s, const sim::GlobalOptions& options = capped_border())
      : scene(s), world(scene, options) {
    REQUIRE(sim::check_global_options(scene, options).ok());
    world.first_snapshot(*snapshot);
  }
  void step() {
    report->cycle = snapshot->cycle;
    world.step(*report, *snapshot);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step();
  }
  // Until `bodies` sleep; returns the number of steps.
  int run_until_asleep(std::uint32_t bodies, int at_most = 500) {
    int steps = 0;
    for (; world.statistics().asleep < bodies && steps < at_most; ++steps) step();
    REQUIRE(world.statistics().asleep == bodies);
    return steps;
  }
  // Of a scene all of whose bodies have their slots as ids.
  const physics::Body& body(std::uint32_t slot) const { return world.world().bodies()[slot]; }
  const physics::BodyMotion& motion(BodyId id) const {
    for (const auto& body : world.bodies())
      if (body.id == id) return body.motion;
    FAIL("no body " << id);
    return world.bodies()[0].motion;
  }
  double energy_J() const { return world.kinetic_energy_J() + world.potential_energy_J(); }
  double fastest() const {  // of the bodies that gravity pulls
    double speed = 0;
    for (const auto& body : world.bodies())
      if (body.gravity_scale > 0) speed = std::max(speed, norm(body.motion.velocity.linear));
    return speed;
  }
  double deepest_m() const {
    double deepest = 0;
    for (const auto& contact : world.world().contacts())
      for (std::uint32_t i = 0; i < contact.count; ++i) deepest = std::max(deepest, -contact.points[i].separation);
    return deepest;
  }
  double force_between_N(BodyId id, BodyId fixed) const {  // mean over the last step
    double sum_Ns = 0;
    for (const auto& contact : world.world().contacts())
      for (std::uint32_t i = 0; i < contact.count && contact.key == PairKey::of(id, fixed, true); ++i)
        sum_Ns += contact.points[i].total_normal_impulse;
    return sum_Ns / kGlobalStep_s;
  }
  // The next report gives the proxy this position, at rest.
  void impose_proxy(const Vec3d& at) {
    haptics::MemberMotion proxy;
    proxy.id = scene.proxy;
    proxy.motion.pose.position = at;
    REQUIRE(report->members.try_push(proxy));
  }
};

}  // namespace tactus::test
