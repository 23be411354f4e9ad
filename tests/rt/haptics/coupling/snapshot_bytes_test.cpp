#include "rt/haptics/coupling/snapshot_bytes.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "tests/support/bits.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::haptics;

namespace {

constexpr std::size_t kHeader = 8 + 8 + 4 + 4 + 4 + 8 + 8 + sizeof(physics::BodyMotion);

physics::BodyMotion random_motion(test::Random& random) {
  return {{random.vector(10), quat_from_rotation_vector(random.vector(1))}, {random.vector(2), random.vector(5)}};
}

struct Counts {
  std::uint32_t members, joiners, warm_starts, border;
};

std::unique_ptr<WorldSnapshot> random_snapshot(std::uint64_t seed, const Counts& counts) {
  test::Random random(seed);
  auto s = std::make_unique<WorldSnapshot>();
  s->cycle = 1000 + seed;
  s->global_time_s = random(0, 100);
  s->dropped = 3;
  s->component = 400;
  s->proxy = random_motion(random);
  for (std::uint32_t i = 0; i < counts.members; ++i) REQUIRE(s->members.try_push(2 * i + 1));
  for (std::uint32_t i = 0; i < counts.members; i += 3) {
    const auto motion = random_motion(random);
    REQUIRE(s->corrections.try_push({.id = 2 * i + 1,
                                     .displacement_m = motion.pose.position,
                                     .rotation = motion.pose.rotation,
                                     .velocity = motion.velocity}));
  }
  for (std::uint32_t i = 0; i < counts.members; ++i) REQUIRE(s->effects.try_push(static_cast<std::byte>(i)));
  for (std::uint32_t i = 0; i < counts.joiners; ++i) {
    auto body =
        physics::make_dynamic_body(i, physics::Shape::sphere(random(0.01, 1)), random(0.1, 9), random(0, 1), {});
    body.motion = random_motion(random);
    REQUIRE(s->joiners.try_push(body));
  }
  for (std::uint32_t i = 0; i < counts.warm_starts; ++i) {
    physics::WarmStart w;
    w.key = PairKey::of(i, i + 7, i % 2 == 0);
    w.count = i % 5;
    for (std::uint32_t k = 0; k < w.count; ++k) {
      w.features[k] = k * i;
      w.normal_force[k] = random(0, 50);
      w.friction_force[k] = random.vector(10);
    }
    REQUIRE(s->warm_starts.try_push(w));
  }
  for (std::uint32_t i = 0; i < counts.border; ++i) {
    BorderPoint point;
    point.member = i;
    point.outside = i + 9;
    point.feature = i * i;
    point.normal = {0, 0, 1};
    point.member_anchor = random.vector(1);
    point.impulse_rate_N = random(0, 50);
    point.friction = random(0, 1);
    point.outside_velocity = random.vector(1);
    REQUIRE(s->border.try_push(point));
    OutsideBody body;
    body.id = point.outside;
    body.centre = random.vector(1);
    body.velocity = {random.vector(1), random.vector(1)};
    body.admittance.crossed[1] = random.vector(3);
    if (i < kMaxOutsideBodies) REQUIRE(s->outside.try_push(body));
  }
  return s;
}

std::vector<std::byte> bytes_of(const WorldSnapshot& snapshot) {
  std::vector<std::byte> bytes(snapshot_bytes_bound());
  ByteWriter out(bytes);
  write_snapshot(out, snapshot);
  REQUIRE(out.ok());
  bytes.resize(out.size());
  return bytes;
}

bool read(const std::vector<std::byte>& bytes, WorldSnapshot& snapshot) {
  ByteReader in(bytes);
  return read_snapshot(in, snapshot) && in.remaining() == 0;
}

}  // namespace

