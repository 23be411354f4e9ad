// The global world's prediction of the sub-world, and the corrections that follow from it.
#include "sim/exchange/sub_world_prediction.h"

#include "tests/rt/haptics/coupling/sub_world_bench.h"

using namespace tactus;
using namespace tactus::test::sub_world_bench;
using haptics::OutsideBody;
using sim::SubWorldPrediction;

namespace {

constexpr double kOutsideMass = 0.4;

SubWorldConfig ghost_config() {
  SubWorldConfig config = make_config();
  config.border_mode = physics::BorderMode::kGhost;
  config.step.gravity = {0, 0, -9.81};
  return config;
}

// The device: it moves down on the outside body.
DeviceTarget pressing() { return {true, {{0, 0, kRadius - 1e-3}, {}}, {{0.01, 0, -0.02}, {}}}; }

// The proxy on an outside body of `mass`, in the haptic side's sub-world and in the prediction of it.
struct Pair {
  Bench haptic{ghost_config()};
  SubWorldPrediction prediction{ghost_config(), {}};
  physics::World global{ghost_config().capacities};

  // `others`: members besides the proxy.
  explicit Pair(double mass = kOutsideMass, std::vector<Body> others = {}) {
    others.insert(others.begin(), ball(kProxy, {0, 0, kRadius}));
    haptic.next_with(others);
    for (const Body& member : others) REQUIRE(global.insert(member));
    add_border(mass);
    synchronise();
  }
  void add_border(double mass) {
    OutsideBody outside;
    outside.id = kOutside;
    outside.admittance.linear = SymMat3d::identity(1 / mass);
    outside.drive.linear = {0, 0, kMass * 9.81 / mass};
    REQUIRE(haptic.snapshot->outside.try_push(outside));
    BorderPoint point = support(kProxy, kMass * 9.81, 0.3);
    point.outside_inverse_mass = 1 / mass;
    REQUIRE(haptic.snapshot->border.try_push(point));
  }
  void synchronise() {
    haptic.synchronise();
    prediction.adopt(*haptic.snapshot);
  }
  // A cycle in both, in `ticks` on the haptic side; the hand pulls aside by `aside_m_per_s` more than extrapolated.
  void run(double aside_m_per_s = 0, std::uint32_t ticks = 5) {
    haptic.report->device = pressing();
    const sim::ExtrapolatedHand hand{.now = haptic.report->device};
    prediction.run(*haptic.report, hand);
    for (std::uint32_t tick = 0; tick < ticks; ++tick) {
      DeviceTarget device = hand.after(tick * kTick_s);
      device.pose.position.x += aside_m_per_s * tick * kTick_s;
      haptic.step(1, device);
    }
  }
  // Ends the cycle with this motion in the global world.
  void end(const BodyMotion& in_global, double next_mass = kOutsideMass) {
    global.find(kProxy)->motion = in_global;
    haptic.next({kProxy});
    add_border(next_mass);
    fill_corrections();
    synchronise();
  }
  void fill_corrections() {
    prediction.find_corrected(*haptic.snapshot);
    prediction.fill_corrections(global, *haptic.snapshot);
  }
};

const BodyMotion kGlobal{{{2e-3, -1e-3, kRadius}, quat_from_rotation_vector(Vec3d{0.1, 0, 0})},
                         {{0.01, 0.02, 0}, {0, 1, 0}}};

}  // namespace

// Whatever the ghosts are: light or heavy, so that the proxy drops or stays.
TEST_CASE("If the hand moves as extrapolated a member ends the cycle in the global world's state") {
  const double mass = GENERATE(0.01, 0.4, 1e6);
  Pair pair(mass);
  for (int cycle = 0; cycle < 3; ++cycle) {
    pair.run();
    pair.end(kGlobal, mass);
    const BodyMotion proxy = pair.haptic.motion(kProxy);
    check_close(proxy.pose.position, kGlobal.pose.position, 1e-12);
    check_close(proxy.velocity.linear, kGlobal.velocity.linear, 1e-12);
    check_close(proxy.velocity.angular, kGlobal.velocity.angular, 1e-12);
    CHECK(pair.prediction.not_predicted(*pair.haptic.report).size() == 1);
    check_close(pair.prediction.not_predicted(*pair.haptic.report)[0].impulse.force, {}, 1e-12);
  }
}

