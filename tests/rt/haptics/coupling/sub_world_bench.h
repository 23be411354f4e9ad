// A sub-world on a bench: what is in it, what the next snapshot tells it, what it reports and how it moves, without a
// global world beside it. Frame: world, z up. Units: SI.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <vector>

#include "rt/haptics/coupling/sub_world.h"
#include "tests/support/bits.h"

namespace tactus::test::sub_world_bench {

using haptics::BorderPoint;
using haptics::CouplingScheme;
using haptics::DeviceTarget;
using haptics::SubWorld;
using haptics::SubWorldConfig;
using haptics::SubWorldReport;
using haptics::SubWorldStep;
using haptics::WorldSnapshot;
using physics::Body;
using physics::BodyMotion;
using physics::Shape;
using test::same_bits;

inline constexpr BodyId kProxy = 0, kGround = 50, kOutside = 90;
inline constexpr double kTick_s = 1e-3, kMass = 0.5, kRadius = 0.05;

inline SubWorldConfig make_config(CouplingScheme scheme = CouplingScheme::kSubWorld) {
  SubWorldConfig config;
  config.scheme = scheme;
  config.border_mode = physics::BorderMode::kCapped;
  config.ratio = 5;
  config.proxy = kProxy;
  config.step.dt = kTick_s;
  config.capacities = {.bodies = 16, .fixed_bodies = 4, .pairs = 64, .contacts = 64, .border_contacts = 8};
  return config;
}

inline Body ball(BodyId id, const Vec3d& at, const Twistd& velocity = {}) {
  auto body = physics::make_dynamic_body(id, Shape::sphere(kRadius), kMass, 0.5, {at, {}});
  body.motion.velocity = velocity;
  return body;
}

inline Body cube(BodyId id, double height) {
  return physics::make_dynamic_body(id, Shape::box({0.05, 0.05, 0.05}), kMass, 0.5, {{0, 0, height}, {}});
}

inline Body ground() { return physics::make_fixed_body(kGround, Shape::plane(), 0.5, {}); }

// A border point at the foot of a ball, where it stands on an outside body whose surface is z = 0: it pushes up and
// turns nothing.
inline BorderPoint support(BodyId member, double force_N, double friction = 0, std::uint32_t feature = 7) {
  BorderPoint point;
  point.member = member;
  point.outside = kOutside;
  point.feature = feature;
  point.normal = {0, 0, 1};
  point.member_anchor = {0, 0, -kRadius};
  point.impulse_rate_N = force_N;
  point.friction = friction;
  return point;
}

// A sub-world, the snapshot that it gets next and the report that it gave last.
struct Bench {
  explicit Bench(const SubWorldConfig& config, std::vector<Body> fixed = {}) : sub_world(config, fixed) {}

  SubWorld sub_world;
  std::unique_ptr<WorldSnapshot> snapshot = std::make_unique<WorldSnapshot>();
  std::unique_ptr<SubWorldReport> report = std::make_unique<SubWorldReport>();
  SubWorldStep last;
  std::uint64_t cycle{0};

  // Clears what the snapshot says but for the members.
  WorldSnapshot& next(std::vector<BodyId> members) {
    snapshot->members.clear();
    snapshot->joiners.clear();
    snapshot->warm_starts.clear();
    snapshot->border.clear();
    snapshot->outside.clear();
    snapshot->corrections.clear();
    for (const BodyId id : members) REQUIRE(snapshot->members.try_push(id));
    return *snapshot;
  }
  WorldSnapshot& next_with(std::vector<Body> joiners) {
    next({});
    for (const auto& body : joiners) {
      REQUIRE(snapshot->members.try_push(body.id));
      REQUIRE(snapshot->joiners.try_push(body));
    }
    return *snapshot;
  }
  void synchronise() {
    snapshot->cycle = cycle++;
    sub_world.synchronise(*snapshot, *report);
  }
  void step(std::uint32_t ticks = 1, const DeviceTarget& target = {}, std::uint32_t sub_steps = 4) {
    for (std::uint32_t i = 0; i < ticks; ++i) last = sub_world.step(target, sub_steps, {});
  }
  BodyMotion motion(BodyId id) const {
    const physics::Body* member = sub_world.world().find(id);
    REQUIRE(member != nullptr);
    return member->motion;
  }
  bool is_member(BodyId id) const { return sub_world.world().find(id) != nullptr; }
  const physics::BorderContact& border(std::uint32_t i) const { return sub_world.world().border_contacts()[i]; }
};

inline void check_close(const Vec3d& a, const Vec3d& b, double within) {
  CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z);
  CHECK(norm(a - b) <= within);
}

inline DeviceTarget target_at(const Vec3d& position, const Quatd& rotation = {}) {
  return {true, {position, rotation}, {}};
}

}  // namespace tactus::test::sub_world_bench
