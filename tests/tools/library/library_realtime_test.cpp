// The public API in real time. Nothing here depends on how fast the machine is.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/tools/library/library_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

Options real_time() {
  Options options;
  options.real_time = true;
  options.priority = 0;
  return options;
}

}  // namespace

TEST_CASE("a run in real time shows each of its ticks to the monitor, once and in order", "[threads]") {
  Options options = real_time();
  options.history_ticks = 20'000;
  Session session = session_of(scene_of("press.toml"), options);
  std::uint64_t next = 0, lost = 0;
  std::size_t bodies = 0, in_monitor = 0;
  bool in_order = true, moved = false;
  const BodyState first = session.bodies()[session.scene().proxy()];
  const Error error = session.run(0.5, [&](const Progress& progress) {
    for (const Tick& tick : progress.ticks) in_order = in_order && tick.number == next++;
    lost += progress.ticks_lost;
    bodies = session.bodies().size();
    moved = moved || session.bodies()[session.scene().proxy()].position_m != first.position_m;
    in_monitor += session.contacts().size() + session.summary().text.size() + session.state_hash();
    CHECK(session.run(1).kind() == Error::Kind::kUse);
    CHECK(session.reset().kind() == Error::Kind::kUse);
    return true;
  });
  INFO(error.message());
  REQUIRE_FALSE(error);
  CHECK(in_order);
  CHECK(lost == 0);
  CHECK(next == 500);
  CHECK(session.ticks_done() == 500);
  CHECK(session.last().number == 499);
  CHECK(bodies == session.scene().bodies());
  CHECK(moved);
  CHECK(in_monitor == 0);
  CHECK(session.summary().ticks == 500);
  CHECK_THAT(session.summary().text, Contains("wake-up"));
  CHECK_FALSE(session.contacts().empty());
  CHECK_THAT(session.run(1).message(), Contains("reset()"));
  REQUIRE_FALSE(session.reset());
  REQUIRE_FALSE(session.run(0.05));
  CHECK(session.ticks_done() == 50);
  CHECK(session.ticks().size() == 50);
}

TEST_CASE("a monitor or another thread ends a run, and a short history says what it lacks", "[threads]") {
  Options options = real_time();
  options.history_ticks = 2;
  Session session = session_of(scene_of("press.toml"), options);
  std::uint64_t seen = 0, lost = 0;
  REQUIRE_FALSE(session.run(0, [&](const Progress& progress) {
    CHECK(progress.ticks.size() <= 2);
    seen += progress.ticks.size();
    lost += progress.ticks_lost;
    return seen < 10;
  }));
  CHECK(lost > 0);
  CHECK(seen + lost == session.ticks_done());
  REQUIRE_FALSE(session.reset());
  std::atomic<bool> ticks{false};
  std::thread other([&] {
    ticks.wait(false);
    session.stop();
  });
  REQUIRE_FALSE(session.run(0, [&](const Progress& progress) {
    if (progress.ticks.empty()) return true;
    ticks = true;
    ticks.notify_all();
    return true;
  }));
  other.join();
  CHECK(session.ticks_done() > 0);
}

TEST_CASE("a recorded run that ends with a fault leaves its last seconds beside it, and says where", "[threads]") {
  namespace fs = std::filesystem;
  const fs::path before = fs::current_path(), folder = fs::temp_directory_path() / "tactus-fault-tape-test";
  fs::create_directories(folder);
  fs::current_path(folder);
  std::ofstream("tactus-fault.tape") << "an earlier one";
  const bool faulty = GENERATE(true, false);
  Options options = real_time();
  if (faulty) options.inject = "estop@200+10000";
  Session session = session_of(scene_of("press.toml"), options);
  REQUIRE_FALSE(session.record("mine.tape"));
  const Error error = session.run(0.4);
  const std::string text = session.summary().text;
  REQUIRE_FALSE(session.close());
  Replay whole, last;
  const Error mine = replay_tape("mine.tape", whole), fault = replay_tape("tactus-fault.tape", last);
  fs::current_path(before);
  fs::remove_all(folder);
  INFO(error.message() << mine.message() << text);
  REQUIRE_FALSE(error);
  REQUIRE_FALSE(mine);
  CHECK(whole.ticks == 400);
  if (faulty) {  // without a fault a tick that was lost to own work may leave one, too
    CHECK_THAT(text, Contains("flight recorder        tactus-fault.tape"));
    INFO(fault.message());
    REQUIRE_FALSE(fault);
    CHECK(last.ticks > 200);
    CHECK(last.same_bits);
  }
}
