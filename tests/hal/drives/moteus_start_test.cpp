// A moteus on its way from stopped to position mode: because it restarted, because another program stopped it, or
// because force is wanted.
#include "hal/drives/drive_faults.h"
#include "tests/hal/drives/drive_bench.h"

using namespace tactus;
using namespace tactus::hal;
using namespace tactus::test;
using Catch::Matchers::Contains;
using haptics::DeviceState;
using Bench = DriveBench;

TEST_CASE("drives: a moteus that restarts, however shortly, or that another program stops, brakes the arm") {
  struct Case {
    DriveFaultKind kind;
    unsigned periods;  // without received commands
    bool first_answer_lost;
  };
  std::vector<Case> cases;
  for (unsigned periods = 1; periods < 10; ++periods)
    for (const bool lost : {false, true})
      if (periods + (lost ? 1 : 0) < 10)  // with more, kDriveSilent is reported
        cases.push_back({DriveFaultKind::kRestarted, periods, lost});
  for (const bool lost : {false, true}) cases.push_back({DriveFaultKind::kDisabled, 1, lost});
  for (const double force_N : {0.0, 2.0})  // the commanded force makes no difference
    for (const Case& c : cases) {
      CAPTURE(static_cast<int>(c.kind), c.periods, c.first_answer_lost, force_N);
      Bench bench(point_arm_of(DriveFamily::kMoteus));
      bench.command.wrench.force = {force_N, 0, 0};
      bench.want(DeviceState::kForce, 2 * kMoteusStart);
      REQUIRE(bench.input.sample.state == DeviceState::kForce);
      REQUIRE(bench.device->world().drive(1).enabled());
      bench.inject(c.kind, 1, c.periods);
      const unsigned deaf = c.kind == DriveFaultKind::kRestarted ? c.periods : 0;
      if (c.first_answer_lost)
        bench.device->world().inject({DriveFaultKind::kNoAnswer, 1, bench.device->world().tick() + 1 + deaf, 1});
      bench.ticks(deaf + 4);
      CHECK(bench.input.sample.state == DeviceState::kBrake);
      CHECK(number_of_drive_fault(bench.input.sample.device_fault) == kDriveLeftForce + 1);
      CHECK_THAT(describe_drive_fault(bench.input.sample.device_fault),
                 Contains("axis 1 is not enabled any more: it has restarted, or another program stopped it"));
      CHECK(bench.force_N() == 0);
      bench.rearm();
      bench.ticks(kMoteusStart);
      CHECK(bench.input.sample.state == DeviceState::kForce);
      CHECK(bench.input.sample.device_fault == 0);
      CHECK(bench.force_N() == Approx(force_N).margin(0.05));
    }
}

TEST_CASE("drives: while a moteus starts, the arm reports FORCE and no drive gets a torque") {
  Bench bench(point_arm_of(DriveFamily::kMoteus), held_at({}));
  bench.device->world().drive(2).set_start(0.03);
  bench.command.wrench.force = {2, 0, 0};
  bench.want(DeviceState::kForce, 3);
  unsigned without = 3;
  for (; !bench.device->world().drive(2).enabled(); ++without) {
    REQUIRE(without < 40);
    bench.tick();
    CHECK(bench.input.sample.state == DeviceState::kForce);
    CHECK(bench.force_N() == 0);
  }
  CHECK(bench.device->world().drive(0).enabled());
  CHECK(without >= 29);
  bench.ticks(8);
  CHECK(bench.force_N() > 1.9);
}

TEST_CASE("drives: a moteus that does not finish starting brakes the arm, and the fault names it") {
  Bench bench(point_arm_of(DriveFamily::kMoteus), held_at({}));
  bench.device->world().drive(2).set_start(1);
  bench.want(DeviceState::kForce, 50);
  CHECK(bench.input.sample.state == DeviceState::kForce);
  bench.ticks(5);
  CHECK(bench.input.sample.state == DeviceState::kBrake);
  CHECK_THAT(describe_drive_fault(bench.input.sample.device_fault), Contains("axis 2 does not get enabled"));
}

TEST_CASE("drives: when commands stop while a moteus starts, the arm brakes") {
  Bench bench(point_arm_of(DriveFamily::kMoteus));
  bench.device->world().drive(2).set_start(0.04);
  bench.want(DeviceState::kForce, 4);
  for (int i = 0; i < 12; ++i) bench.device->read(bench.input);
  CHECK(bench.input.sample.state == DeviceState::kBrake);
  CHECK(bench.input.sample.device_fault == 1);
}
