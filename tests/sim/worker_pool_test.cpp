#include "sim/worker_pool.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <numeric>

#include "rt/base/denormals.h"
#include "tests/sim/global_world_bench.h"
#include "tests/support/physics_bench.h"

namespace {

using namespace tactus;
using namespace tactus::sim;

// Cubes that were thrown onto a heap and among each other, in every direction; the first one is the proxy.
Scene stirred_heap(std::uint32_t cubes) {
  Scene scene;
  scene.effects = {true, true, true};
  test::Random random(11);
  const auto shape = physics::Shape::box({0.05, 0.05, 0.05});
  for (std::uint32_t i = 0; i < cubes; ++i) {
    const Vec3d place{0.105 * (i % 8), 0.105 * (i / 8 % 8), 0.06 + 0.11 * (i / 64)};
    auto body = physics::make_dynamic_body(i, shape, 0.2 + 0.1 * (i % 3), 0.5, {place, {}});
    body.motion.velocity = {random.vector(0.6), random.vector(2)};
    scene.bodies.push_back(body);
  }
  scene.proxy = 0;
  scene.bodies.push_back(physics::make_fixed_body(cubes, physics::Shape::plane(), 0.5, {}));
  return scene;
}

struct Trace {
  std::vector<std::uint64_t> hashes;
  std::uint32_t contacts{0};
};

Trace run(const Scene& scene, std::uint32_t threads, int steps) {
  WorkerPool pool(threads);
  GlobalWorld world(scene, tactus::test::capped_border());
  world.share_work(pool);
  auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  auto report = std::make_unique<haptics::SubWorldReport>();
  world.first_snapshot(*snapshot);
  Trace trace;
  for (int step = 0; step < steps; ++step) {
    report->cycle = snapshot->cycle;
    world.step(*report, *snapshot);
    trace.hashes.push_back(world.state_hash());
  }
  trace.contacts = world.statistics().most_contacts;
  return trace;
}

}  // namespace

TEST_CASE("every index is in one range, whatever the number of threads and of indices", "[threads]") {
  set_denormals_flush();
  const std::uint32_t threads = GENERATE(1u, 2u, 3u, 5u);
  WorkerPool pool(threads);
  CHECK(pool.threads() == threads);
  const physics::Executor executor = pool.executor();
  CHECK(executor.shares() == (threads > 1));
  std::vector<std::uint32_t> done;
  for (std::uint32_t count = 0; count < 300; ++count) {
    for (const std::uint32_t grain : {1u, 7u, 100u}) {
      done.assign(count, 0);
      executor.for_each_range(count, grain, [&](std::uint32_t k, std::uint32_t end) noexcept {
        for (; k < end; ++k) ++done[k];
      });
      REQUIRE(std::count(done.begin(), done.end(), 1u) == static_cast<std::ptrdiff_t>(count));
    }
  }
}

TEST_CASE("no range is shorter than the grain", "[threads]") {
  set_denormals_flush();
  WorkerPool pool(4);
  for (std::uint32_t count = 1; count < 100; ++count) {
    std::atomic<std::uint32_t> shortest{count};
    pool.executor().for_each_range(count, 8, [&](std::uint32_t k, std::uint32_t end) noexcept {
      std::uint32_t now = shortest.load();
      while (end - k < now && !shortest.compare_exchange_weak(now, end - k)) {}
    });
    REQUIRE(shortest.load() >= std::min(8u, count));
  }
}

// The caller works on ranges too. When it returns, every range is done, whichever thread did it.
TEST_CASE("what is written before is seen by every range, and what ranges write is seen after", "[threads]") {
  set_denormals_flush();
  WorkerPool pool(3);
  std::vector<std::uint64_t> in(64), out(64);
  for (std::uint64_t round = 1; round < 20'000; ++round) {
    for (auto& value : in) value = round;
    pool.executor().for_each_range(64, 4, [&](std::uint32_t k, std::uint32_t end) noexcept {
      for (; k < end; ++k) out[k] = in[k] + k;
    });
    REQUIRE(std::accumulate(out.begin(), out.end(), std::uint64_t{0}) == 64 * round + 63 * 32);
    // Now and then long enough for the workers to go to sleep.
    if (round % 5000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

TEST_CASE("the global world's bits do not depend on how many threads share its steps", "[threads]") {
  set_denormals_flush();
  const Scene scene = stirred_heap(320);
  constexpr int kSteps = 25;
  const Trace alone = run(scene, 1, kSteps);
  REQUIRE(alone.contacts > 500);  // so that there is work to share
  for (const std::uint32_t threads : {2u, 3u, 4u}) {
    const Trace shared = run(scene, threads, kSteps);
    INFO(threads << " threads; the last hashes " << std::hex << alone.hashes.back() << " " << shared.hashes.back());
    CHECK(shared.hashes == alone.hashes);
  }
}
