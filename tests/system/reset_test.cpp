// The scene is reset while the loop runs: every body where the scene puts it, no force meanwhile, and trials alike.
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

// By id, those that the hand does not hold.
std::vector<Vec3d> places(const session::Session& session) {
  std::vector<Vec3d> result;
  for (const auto& body : session.global->bodies())
    if (body.id != session.scene.proxy) result.push_back(body.motion.pose.position);
  return result;
}

}  // namespace

TEST_CASE("a reset puts every body back, with the force off, whatever the coupling") {
  session::RunOptions options = virtual_options();
  const auto all = haptics::kCouplingSchemes;
  options.coupling = GENERATE_COPY(filter([](auto coupling) { return coupling != haptics::CouplingScheme::kDirect; },
                                          from_range(all.begin(), all.end())));
  options.inject = "reset@1000,reset@2000,reset@2010";  // the last comes while one is under way: it is that one
  auto session = make_session(scene_text(kPressScene), options);
  const std::vector<Vec3d> start = places(*session);
  std::uint32_t epoch = 0;
  std::uint64_t resetting = 0, forced = 0;
  const auto summary = run(*session, 3000, [&](const loop::TickOutput& out) {
    const haptics::SubWorld& sub_world = session->loop->sub_world();
    if (sub_world.epoch() != epoch) {
      epoch = sub_world.epoch();
      CHECK(places(*session) == start);
      CHECK(out.command.wrench == Wrenchd{});
      CHECK(norm(sub_world.proxy().pose.position - out.target.position) < 1e-2);  // where the device is
    }
    if ((out.status & kSceneReset) != 0 && sub_world.awaits_reset()) {
      ++resetting;
      if (out.command.wrench != Wrenchd{}) ++forced;
    }
    return true;
  });
  CHECK(epoch == 2);
  CHECK(summary.global.resets == 2);
  CHECK(resetting > 0);
  CHECK(forced == 0);
  CHECK((session->driver->output().status & (kSceneReset | kNotArmed)) == 0);
  CHECK(session->driver->output().fault == Fault::kNone);
}

TEST_CASE("trials are equal: after a reset the hand repeats its path, with the same force") {
  session::RunOptions options = virtual_options();
  options.inject = "reset@1500,reset@4000";
  auto session = make_session(scene_text(kPressScene), options);
  std::vector<std::vector<double>> forces_N;  // of each trial, from the tick on in which the device is engaged
  bool engaged = false;
  run(*session, 6500, [&](const loop::TickOutput& out) {
    const bool now = (out.status & (kNotArmed | kSceneReset)) == 0;
    if (now && !engaged) forces_N.emplace_back();
    engaged = now;
    if (engaged) forces_N.back().push_back(out.command.wrench.force.z);
    return true;
  });
  REQUIRE(forces_N.size() == 3);
  double apart_N = 0, most_N = 0, most_first_N = 0;
  for (std::size_t tick = 0; tick < 1400; ++tick) {
    apart_N = std::max(apart_N, std::abs(forces_N[2][tick] - forces_N[1][tick]));
    most_first_N = std::max(most_first_N, forces_N[0][tick]);
    most_N = std::max(most_N, forces_N[1][tick]);
  }
  CHECK(most_N > 1.5);
  CHECK(apart_N < 1e-3 * most_N);
  // The first trial began with bodies that had not settled, and in another tick of its cycle: it touches as hard.
  CHECK(most_N == Approx(most_first_N).epsilon(0.03));
  CHECK(forces_N[1][1399] == Approx(forces_N[0][1399]).epsilon(1e-3));
}

TEST_CASE("a reset mends what broke, and sends back what is moved by a script, in both worlds") {
  auto session = make_session(scene_file("workshop.toml"), virtual_options());
  bool broke = false, begun = false;
  run(*session, 8000, [&](const loop::TickOutput& out) {
    const auto& inside = session->loop->sub_world();
    const physics::World* const worlds[] = {&inside.world(), &session->global->world()};
    if (!broke && session->global->statistics().broken_joints > 0) {
      broke = true;
      session->resets.push_back(out.tick + 5);
    }
    if (inside.epoch() == 0) return true;
    begun = true;
    for (const auto* world : worlds) {
      for (const auto& state : world->effects().find<physics::Joints>()->states()) CHECK(state.broken == 0);
      for (const double time_s : world->effects().find<physics::ScriptedMotion>()->times()) CHECK(time_s <= 2e-3);
    }
    return false;
  });
  CHECK(broke);
  CHECK(begun);
}

TEST_CASE("a reset does not take a fault back, nor arm what is not armed") {
  session::RunOptions options = virtual_options();
  options.inject = "unplugged@500,reset@1000";
  auto session = make_session(scene_file("stack20.toml"), options);
  run(*session, 2500);  // the hand has gone back before
  CHECK(session->loop->sub_world().epoch() == 1);
  CHECK(session->driver->output().fault != Fault::kNone);
  CHECK(session->driver->output().command.wrench == Wrenchd{});
}

TEST_CASE("the direct coupling has nothing to reset, and says so") {
  session::RunOptions options = virtual_options();
  options.coupling = haptics::CouplingScheme::kDirect;
  options.inject = "reset@1000";
  const auto session = session::Session::create(scene_file("stack20.toml"), options);
  REQUIRE_FALSE(session.ok());
  CHECK(session.message() == "--inject: reset: the direct coupling has no global world to reset");
}
