// More threads for the global world: the options, and the bits of whole runs.
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

TEST_CASE("a virtual run gives the same bits for any number of world threads", "[threads]") {
  const auto hashes_with = [](unsigned threads) {
    session::RunOptions options = virtual_options();
    options.world_threads = threads;
    auto session = make_session(scene_file("pile700.toml"), options);
    const auto summary = run(*session, 150);
    CHECK(summary.global.steps >= 10);
    return std::pair(summary.state_hash, session->global->state_hash());
  };
  const auto alone = hashes_with(1);
  CHECK(hashes_with(2) == alone);
  CHECK(hashes_with(3) == alone);
}

TEST_CASE("world threads and their cores have to go together") {
  session::RunOptions options = virtual_options();
  options.world_threads = 2;
  CHECK(check_options(options).ok());
  options.world_cpus = {1, 3};
  CHECK(check_options(options).ok());
  options.world_cpus = {1, 2, 3};
  CHECK_THAT(check_options(options).message(), Contains("--world-cpu: 3 cores for 2") && Contains("accepted: "));
  options.world_cpus = {};
  for (const unsigned threads : {0u, 65u}) {
    options.world_threads = threads;
    CHECK_THAT(check_options(options).message(), Contains("--world-threads") && Contains("accepted: 1 to 64"));
  }
}

TEST_CASE("a core that is not there ends a run with one line that names it", "[threads]") {
  session::RunOptions options = virtual_options();
  options.world_threads = 2;
  options.world_cpus = {0, 1023};
  auto session = make_session(scene_text(kPressScene), options);
  const auto summary = session::run_virtual(*session, 1);
  REQUIRE_FALSE(summary.ok());
  CHECK_THAT(summary.message(), Contains("CPU 1023"));
}
