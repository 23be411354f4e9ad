// The world outside of the sub-world follows from a tape: stepped again, it sends the taped snapshots, byte by byte.
#include "tools/session/world_rebuilder.h"

#include <filesystem>

#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

struct Rebuilt {
  std::uint64_t snapshots{0}, taped{0};
  std::string error;
  std::vector<physics::Body> bodies;  // of the rebuilt world at the end
};

Rebuilt rebuild(const std::string& path, bool forget_budget = false) {
  auto tape = session::open_tape(path);
  REQUIRE(tape.ok());
  auto session = session::session_of(tape.value());
  REQUIRE(session.ok());
  Rebuilt result;
  result.error = session::why_not_rebuilt(tape.value());
  if (!result.error.empty()) return result;
  session::TapePlayer player(std::move(session.value()->loop));
  session::WorldRebuilder rebuilder(*session.value()->global);
  const auto take = [&](const loop::TapeRecord& record) {
    bool same = true;
    if (record.kind == loop::kKeyframeRecord) return player.take_keyframe(record, same);
    if (record.kind == loop::kSnapshotRecord) {
      ++result.taped;
      const Status status = rebuilder.take_snapshot(record);
      return status.ok() ? player.take_snapshot(record) : status;
    }
    if (record.kind != loop::kTickRecord) return Status::good();
    const auto taped = session::tick_of(record);
    loop::TickOutput out;
    REQUIRE(player.play(taped.value(), out));
    if (taped.value().adopts == 0) return Status::good();
    return rebuilder.adopted(player.report(), forget_budget ? 0 : taped.value().member_budget);
  };
  const Status walked = session::walk(tape.value(), {.record = take, .damage = {}, .progress = {}});
  result.error = walked.message();
  result.snapshots = rebuilder.snapshots();
  const auto bodies = rebuilder.world().bodies();
  result.bodies.assign(bodies.begin(), bodies.end());
  return result;
}

std::string record_run(const TemporaryFile& tape, const std::string& scene, session::RunOptions options,
                       std::uint64_t ticks) {
  options.record = tape.path();
  auto session = make_session(scene_file(scene), options);
  REQUIRE(session->record(tape.path()).ok());
  (void)run(*session, ticks);
  return tape.path();
}

void check_rebuilt(const std::string& scene, std::uint64_t ticks, std::uint64_t least_snapshots) {
  INFO(scene);
  const TemporaryFile tape;
  const Rebuilt rebuilt = rebuild(record_run(tape, scene, virtual_options(), ticks));
  CHECK(rebuilt.error == "");
  CHECK(rebuilt.taped > least_snapshots);
  CHECK(rebuilt.snapshots == rebuilt.taped);
}

}  // namespace

TEST_CASE("the world of a tape is rebuilt, snapshot by snapshot, on every kind of scene", "[slow]") {
  const std::string scene = GENERATE("card_house.toml", "chain.toml", "cups.toml", "domino_row.toml", "free.toml",
                                     "incline.toml", "peg_in_shaft.toml", "pile250.toml", "press.toml", "stack20.toml",
                                     "stones.toml", "terrain.toml", "tower.toml", "wall.toml", "workshop.toml");
  check_rebuilt(scene, 1500, 100);
}

TEST_CASE("the world of a tape is rebuilt, snapshot by snapshot, in large heaps", "[slow]") {
  const std::string scene = GENERATE("pile700.toml", "pile5000.toml");
  check_rebuilt(scene, 450, 20);
}

TEST_CASE("the world of a tape is rebuilt, snapshot by snapshot, of 50 thousand bodies", "[.long]") {
  check_rebuilt("heaps50k.toml", 450, 20);
}

TEST_CASE("every scene is among those whose world is rebuilt") {
  std::size_t scenes = 0;
  for (const auto& file : std::filesystem::directory_iterator(TACTUS_SOURCE_DIR "/sim/scenes"))
    if (file.path().extension() == ".toml") ++scenes;
  CHECK(scenes == 15 + 2 + 1);
}

TEST_CASE("the world is rebuilt whatever the coupling, the precision, a late world and a reset") {
  session::RunOptions options = virtual_options();
  const auto variant = GENERATE(0, 1, 2, 3, 4, 5, 6);
  INFO(variant);
  if (variant == 0) options.coupling = haptics::CouplingScheme::kStatic;
  if (variant == 1) options.coupling = haptics::CouplingScheme::kInterpolation;
  if (variant == 2) options.border = physics::BorderMode::kReplay;
  if (variant == 3) options.world_precision = physics::SweepPrecision::kFull;
  if (variant == 4) options.inject = "stall@300+90";
  if (variant == 5) options.inject = "reset@700";
  if (variant == 6) options.members = 9;
  const TemporaryFile tape;
  const Rebuilt rebuilt = rebuild(record_run(tape, "card_house.toml", options, 2500));
  CHECK(rebuilt.error == "");
  CHECK(rebuilt.taped > 100);
  CHECK(rebuilt.snapshots == rebuilt.taped);
}

TEST_CASE("the rebuilt world is the run's own") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  options.record = tape.path();
  auto session = make_session(scene_file("card_house.toml"), options);
  REQUIRE(session->record(tape.path()).ok());
  session::VirtualRun virtual_run(*session);
  std::vector<physics::Body> bodies;  // as they were when the snapshot that was adopted last was made
  for (int tick = 0; tick < 1200; ++tick) {
    (void)virtual_run.tick();
    if (session->driver->synchronised()) {
      const auto served = session->global->bodies();
      bodies.assign(served.begin(), served.end());
    }
  }
  session::RunSummary summary;
  session->close_tape(summary);
  session.reset();
  const Rebuilt rebuilt = rebuild(tape.path());
  REQUIRE(rebuilt.error == "");
  REQUIRE(rebuilt.bodies.size() == bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i)
    CHECK(std::memcmp(&rebuilt.bodies[i].motion, &bodies[i].motion, sizeof bodies[i].motion) == 0);
}

TEST_CASE("what a tape lacks to rebuild its world is reported") {
  const TemporaryFile direct, older;
  session::RunOptions options = virtual_options();
  options.coupling = haptics::CouplingScheme::kDirect;
  CHECK(rebuild(record_run(direct, "card_house.toml", options, 100)).error ==
        "the direct coupling has no world outside");
  const std::string path = record_run(older, "card_house.toml", virtual_options(), 100);
  CHECK(rebuild(path, true).error.ends_with("an older tape, without what the governor allowed"));
}
