// Same tape, same bits: twice, of every build, virtual and real time, with and without recording.
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/model/choice_names.h"
#include "tests/support/run_command.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/realtime_run.h"
#include "tools/session/replay.h"

using namespace tactus;
using namespace tactus::test;

namespace {

std::uint64_t hash_of_run(const std::string& file, const session::RunOptions& options, std::uint64_t ticks) {
  auto session = make_session(scene_file(file), options);
  return run(*session, ticks).state_hash;
}

// Every one there is, a run of the test each.
haptics::CouplingScheme any_coupling() {
  const auto all = haptics::kCouplingSchemes;
  return GENERATE_COPY(from_range(all.begin(), all.end()));
}
// The sub-world with every border; the others have none.
std::pair<haptics::CouplingScheme, physics::BorderMode> any_coupling_and_border() {
  std::vector<std::pair<haptics::CouplingScheme, physics::BorderMode>> all;
  for (const auto coupling : haptics::kCouplingSchemes)
    if (coupling != haptics::CouplingScheme::kSubWorld) all.emplace_back(coupling, physics::BorderMode::kGhost);
  for (const auto border : physics::kBorderModes) all.emplace_back(haptics::CouplingScheme::kSubWorld, border);
  return GENERATE_COPY(from_range(all.begin(), all.end()));
}

std::string program_output(const std::string& command) {
  INFO(command);
  const test::CommandOutput output = test::run_command(command);
  REQUIRE(output.exit_code == 0);
  return output.out;
}

}  // namespace

TEST_CASE("the same run in virtual time gives the same bits twice, and others with another scene") {
  const auto options = virtual_options();
  const std::uint64_t once = hash_of_run("card_house.toml", options, 1000);
  CHECK(once == hash_of_run("card_house.toml", options, 1000));
  CHECK(once != hash_of_run("wall.toml", options, 1000));
}

TEST_CASE("a recorded run on a triangle mesh replays with the same bits, whatever the coupling") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  options.coupling = any_coupling();
  options.record = tape.path();
  options.inject = "stall@900+60";  // members outrun the triangles that came with the snapshot
  auto session = make_session(scene_file("terrain.toml"), options);
  REQUIRE(session->record(options.record.string()).ok());
  const auto summary = run(*session, 2500);
  session.reset();
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  CHECK(report.value().compared == 2500);
  CHECK(report.value().different == 0);
  CHECK(report.value().keyframes_different == 0);
  CHECK(report.value().state_hash == summary.state_hash);
}

TEST_CASE("recording changes no bit") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  const std::uint64_t plain = hash_of_run("card_house.toml", options, 1500);
  options.record = tape.path();
  auto session = make_session(scene_file("card_house.toml"), options);
  REQUIRE(session->record(options.record.string()).ok());
  CHECK(run(*session, 1500).state_hash == plain);
}

TEST_CASE("a recorded virtual run replays with the same bits, whatever the coupling and the border") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  std::tie(options.coupling, options.border) = any_coupling_and_border();
  options.record = tape.path();
  options.members = 8;
  options.inject = "lost/state@700+4,stall@900+60";
  if (options.coupling != haptics::CouplingScheme::kDirect) options.inject += ",reset@1400";
  auto session = make_session(scene_file("card_house.toml"), options);
  REQUIRE(session->record(options.record.string()).ok());
  const auto summary = run(*session, 2500);
  session.reset();
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  INFO(report.value().first_difference);
  CHECK(report.value().good());
  CHECK(report.value().compared == 2500);
  CHECK(report.value().keyframes >= 2);
  CHECK(report.value().state_hash == summary.state_hash);
}

TEST_CASE("a recorded real-time run replays with the same bits", "[threads]") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  options.virtual_time = false;
  options.duration_s = 2;
  options.record = tape.path();
  auto session = make_session(scene_text(kPressScene), options);
  REQUIRE(session->record(options.record.string()).ok());
  std::atomic<bool> stop{false};
  const auto summary = session::run_realtime(*session, {}, stop);
  INFO(summary.message());
  REQUIRE(summary.ok());
  const std::uint64_t ticks = summary.value().stats.ticks;
  CHECK(ticks == 2000);
  session.reset();
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  INFO(report.value().first_difference);
  CHECK(report.value().good());
  CHECK(report.value().compared + report.value().unreplayable == ticks);
  CHECK(report.value().unreplayable == 0);
}

