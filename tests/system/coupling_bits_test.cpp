// If every body is a member, the sub-world's run has the same bits as the direct run.
#include "tests/support/bits.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

struct Trace {
  std::vector<loop::TickOutput> ticks;
  std::vector<std::uint64_t> hashes;
};

Trace trace_of(sim::Scene scene, const session::RunOptions& options, std::uint64_t ticks) {
  auto session = make_session(std::move(scene), options);
  // A budget so large that the governor changes nothing: its cost prediction would differ between the runs when bodies
  // join.
  loop::GovernorConfig governor = session->governor->config();
  governor.budget = 1e6;
  *session->governor = loop::Governor(governor);
  Trace trace;
  run(*session, ticks, [&](const loop::TickOutput& out) {
    trace.ticks.push_back(out);
    trace.hashes.push_back(session->loop->state_hash());
    return true;
  });
  return trace;
}

}  // namespace

TEST_CASE("sub-world coupling with every body a member and ratio 1 gives the bits of direct coupling") {
  const std::string file = GENERATE("card_house.toml", "stack20.toml", "wall.toml");
  session::RunOptions direct = virtual_options();
  direct.coupling = haptics::CouplingScheme::kDirect;
  session::RunOptions sub_world = virtual_options();
  sub_world.all_members = true;
  sub_world.ratio = 1;
  constexpr std::uint64_t kTicks = 1500;
  const Trace a = trace_of(scene_file(file), direct, kTicks);
  const Trace b = trace_of(scene_file(file), sub_world, kTicks);
  REQUIRE(a.ticks.size() == kTicks);
  REQUIRE(b.ticks.size() == kTicks);
  std::uint64_t contact_ticks = 0;
  for (std::size_t i = 0; i < kTicks; ++i) {
    INFO(file << " tick " << i);
    REQUIRE(a.hashes[i] == b.hashes[i]);
    REQUIRE(same_bits(a.ticks[i].command.wrench.force, b.ticks[i].command.wrench.force));
    REQUIRE(same_bits(a.ticks[i].command.wrench.torque, b.ticks[i].command.wrench.torque));
    REQUIRE(a.ticks[i].members == b.ticks[i].members);
    REQUIRE(a.ticks[i].points == b.ticks[i].points);
    REQUIRE(b.ticks[i].border == 0);
    contact_ticks += (a.ticks[i].status & kProxyContact) != 0;
  }
  CHECK(contact_ticks > kTicks / 4);  // the hand was in it, so the comparison says something
}

TEST_CASE("a body that leaves the sub-world and joins again keeps its state and its warm start") {
  // Two members at most and three bodies: the far one is outside until the proxy has gone there.
  session::RunOptions options = virtual_options();
  auto session = make_session(scene_file("domino_row.toml"), options);
  std::uint32_t members_before = 0, joins = 0;
  double largest_jump_m = 0;
  std::vector<physics::Body> before;
  run(*session, 4000, [&](const loop::TickOutput& out) {
    const auto now = session->loop->sub_world().world().bodies();
    for (const auto& body : now) {
      for (const auto& old : before) {
        if (old.id != body.id) continue;
        const double speed = std::max(norm(body.motion.velocity.linear), norm(old.motion.velocity.linear));
        largest_jump_m =
            std::max(largest_jump_m, norm(body.motion.pose.position - old.motion.pose.position) - 1e-3 * speed);
      }
    }
    before.assign(now.begin(), now.end());
    joins += out.members > members_before ? out.members - members_before : 0;
    members_before = out.members;
    return true;
  });
  CHECK(joins > 0);
  // A tick moves a body by its velocity and pushes an overlap out with 0.25 m/s; more would be a jump.
  CHECK(largest_jump_m < 2.5e-4);
}
