// The card house: it stands by itself through the whole chain, and falls when it should.
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

struct Moved {
  double most_m{0}, most_rad{0};
};

Moved moved_since_start(const session::Session& session) {
  Moved moved;
  for (const auto& body : session.loop->sub_world().world().bodies()) {
    if (body.id == session.scene.proxy) continue;
    const Posed& start = session.scene.bodies[body.id].motion.pose;
    moved.most_m = std::max(moved.most_m, norm(body.motion.pose.position - start.position));
    moved.most_rad =
        std::max(moved.most_rad, norm(small_rotation_vector(body.motion.pose.rotation * conjugate(start.rotation))));
  }
  return moved;
}

}  // namespace

TEST_CASE("a card house stands for sixty seconds", "[no-asan][no-tsan]") {
  sim::Scene scene = scene_file("card_house.toml");
  const Vec3d start = scene.hand.path.front().position_m;
  scene.hand.path = {{0.0, start + Vec3d{0, 0, 0.02}, {}}};  // the hand stays off it
  scene.hand.repeat = false;
  scene.bodies[scene.proxy].motion.pose.position = start + Vec3d{0, 0, 0.02};
  session::RunOptions options = virtual_options();
  options.coupling = GENERATE(haptics::CouplingScheme::kDirect, haptics::CouplingScheme::kSubWorld);
  options.all_members = options.coupling == haptics::CouplingScheme::kSubWorld;
  auto session = make_session(std::move(scene), options);
  const auto summary = run(*session, 60'000);
  const Moved moved = moved_since_start(*session);
  INFO("moved " << moved.most_m << " m, " << moved.most_rad << " rad");
  CHECK(session->loop->sub_world().members() == summary.bodies);
  CHECK(moved.most_m < 1e-3);
  CHECK(moved.most_rad < 0.02);
  CHECK(session->loop->sub_world().world().kinetic_energy() < 1e-6);
}

TEST_CASE("a card house of smooth cards falls") {
  sim::Scene scene = scene_file("card_house.toml");
  for (auto& body : scene.bodies) body.friction = 0.1;  // the feet need more
  session::RunOptions options = virtual_options();
  options.coupling = haptics::CouplingScheme::kDirect;
  auto session = make_session(std::move(scene), options);
  run(*session, 2000);
  CHECK(moved_since_start(*session).most_m > 0.05);
}