TEST_CASE("a snapshot that is written and read is the same, and its bytes hold only what is used") {
  const auto back = std::make_unique<WorldSnapshot>();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    const auto some = [&] { return static_cast<std::uint32_t>(random(0, 40)); };
    const Counts counts{some(), some(), some(), some()};
    const auto s = random_snapshot(seed, counts);
    const auto bytes = bytes_of(*s);
    CHECK(bytes.size() == kHeader + 9 * 4 + counts.members * (sizeof(BodyId) + 1) +
                              s->corrections.size() * sizeof(MotionCorrection) +
                              counts.joiners * sizeof(physics::Body) + counts.warm_starts * sizeof(physics::WarmStart) +
                              counts.border * (sizeof(BorderPoint) + sizeof(OutsideBody)));
    REQUIRE(read(bytes, *back));
    CHECK(back->cycle == s->cycle);
    CHECK(back->global_time_s == s->global_time_s);
    CHECK(back->dropped == s->dropped);
    CHECK(back->component == s->component);
    CHECK(back->epoch == s->epoch);
    CHECK(back->proxy == s->proxy);
    REQUIRE(back->members.size() == counts.members);
    for (std::uint32_t i = 0; i < counts.members; ++i) CHECK(back->members[i] == s->members[i]);
    REQUIRE(back->effects.size() == counts.members);
    for (std::uint32_t i = 0; i < counts.members; ++i) CHECK(back->effects[i] == s->effects[i]);
    REQUIRE(back->corrections.size() == s->corrections.size());
    for (std::uint32_t i = 0; i < s->corrections.size(); ++i)
      CHECK(test::same_bits(back->corrections[i], s->corrections[i]));
    REQUIRE(back->outside.size() == counts.border);
    for (std::uint32_t i = 0; i < counts.border; ++i) CHECK(test::same_bits(back->outside[i], s->outside[i]));
    REQUIRE(back->joiners.size() == counts.joiners);
    for (std::uint32_t i = 0; i < counts.joiners; ++i) {
      CHECK(back->joiners[i].id == s->joiners[i].id);
      CHECK(back->joiners[i].mass == s->joiners[i].mass);
      CHECK(back->joiners[i].shape.radius == s->joiners[i].shape.radius);
      CHECK(back->joiners[i].motion == s->joiners[i].motion);
    }
    REQUIRE(back->warm_starts.size() == counts.warm_starts);
    for (std::uint32_t i = 0; i < counts.warm_starts; ++i) {
      CHECK(back->warm_starts[i].key == s->warm_starts[i].key);
      CHECK(back->warm_starts[i].normal_force == s->warm_starts[i].normal_force);
      CHECK(back->warm_starts[i].friction_force == s->warm_starts[i].friction_force);
    }
    REQUIRE(back->border.size() == counts.border);
    for (std::uint32_t i = 0; i < counts.border; ++i) {
      CHECK(back->border[i].outside == s->border[i].outside);
      CHECK(back->border[i].member_anchor == s->border[i].member_anchor);
      CHECK(back->border[i].outside_velocity == s->border[i].outside_velocity);
    }
    CHECK(bytes_of(*back) == bytes);
  }
}

TEST_CASE("a full snapshot fits the bound") {
  const auto s = random_snapshot(1, {kMaxMembers, kMaxMembers, kMaxWarmStarts, kMaxBorderPoints});
  const auto back = std::make_unique<WorldSnapshot>();
  REQUIRE(read(bytes_of(*s), *back));
  CHECK(back->border.size() == kMaxBorderPoints);
}

TEST_CASE("every truncation of a snapshot is refused") {
  const auto bytes = bytes_of(*random_snapshot(4, {3, 2, 3, 2}));
  const auto back = std::make_unique<WorldSnapshot>();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ByteReader in(std::span<const std::byte>(bytes).first(size));
    REQUIRE_FALSE(read_snapshot(in, *back));
  }
}

TEST_CASE("counts beyond a capacity are refused, however many bytes follow") {
  const auto bytes = bytes_of(*random_snapshot(5, {0, 0, 0, 0}));
  const auto back = std::make_unique<WorldSnapshot>();
  const std::uint32_t capacities[] = {kMaxMembers, kMaxMembers, kMaxWarmStarts, kMaxMembers, kMaxBorderPoints};
  for (std::size_t list = 0; list < std::size(capacities); ++list) {
    for (const std::uint32_t count : {capacities[list] + 1, 0x80000000u, 0xffffffffu}) {
      auto damaged = bytes;
      std::memcpy(damaged.data() + kHeader + 4 * list, &count, 4);
      damaged.resize(1u << 20);
      ByteReader in(damaged);
      CAPTURE(list, count);
      CHECK_FALSE(read_snapshot(in, *back));
    }
  }
}

TEST_CASE("what would trip the sub-world is refused") {
  const auto s = random_snapshot(6, {4, 2, 3, 1});
  const auto back = std::make_unique<WorldSnapshot>();
  REQUIRE(read(bytes_of(*s), *back));
  SECTION("members out of order") { std::swap(s->members[1], s->members[2]); }
  SECTION("a member twice") { s->members[1] = s->members[2]; }
  SECTION("a joiner without mass") { s->joiners[1].mass = 0; }
  SECTION("a joiner that is nowhere") {
    s->joiners[0].motion.pose.position.y = std::numeric_limits<double>::quiet_NaN();
  }
  SECTION("a joiner that cannot turn") { s->joiners[0].inertia.z = 0; }
  SECTION("a joiner that is fixed") { s->joiners[0].kind = physics::BodyKind::kFixed; }
  SECTION("a joiner with an id that no pair can hold") { s->joiners[0].id = kNoBody; }
  SECTION("more contact points than a manifold has") { s->warm_starts[2].count = 5; }
  CHECK_FALSE(read(bytes_of(*s), *back));
}

TEST_CASE("a correction that is not finite, or has no rotation, is refused") {
  const auto back = std::make_unique<WorldSnapshot>();
  const auto s = random_snapshot(4, {6, 2, 3, 2});
  REQUIRE(read(bytes_of(*s), *back));
  REQUIRE(s->corrections.size() == 2);
  SECTION("velocity") { s->corrections[0].velocity.linear.x = std::numeric_limits<double>::quiet_NaN(); }
  SECTION("displacement") { s->corrections[1].displacement_m.z = std::numeric_limits<double>::infinity(); }
  SECTION("rotation") { s->corrections[1].rotation = {0, 0, 0, 0}; }
  CHECK_FALSE(read(bytes_of(*s), *back));
}
