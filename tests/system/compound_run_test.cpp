// Compounds in whole runs: in the hand, among the members, across the border, and on a tape.
#include "sim/global_world.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/replay.h"

using namespace tactus;
using namespace tactus::test;

namespace {

std::string replaced(std::string text, const std::string& own, const std::string& by) {
  const std::size_t at = text.find(own);
  REQUIRE(at != std::string::npos);
  return text.replace(at, own.size(), by);
}

// The ball of the press as a part of a tool: with a handle that touches nothing, or alone.
std::string pressed_by(const std::string& parts) {
  return replaced(kPressScene, "shape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.2\n",
                  "shape = \"compound\"\nmass_kg = 0.2\nparts = [" + parts + "]\n");
}
const std::string kBall = "{shape = \"sphere\", radius_m = 0.01}";

std::vector<Vec3d> forces(const std::string& text, std::uint64_t ticks) {
  std::vector<Vec3d> felt;
  auto session = make_session(scene_text(text), virtual_options());
  (void)run(*session, ticks, [&felt](const loop::TickOutput& out) {
    felt.push_back(out.command.wrench.force);
    return true;
  });
  return felt;
}

// Stools of a seat and four legs, on each other; the hand leans on the highest one, off its middle.
std::string stools(unsigned count, unsigned members) {
  std::string text =
      "effects = [\"gravity\", \"friction\", \"gyroscopic\"]\n[simulation]\nratio = 8\nmembers = " +
      std::to_string(members) +
      "\n[coupling]\nstiffness_N_per_m = 1500\ndamping_Ns_per_m = 5\nstiffness_Nm_per_rad = 4\n"
      "damping_Nms_per_rad = 0.01\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.2\nfriction = 0.5\n";
  const double top = 0.105 * count;
  text += "position_m = [0.01, 0, " + std::to_string(top + 0.02) + "]\n[device]\nposition_m = [0, 0, " +
          std::to_string(top) + "]\n[[body]]\nshape = \"plane\"\nfriction = 0.6\n";
  for (unsigned i = 0; i < count; ++i) {
    text += "[[body]]\nshape = \"compound\"\nmass_kg = 0.4\nfriction = 0.6\nposition_m = [0, 0, " +
            std::to_string(0.105 * i) +
            "]\nparts = [{shape = \"box\", size_m = [0.12, 0.12, 0.015], "
            "position_m = [0, 0, 0.0975]}";
    for (const char* at : {"0.05, 0.05", "-0.05, 0.05", "0.05, -0.05", "-0.05, -0.05"})
      text +=
          std::string(", {shape = \"cylinder\", radius_m = 0.008, length_m = 0.09, position_m = [") + at + ", 0.045]}";
    text += "]\n";
  }
  return text + "[hand]\nrepeat = false\npath = [{time_s = 0, position_m = [0.01, 0, " + std::to_string(top + 0.02) +
         "]}, {time_s = 0.5, position_m = [0.01, 0, " + std::to_string(top) + "]}]\n";
}

}  // namespace

TEST_CASE("a compound as proxy feels what its part feels, and a handle changes nothing that touches") {
  const auto plain = forces(kPressScene, 1500), one = forces(pressed_by(kBall), 1500);
  REQUIRE(plain.size() == one.size());
  double most = 0;
  for (std::size_t k = 0; k < plain.size(); ++k) most = std::max(most, norm(plain[k] - one[k]));
  CHECK(norm(plain.back()) > 1);
  CHECK(most < 1e-6);
  const std::string handle = ", {shape = \"sphere\", radius_m = 0.01, position_m = [0, 0, 0.04]}";
  CHECK(forces(pressed_by(kBall + handle), 1500).back().z > 1);
}

TEST_CASE("stools stand on each other under a hand, wherever the border is") {
  const unsigned members = GENERATE(2u, 3u, 8u);
  auto session = make_session(scene_text(stools(4, members)), virtual_options());
  const auto before = session->scene.bodies;
  double pressed = 0;
  (void)run(*session, 3000, [&pressed](const loop::TickOutput& out) {
    pressed = std::max(pressed, out.command.wrench.force.z);
    return true;
  });
  CAPTURE(members);
  CHECK(pressed > 1);
  for (const physics::Body& body : session->global->bodies()) {
    if (body.id == session->scene.proxy) continue;
    CAPTURE(body.id);
    CHECK(norm(body.motion.pose.position - before[body.id].motion.pose.position) < 1e-3);
  }
}

TEST_CASE("a run with compounds and cylinders replays with the same bits") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  options.record = tape.path();
  auto session = make_session(scene_file("cups.toml"), options);
  REQUIRE(session->record(options.record.string()).ok());
  const auto summary = run(*session, 2500);
  session.reset();
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  CHECK(report.value().different == 0);
  CHECK(report.value().state_hash == summary.state_hash);
}
