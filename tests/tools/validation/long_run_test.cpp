// An hour of ticks: what rests does not drift, and nothing grows. Part of tools/check --long.
#include <catch2/catch.hpp>

#include "tests/system/session_bench.h"
#include "tools/validation/case_world.h"

using namespace tactus;
using namespace tactus::hard_cases;

namespace {
constexpr int kHour = 3'600'000;  // ticks of 1 ms
}

TEST_CASE("an hour at rest: two cubes and a card stay where they are", "[.long]") {
  CaseWorld world({});
  world.add_ground(1000, 0.5);
  world.add_box(0, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.05}, {}});
  world.add_box(1, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.15}, {}});
  world.add_box(2, {0.03, 0.04, 0.001}, 0.01, 0.5, {{0.3, 0, 0.001}, {}});
  world.run(2);
  std::vector<Posed> start;
  for (const auto& body : world.world.bodies()) start.push_back(body.motion.pose);
  double fastest = 0;
  for (int k = 0; k < kHour; ++k) {
    world.step();
    fastest = std::max(fastest, world.fastest());
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Posed& end = world.world.bodies()[i].motion.pose;
    CHECK(norm(end.position - start[i].position) < 1e-6);
    CHECK(norm(small_rotation_vector(end.rotation * conjugate(start[i].rotation))) < 1e-5);
  }
  CHECK(fastest < 1e-6);
  Outcome outcome;
  world.close(outcome);
  CHECK(outcome.broken_gates == std::vector<std::string>{});
}

TEST_CASE("an hour under a working hand: a press every two seconds, the last as the first", "[.long]") {
  std::string text = test::kPressScene;
  const std::string once = text.substr(text.find("[hand]"));
  text.replace(text.find("[hand]"), once.size(), R"([hand]
repeat = true
path = [
  {time_s = 0.0, position_m = [0, 0, 0.115]},
  {time_s = 0.5, position_m = [0, 0, 0.104]},
  {time_s = 1.0, position_m = [0, 0, 0.104]},
  {time_s = 1.5, position_m = [0, 0, 0.115]},
  {time_s = 2.0, position_m = [0, 0, 0.115]},
]
)");
  auto session = test::make_session(test::scene_text(text), test::virtual_options());
  double first = 0, most = 0, last = 0;
  const Vec3d block = session->scene.bodies.back().motion.pose.position;
  test::run(*session, kHour, [&](const loop::TickOutput& out) {
    const double force = norm(out.command.wrench.force);
    most = std::max(most, force);
    if (out.tick >= 2000 && out.tick < 4000) first = std::max(first, force);
    if (out.tick >= kHour - 2000) last = std::max(last, force);
    return out.fault == Fault::kNone;
  });
  CHECK(session->stats.ticks == kHour);
  CHECK(first > 1);
  CHECK(last == Approx(first).epsilon(0.01));
  CHECK(most < 1.1 * first);
  // A frictionless axis would wander; the block is held by friction against a hand that comes straight down.
  for (const auto& body : session->global->world().bodies())
    if (body.id != session->scene.proxy) CHECK(norm(body.motion.pose.position - block) < 1e-3);
}
