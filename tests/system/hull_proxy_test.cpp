// A convex hull in the hand: it feels what the same solid feels as a box, on bodies and on a mesh, and replays.
#include <fstream>
#include <sstream>

#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/replay.h"

using namespace tactus;
using namespace tactus::test;

namespace {

const std::string kBox = "shape = \"box\"\nsize_m = [0.02, 0.02, 0.02]\nmass_kg = 0.2\n";
const std::string kHull =
    "shape = \"hull\"\nmass_kg = 0.2\n"
    "points_m = [[-0.01, -0.01, -0.01], [0.01, -0.01, -0.01], [-0.01, 0.01, -0.01], [0.01, 0.01, -0.01],\n"
    "            [-0.01, -0.01, 0.01], [0.01, -0.01, 0.01], [-0.01, 0.01, 0.01], [0.01, 0.01, 0.01]]\n";

std::string replaced(std::string text, const std::string& own, const std::string& by) {
  const std::size_t at = text.find(own);
  REQUIRE(at != std::string::npos);
  return text.replace(at, own.size(), by);
}

std::string pressed_by(const std::string& proxy) {
  return replaced(kPressScene, "shape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.2\n", proxy);
}

struct Felt {
  std::vector<Vec3d> force;
  std::uint64_t contact_ticks{0};
};

Felt felt_by(const std::string& proxy, std::uint64_t ticks) {
  Felt felt;
  auto session = make_session(scene_text(pressed_by(proxy)), virtual_options());
  (void)run(*session, ticks, [&felt](const loop::TickOutput& out) {
    felt.force.push_back(out.command.wrench.force);
    if ((out.status & kProxyContact) != 0) ++felt.contact_ticks;
    return true;
  });
  return felt;
}

}  // namespace

TEST_CASE("a hull as proxy feels what a box of its shape feels") {
  const Felt box = felt_by(kBox, 2500), hull = felt_by(kHull, 2500);
  CHECK(hull.contact_ticks > 1500);
  CHECK(hull.contact_ticks == box.contact_ticks);
  REQUIRE(hull.force.size() == box.force.size());
  CHECK(norm(box.force.back()) > 1);
  double most = 0;
  for (std::size_t k = 0; k < box.force.size(); ++k) most = std::max(most, norm(hull.force[k] - box.force[k]));
  CHECK(most < 0.05);  // boxes that hardly move are carried over, hulls recomputed
}

TEST_CASE("a run with a hull as proxy on a mesh replays with the same bits") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  const auto all = haptics::kCouplingSchemes;
  options.coupling = GENERATE_COPY(from_range(all.begin(), all.end()));
  options.record = tape.path();
  std::ifstream file(TACTUS_SOURCE_DIR "/sim/scenes/terrain.toml");
  std::stringstream terrain;
  terrain << file.rdbuf();
  std::string text = replaced(terrain.str(), "shape = \"sphere\"\nradius_m = 0.012\nmass_kg = 0.1\n", kHull);
  text = replaced(text, "shapes/terrain.obj", TACTUS_SOURCE_DIR "/sim/scenes/shapes/terrain.obj");
  const TemporaryFile scene_beside;
  std::ofstream(scene_beside.path()) << text;
  auto scene = sim::load_scene(scene_beside.path());
  INFO(scene.message());
  REQUIRE(scene.ok());
  auto session = make_session(std::move(scene).value(), options);
  REQUIRE(session->record(options.record.string()).ok());
  std::uint64_t felt_ticks = 0;
  const auto summary = run(*session, 2000, [&felt_ticks](const loop::TickOutput& out) {
    if (norm(out.command.wrench.force) > 0.1) ++felt_ticks;
    return true;
  });
  session.reset();
  CHECK(felt_ticks > 50);
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  CHECK(report.value().different == 0);
  CHECK(report.value().state_hash == summary.state_hash);
}
