// What the haptic thread asks of the kernel after its start: the time, and the sleep to the next deadline. Held to that
// by the kernel, in a process of its own; the same run counts allocations, locks and page faults. On every kind of
// shape and joint, and in the situations that take another way through the tick: faults, cuts, a late world.
#include "tests/system/haptic_thread/trial.h"

using namespace tactus;
using namespace tactus::test;

TEST_CASE("after its start the haptic thread asks the kernel for the time and for sleep, and for nothing else",
          "[no-asan][no-tsan]") {
  const Counts counts = run_trial({.ticks = 2'000});
  check_clean(counts, 2'000);
  CHECK(counts.cycles > 50);
}

TEST_CASE("one system call too many in one tick is detected", "[no-asan][no-tsan]") {
  const Counts counts = run_trial({.ticks = 100, .misbehave = true});
  CHECK(counts.refused == 1);
  CHECK(counts.first_refused == SYS_getpid);
}

TEST_CASE("without pacing it makes no other system call either", "[no-asan][no-tsan]") {
  const Counts counts = run_trial({.ticks = 20'000, .pace = Pace::kAsFastAsItGoes});
  check_clean(counts, 20'000);
  CHECK(counts.cycles > 1'800);
}

TEST_CASE("nor on joints, hulls and meshes, through which the border runs", "[no-asan][no-tsan]") {
  struct Cut {
    const char* scene;
    std::uint32_t members;
    bool joints, border_contacts;  // that it has: joints between members, contacts at the border
  };
  // Through hulls, meshes, boxes and balls; through a joint of the workshop, and of a chain that hangs.
  const Cut cut = GENERATE(Cut{"stones.toml", 2, false, true}, Cut{"terrain.toml", 2, false, true},
                           Cut{"chain.toml", 8, false, true}, Cut{"card_house.toml", 8, false, true},
                           Cut{"workshop.toml", 8, true, false}, Cut{"workshop.toml", 2, false, false},
                           Cut{"../../tests/border/pendulum_cut.toml", 3, true, false});
  CAPTURE(cut.scene, cut.members);
  const Counts counts =
      run_trial({.ticks = 6'000, .pace = Pace::kAsFastAsItGoes, .scene = cut.scene, .members = cut.members});
  check_clean(counts, 6'000);
  CHECK(counts.with(kProxyContact) > 500);
  CHECK((counts.joints > 0) == cut.joints);
  CHECK((counts.border_contacts > 0) == cut.border_contacts);
  CHECK((counts.ghosts > 0) == (cut.members < 8 || cut.border_contacts));
}

TEST_CASE("nor with faults that latch and are taken back", "[no-asan][no-tsan]") {
  const char* const inject =
      GENERATE("lost/state@1500+30", "corrupted/state@1500+40:3", "nan@1500+20", "frozen@1500+200", "wild@1500+20",
               "teleport@1500+1000:0.1", "unplugged@1500+300", "estop@1500+300");
  INFO(inject);
  const Counts counts = run_trial({.ticks = 4'000, .pace = Pace::kAsFastAsItGoes, .inject = inject});
  check_clean(counts, 4'000);
  CHECK(counts.latched > 0);
}

TEST_CASE("nor on an arm of drives, whole or with faults", "[no-asan][no-tsan]") {
  const char* const file = GENERATE(TACTUS_SOURCE_DIR "/hal/devices/point_arm_drives.toml",
                                    TACTUS_SOURCE_DIR "/hal/devices/wristed_arm_moteus.toml");
  const char* const inject = GENERATE("", "lost/state@1500+30", "frozen@1500+30", "unplugged@1500+30");
  CAPTURE(file, inject);
  const Counts counts = run_trial(
      {.ticks = 4'000, .pace = Pace::kAsFastAsItGoes, .inject = inject, .device = "drives-sim", .device_file = file});
  check_clean(counts, 4'000);
  CHECK((counts.latched > 0) == (*inject != 0));
}

TEST_CASE("nor where the solver is cut, and where the governor leaves out sub-steps and members",
          "[no-asan][no-tsan]") {
  const std::uint32_t sweep = GENERATE(0u, 1u, 3u);
  const Counts cut = run_trial(
      {.ticks = 3'000, .pace = Pace::kAsFastAsItGoes, .scene = "card_house.toml", .members = 32, .cut_at = sweep});
  check_clean(cut, 3'000);
  CHECK(cut.with(kSolverCut) > 2'000);
  const Counts poor = run_trial(
      {.ticks = 3'000, .pace = Pace::kAsFastAsItGoes, .scene = "pile250.toml", .members = 64, .budget = 0.02});
  check_clean(poor, 3'000);
  CHECK(poor.with(kSubStepsReduced) > 2'000);
}

TEST_CASE("nor with a world that is late, until the border is frozen and the force has faded", "[no-asan][no-tsan]") {
  using std::chrono::milliseconds;
  const Counts counts =
      run_trial({.ticks = 3'000,
                 .scene = "card_house.toml",
                 .members = 8,
                 .stalls = {{40, milliseconds(15)}, {60, milliseconds(100)}, {80, milliseconds(1000)}}});
  check_clean(counts, 3'000);
  CHECK(counts.with(kWorldLate) > 1'000);
  CHECK(counts.with(kBorderFrozen) > 800);
  CHECK(counts.with(kWorldFade) > 500);
  CHECK(counts.border_contacts > 10);
}

TEST_CASE("nor while somebody watches, with a global world and without one", "[no-asan][no-tsan]") {
  const auto coupling = GENERATE(haptics::CouplingScheme::kSubWorld, haptics::CouplingScheme::kDirect);
  const Counts counts = run_trial({.ticks = 2'000, .coupling = coupling, .watched = true});
  check_clean(counts, 2'000);
  CHECK(counts.ticks_seen > 1'500);
  CHECK(counts.frames_seen > 50);
}

TEST_CASE("ten million ticks: no allocation, no lock, no page fault, no system call", "[.][long]") {
  const Counts counts = run_trial({.ticks = 10'000'000, .pace = Pace::kAsFastAsItGoes});
  check_clean(counts, 10'000'000);
  CHECK(counts.cycles > 900'000);
}
