#include "sim/global_thread.h"

#include <catch2/catch.hpp>
#include <memory>
#include <thread>

#include "rt/base/denormals.h"
#include "tests/sim/global_world_bench.h"

namespace {

using namespace tactus;
using namespace tactus::sim;

Scene pile() {
  Scene scene;
  scene.effects = {true, true, true};
  for (unsigned i = 0; i < 12; ++i)
    scene.bodies.push_back(physics::make_dynamic_body(i, physics::Shape::box({0.05, 0.05, 0.05}), 0.2, 0.5,
                                                      {{0.02 * (i % 3), 0, 0.05 + 0.11 * i}, {}}));
  scene.proxy = 0;
  scene.bodies.push_back(physics::make_fixed_body(12, physics::Shape::plane(), 0.5, {}));
  return scene;
}

// What a device might have done in cycle n: any report will do, as long as both runs get the same.
void fill_report(haptics::SubWorldReport& report, std::uint64_t n) {
  report = {};
  report.cycle = n;
  report.ticks = 10;
  report.mean_device_wrench.force = {0.1 * static_cast<double>(n % 7), 0, 1};
}

// The snapshots' essence, one after the other.
using Trail = std::vector<std::pair<Vec3d, std::uint32_t>>;

void record(Trail& trail, const haptics::WorldSnapshot& snapshot) {
  trail.emplace_back(snapshot.proxy.pose.position, snapshot.members.size());
}

constexpr std::uint64_t kCycles = 60;

Trail run_in_one_thread() {
  const Scene scene = pile();
  GlobalWorld world(scene, tactus::test::capped_border());
  auto exchange = std::make_unique<haptics::Exchange>();
  SnapshotServer server(world, *exchange);
  server.publish_first();
  Trail trail;
  for (std::uint64_t n = 0; n < kCycles; ++n) {
    record(trail, *exchange->snapshots.try_read(n));
    CHECK_FALSE(server.serve());  // no report, no step
    fill_report(exchange->reports.writing(n), n);
    exchange->reports.publish(n);
    CHECK(server.serve());
  }
  return trail;
}

Trail run_in_two_threads(const GlobalThreadOptions& options, GlobalThread::Progress& progress, std::uint64_t& timed) {
  const Scene scene = pile();
  GlobalWorld world(scene, tactus::test::capped_border());
  auto exchange = std::make_unique<haptics::Exchange>();
  GlobalThread thread(world, *exchange, options);
  (void)thread.start();
  Trail trail;
  for (std::uint64_t n = 0; n < kCycles; ++n) {
    const haptics::WorldSnapshot* snapshot = nullptr;
    while ((snapshot = exchange->snapshots.try_read(n)) == nullptr) std::this_thread::yield();
    CHECK(snapshot->cycle == n);
    record(trail, *snapshot);
    fill_report(exchange->reports.writing(n), n);
    exchange->reports.publish(n);
  }
  while (exchange->snapshots.try_read(kCycles) == nullptr) std::this_thread::yield();
  thread.stop();
  progress = thread.progress();
  timed = thread.step_times().count();
  return trail;
}

}  // namespace

TEST_CASE("The thread gives the same snapshots as one thread does, stalled or not", "[threads]") {
  set_denormals_flush();
  const Trail expected = run_in_one_thread();
  GlobalThreadOptions options;
  if (GENERATE(false, true)) options.stalls = {{5, std::chrono::milliseconds(30)}, {6, std::chrono::milliseconds(1)}};
  GlobalThread::Progress progress;
  std::uint64_t timed = 0;
  CHECK(run_in_two_threads(options, progress, timed) == expected);
  CHECK(progress.cycles == kCycles);
  CHECK(timed == kCycles);
  CHECK(progress.longest_step_ns >= progress.last_step_ns);
}

TEST_CASE("A CPU that is not there is reported, and the thread runs elsewhere", "[threads]") {
  const Scene scene = pile();
  GlobalWorld world(scene, tactus::test::capped_border());
  auto exchange = std::make_unique<haptics::Exchange>();
  GlobalThreadOptions options;
  options.cpu = 100'000;
  GlobalThread thread(world, *exchange, options);
  const Status status = thread.start();
  CHECK_FALSE(status.ok());
  CHECK(status.message().find("100000") != std::string::npos);
  fill_report(exchange->reports.writing(0), 0);
  exchange->reports.publish(0);
  while (exchange->snapshots.try_read(1) == nullptr) std::this_thread::yield();
  thread.stop();
  CHECK(thread.progress().cycles == 1);
}

TEST_CASE("A stall does not keep the thread from stopping", "[threads]") {
  const Scene scene = pile();
  GlobalWorld world(scene, tactus::test::capped_border());
  auto exchange = std::make_unique<haptics::Exchange>();
  GlobalThreadOptions options;
  options.stalls = {{0, std::chrono::hours(24)}};
  GlobalThread thread(world, *exchange, options);
  (void)thread.start();
  fill_report(exchange->reports.writing(0), 0);
  exchange->reports.publish(0);
  thread.stop();
  SUCCEED();
}

TEST_CASE("A world of several devices waits for all of them, but not for one that has stopped") {
  const Scene scene = pile();
  GlobalOptions two = tactus::test::capped_border();
  two.more_devices = {{.proxy = 7}};
  GlobalWorld world(scene, two);
  auto one = std::make_unique<haptics::Exchange>(), other = std::make_unique<haptics::Exchange>();
  SnapshotServer server(world, {one.get(), other.get()});
  server.publish_first();
  const auto report = [](haptics::Exchange& exchange, std::uint64_t n) {
    fill_report(exchange.reports.writing(n), n);
    exchange.reports.publish(n);
  };
  CHECK_FALSE(server.is_waited_for());
  report(*one, 0);
  CHECK(server.is_waited_for());
  CHECK_FALSE(server.serve());
  report(*other, 0);
  CHECK(server.serve());
  REQUIRE(one->snapshots.try_read(1) != nullptr);
  REQUIRE(other->snapshots.try_read(1) != nullptr);

  report(*one, 1);
  CHECK_FALSE(server.serve());
  server.leave_out_the_missing();
  CHECK(server.serve());
  report(*one, 2);
  CHECK(server.serve());
  CHECK(one->snapshots.try_read(3) != nullptr);
  CHECK(other->snapshots.try_read(2) == nullptr);  // not before its report

  report(*other, 1);  // it is back: from now on it is waited for
  report(*one, 3);
  CHECK(server.serve());
  CHECK(other->snapshots.try_read(2) != nullptr);
  report(*one, 4);
  CHECK_FALSE(server.serve());
  CHECK(world.statistics().steps == 4);
}

TEST_CASE("The thread goes on without a device that has stopped", "[threads]") {
  const Scene scene = pile();
  GlobalOptions two = tactus::test::capped_border();
  two.more_devices = {{.proxy = 7}};
  GlobalWorld world(scene, two);
  auto one = std::make_unique<haptics::Exchange>(), other = std::make_unique<haptics::Exchange>();
  GlobalThread thread(world, {one.get(), other.get()}, {});
  (void)thread.start();
  for (std::uint64_t n = 0; n < 5; ++n) {
    while (one->snapshots.try_read(n) == nullptr) std::this_thread::yield();
    fill_report(one->reports.writing(n), n);
    one->reports.publish(n);
  }
  while (one->snapshots.try_read(5) == nullptr) std::this_thread::yield();
  thread.stop();
  CHECK(thread.progress().cycles == 5);
  CHECK(other->snapshots.try_read(1) == nullptr);
}