TEST_CASE("a replay detects one changed bit of one input") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  options.record = tape.path();
  auto session = make_session(scene_text(kPressScene), options);
  REQUIRE(session->record(options.record.string()).ok());
  run(*session, 1200);
  session.reset();
  // Copied record by record, one device sample nudged by one unit in the last place.
  const TemporaryFile nudged;
  auto in = loop::TapeReader::open(tape.path());
  REQUIRE(in.ok());
  auto out = loop::TapeWriter::create(nudged.path(), in.value()->text());
  REQUIRE(out.ok());
  loop::TapeRecord record;
  while (in.value()->next(record) == loop::TapeRead::kRecord) {
    std::vector<std::byte> payload(record.payload.begin(), record.payload.end());
    if (record.kind == loop::kTickRecord) {
      loop::TickRecord tick;
      REQUIRE(payload.size() == sizeof tick);
      std::memcpy(&tick, payload.data(), sizeof tick);
      double& z = tick.device.sample.device_from_tool.position.z;
      if (tick.out.tick == 900) z = std::nextafter(z, 1.0);
      std::memcpy(payload.data(), &tick, sizeof tick);
    }
    REQUIRE(out.value()->write(record.kind, payload).ok());
  }
  REQUIRE(out.value()->close().ok());
  const auto report = session::replay(nudged.path());
  REQUIRE(report.ok());
  CHECK_FALSE(report.value().good());
  CHECK(report.value().first_different_tick == 900);
}

TEST_CASE("a replay says what a damaged record took, and goes on at the next keyframe") {
  const TemporaryFile tape;
  session::RunOptions options = virtual_options();
  options.record = tape.path();
  auto session = make_session(scene_text(kPressScene), options);
  REQUIRE(session->record(options.record.string()).ok());
  run(*session, 2500);  // keyframes before the ticks 0, 1000 and 2000
  session.reset();
  Bytes bytes = tape.read();
  std::uint64_t damaged_at = 0, size = 0;
  {
    auto in = loop::TapeReader::open(tape.path());
    REQUIRE(in.ok());
    loop::TapeRecord record;
    for (loop::TickRecord tick; in.value()->next(record) == loop::TapeRead::kRecord;) {
      if (record.kind != loop::kTickRecord) continue;
      std::memcpy(&tick, record.payload.data(), sizeof tick);
      if (tick.out.tick == 300) {
        damaged_at = record.offset;
        size = 12 + record.payload.size();
      }
    }
  }
  REQUIRE(damaged_at > 0);
  bytes[damaged_at + size / 2] ^= std::byte{1};
  tape.write(bytes);
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  CHECK_FALSE(report.value().good());
  CHECK(report.value().same_bits());
  CHECK(report.value().damages == 1);
  CHECK(report.value().lost_ticks == 1);
  CHECK(report.value().lost_bytes == size);
  CHECK(report.value().unreplayable == 699);
  CHECK(report.value().compared == 1800);
  CHECK_THAT(report.value().damage, Catch::Matchers::Contains("at byte " + std::to_string(damaged_at)));

  bytes.resize(damaged_at + size - 1);  // the end is missing, as after a power cut
  tape.write(bytes);
  const auto cut = session::replay(tape.path());
  REQUIRE(cut.ok());
  CHECK_FALSE(cut.value().good());
  CHECK(cut.value().compared == 300);
  CHECK(cut.value().lost_bytes == size - 1);
}

TEST_CASE("a full disk ends the tape but not the run, which reports it") {
  const TemporaryFile tape;
  const std::string small = "bash -c 'ulimit -f 200; exec ";  // of 1024 bytes
  const std::string text = program_output(
      small + TACTUS_PROGRAM " run " TACTUS_SOURCE_DIR "/sim/scenes/free.toml --virtual-time --duration 3 --record " +
      tape.path() + "'");
  CHECK_THAT(text, Catch::Matchers::Contains("3000 ticks") && Catch::Matchers::Contains("DEGRADED: tape '") &&
                       Catch::Matchers::Contains("File too large") && Catch::Matchers::Contains("ticks are not on it"));
}

TEST_CASE("every build gives the same state hash: gcc and clang, optimised, for a debugger, sanitised",
          "[determinism]") {
  const std::string scene = GENERATE("card_house.toml", "wall.toml", "free.toml", "pile700.toml");
  const std::string arguments = " " TACTUS_SOURCE_DIR "/sim/scenes/" + scene + " 1500";
  const std::string ours = program_output(TACTUS_HASH + arguments);
  int others = 0;
  for (const std::string preset : {"release", "debug", "clang", "asan"}) {
    const std::string program = TACTUS_BUILDS "/" + preset + "/tests/state_hash";
    if (program == TACTUS_HASH || !std::filesystem::exists(program)) continue;
    INFO(program);
    CHECK(ours == program_output(program + arguments));
    ++others;
  }
  if (others == 0) FAIL("build state_hash of another preset first, such as asan, in " TACTUS_BUILDS);
  // The program's own run of the same ticks.
  const auto run = nlohmann::json::parse(program_output(TACTUS_PROGRAM " run " TACTUS_SOURCE_DIR "/sim/scenes/" +
                                                        scene + " --virtual-time --duration 1.5 --json"));
  CHECK(run["state_hash"].get<std::string>() + "\n" == ours);
  CHECK(run["run"]["ticks"] == 1500);
}