TEST_CASE("What the hand does beyond the extrapolation is added to the global world's state") {
  Pair as_expected, pair;
  as_expected.run();
  pair.run(0.2);
  const BodyMotion expected = as_expected.haptic.motion(kProxy), moved = pair.haptic.motion(kProxy);
  const Vec3d beyond = moved.pose.position - expected.pose.position;
  REQUIRE(beyond.x > 1e-5);
  pair.end(kGlobal);
  check_close(pair.haptic.motion(kProxy).pose.position, kGlobal.pose.position + beyond, 1e-12);
  check_close(pair.haptic.motion(kProxy).velocity.linear,
              kGlobal.velocity.linear + moved.velocity.linear - expected.velocity.linear, 1e-12);
}

TEST_CASE(
    "What members gave to an outside body beyond the prediction is known after the cycle, unless the tank is empty") {
  Pair pair;
  pair.run(0.2);
  const Vec3d given = pair.haptic.sub_world.world().border_ghosts()[0].total_impulse.force;
  Pair as_expected;
  as_expected.run();
  const Vec3d predicted = as_expected.haptic.sub_world.world().border_ghosts()[0].total_impulse.force;
  REQUIRE(norm(given - predicted) > 1e-5);
  pair.end(kGlobal);
  const auto beyond = pair.prediction.not_predicted(*pair.haptic.report);
  REQUIRE(beyond.size() == 1);
  CHECK(beyond[0].id == kOutside);
  check_close(beyond[0].impulse.force, given - predicted, 1e-12);
  pair.haptic.report->border_tank_J = -1e-6;
  CHECK(pair.prediction.not_predicted(*pair.haptic.report).empty());
}

// Over more ticks a lasting load gives more: that is not the hand's.
TEST_CASE("After a late cycle members are corrected, and nothing is given to outside bodies") {
  Pair on_time, late;
  on_time.run();
  late.run(0, 8);
  const BodyMotion expected = on_time.haptic.motion(kProxy), moved = late.haptic.motion(kProxy);
  late.end(kGlobal);
  check_close(late.haptic.motion(kProxy).pose.position,
              kGlobal.pose.position + moved.pose.position - expected.pose.position, 1e-12);
  CHECK(late.prediction.not_predicted(*late.haptic.report).empty());
}

TEST_CASE("A prediction that has not run since the last snapshot fills no corrections") {
  Pair pair;
  pair.fill_corrections();
  CHECK(pair.haptic.snapshot->corrections.empty());
  CHECK_FALSE(pair.prediction.corrects(kProxy));
}

TEST_CASE("Members are corrected if one of their island met an outside body, in the sub-world or the global step") {
  constexpr BodyId kTouching = 1, kLinked = 2, kApart = 3;
  Pair pair(kOutsideMass, {ball(kTouching, {2 * kRadius - 1e-5, 0, kRadius}),
                           ball(kLinked, {4 * kRadius - 2e-5, 0, kRadius}), ball(kApart, {0, 10 * kRadius, kRadius})});
  pair.run();
  pair.haptic.next({kProxy, kTouching, kLinked, kApart});
  const bool in_global_step = GENERATE(false, true);
  if (in_global_step) REQUIRE(pair.haptic.snapshot->border.try_push(support(kApart, kMass * 9.81, 0.3)));
  pair.fill_corrections();
  const auto& corrections = pair.haptic.snapshot->corrections;
  REQUIRE(corrections.size() == (in_global_step ? 4 : 3));
  for (std::uint32_t i = 0; i < corrections.size(); ++i) CHECK(corrections[i].id == i);
  for (const BodyId member : {kProxy, kTouching, kLinked}) CHECK(pair.prediction.corrects(member));
  CHECK(pair.prediction.corrects(kApart) == in_global_step);
}

TEST_CASE("A saved prediction goes on as the first one, bit by bit") {
  Pair pair;
  pair.run();
  std::vector<std::byte> bytes(pair.prediction.save_size_bound());
  ByteWriter out(bytes);
  pair.prediction.save(out);
  REQUIRE(out.ok());
  SubWorldPrediction other{ghost_config(), {}};
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(other.restore(in));
  pair.haptic.next({kProxy});
  const auto again = std::make_unique<WorldSnapshot>(*pair.haptic.snapshot);
  pair.fill_corrections();
  other.find_corrected(*again);
  other.fill_corrections(pair.global, *again);
  REQUIRE(again->corrections.size() == 1);
  CHECK(same_bits(again->corrections[0], pair.haptic.snapshot->corrections[0]));
  ByteReader cut(std::span<const std::byte>(bytes).first(out.size() - 1));
  CHECK_FALSE(other.restore(cut));
}
