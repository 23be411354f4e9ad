// Several hands in one run, on the virtual clock: what they do to each other, and what they do not.
#include "tools/session/hands.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "hal/profiles.h"
#include "sim/loader/scene_load.h"
#include "tests/support/temporary_file.h"
#include "tools/session/replay.h"
#include "tools/session/shared_limit.h"
#include "tools/session/tape_player.h"
#include "tools/session/world_rebuilder.h"
#include "tools/validation/two_hands.h"

using namespace tactus;
using namespace tactus::hard_cases;

namespace {

// A block for each hand, 2 m apart, and both press on theirs.
std::string apart_text() {
  std::string text = "effects = [\"gravity\", \"friction\", \"gyroscopic\"]\n" + two_hands_head();
  for (const double x_m : {-1.0, 1.0})
    text += fmt::format(R"(
[[proxy]]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
position_m = [{0}, 0, 0.115]
[[device]]
position_m = [{0}, 0, 0.115]
[[hand]]
repeat = false
path = [{{time_s = 0, position_m = [{0}, 0, 0.115]}}, {{time_s = 0.5, position_m = [{0}, 0, 0.1]}}]
[[body]]
shape = "box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 1
friction = 0.5
position_m = [{0}, 0, 0.05]
)",
                        x_m);
  return text + "[[body]]\nshape = \"plane\"\nfriction = 0.5\n";
}

sim::Scene scene_of(const std::string& text) {
  auto scene = sim::parse_scene(text, "test");
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

// A run of two hands that a test may look at after each tick.
struct Bench {
  explicit Bench(const std::string& text, const std::string& inject_1 = "", const std::string& inject_2 = "",
                 haptics::CouplingScheme coupling = haptics::CouplingScheme::kSubWorld) {
    auto made = TwoHands::create(scene_of(text), {inject_1, inject_2}, coupling);
    error = made.message();
    if (made.ok()) two.emplace(std::move(made).value());
  }

  void run(std::uint64_t ticks, const TwoHands::Look& look = {}) {
    INFO(error);
    REQUIRE(two.has_value());
    auto done = two->run(ticks, look);
    REQUIRE(done.ok());
    summaries = std::move(done).value();
    REQUIRE(summaries.size() == 2);
  }

  Vec3d force(unsigned hand) const { return two->force_N(hand); }

  std::string error;
  std::optional<TwoHands> two;
  std::vector<session::RunSummary> summaries;
};

}  // namespace

TEST_CASE("Two hands that pull at one bar feel each other's force") {
  Bench bench(tug_text());
  double pulled_N[2] = {}, moved_N[2] = {}, ripple_N = 0, most_step_N = 0, last_N = 0;
  bench.run(2600, [&](std::uint64_t tick) {
    const double forces_N[] = {bench.force(0).x, bench.force(1).x};
    // Both have drawn 20 mm; then the first draws another 30 mm.
    for (std::size_t d = 0; d < 2; ++d) {
      if (tick == 999) pulled_N[d] = forces_N[d];
      if (tick == 2599) moved_N[d] = forces_N[d];
    }
    if (tick >= 2300) ripple_N = std::max(ripple_N, std::abs(forces_N[0] + forces_N[1]));
    most_step_N = std::max(most_step_N, std::abs(forces_N[1] - last_N));
    last_N = forces_N[1];
    REQUIRE(bench.two->holds_part(0) != bench.two->holds_part(1));  // a member of exactly one sub-world
  });
  const double first = in_series_N(0.02), then = in_series_N(0.5 * (0.02 + 0.05));
  CHECK(pulled_N[0] == Approx(first).margin(kDryFriction_N));
  CHECK(pulled_N[1] == Approx(-first).margin(kDryFriction_N));
  CHECK(moved_N[0] == Approx(then).margin(kDryFriction_N));
  CHECK(moved_N[1] == Approx(-then).margin(kDryFriction_N));
  CHECK(ripple_N < 0.02 * then);
  CHECK(most_step_N < 0.05 * then);  // the hand that does not hold the bar: no step when a snapshot comes
  for (const auto& summary : bench.summaries) {
    CHECK(session::judge(summary).text().empty());
    CHECK(summary.global.handed_over == 0);
  }
}

TEST_CASE("A part goes from hand to hand, and its sub-world with it") {
  Bench bench(hand_over_text());
  const double friction_N = 0.5 * 9.81 * 0.5;  // of the block on the ground: mu = 0.5
  std::vector<unsigned> holders;
  double pushed_m = 0, most_N[2] = {};
  bench.run(3000, [&](std::uint64_t tick) {
    REQUIRE_FALSE((bench.two->holds_part(0) && bench.two->holds_part(1)));
    for (unsigned d = 0; d < 2; ++d) {
      if (bench.two->holds_part(d) && (holders.empty() || holders.back() != d)) holders.push_back(d);
      most_N[d] = std::max(most_N[d], std::abs(bench.force(d).x));
    }
    if (tick == 1900) pushed_m = bench.two->part_x_m();
  });
  // A body that no hand touches belongs to the hand of lower number, later to the hand that pushes it.
  CHECK(holders == std::vector<unsigned>{0, 1});
  CHECK(bench.summaries[0].global.handed_over == 1);
  // The block stops between the hand's target (less half the block and the ball) and the place where friction balances
  // both springs.
  const double sag_m = friction_N / kHand_N_per_m + friction_N / kCoupling_N_per_m;
  CHECK(pushed_m < 0.06 - 0.02);
  CHECK(pushed_m > 0.06 - 0.02 - sag_m);
  CHECK(bench.two->part_x_m() > 0.04 - 0.06);
  CHECK(bench.two->part_x_m() < 0.04 - 0.06 + sag_m);
  for (const double force_N : most_N) {
    CHECK(force_N > friction_N);
    CHECK(force_N < 2 * friction_N);
  }
  for (const auto& summary : bench.summaries) CHECK(session::judge(summary).text().empty());
}

TEST_CASE("Several hands give the same bits twice", "[slow]") {
  std::uint64_t hashes[2][3];
  for (auto& of_run : hashes) {
    Bench bench(hand_over_text());
    bench.run(1200);
    for (std::size_t d = 0; d < 2; ++d) of_run[d] = bench.summaries[d].state_hash;
    of_run[2] = bench.two->world().state_hash();
  }
  for (std::size_t i = 0; i < 3; ++i) CHECK(hashes[0][i] == hashes[1][i]);
}

TEST_CASE("Hands far apart change no bit of each other's force", "[slow]") {
  // The same hand at the same block, with the other one pressing elsewhere, and with it faulted.
  Bench both(apart_text()), faulted(apart_text(), "", "estop@100");
  std::vector<double> forces_N;
  both.run(1000, [&](std::uint64_t) { forces_N.push_back(both.force(0).z); });
  std::size_t different = 0;
  faulted.run(1000, [&](std::uint64_t tick) { different += faulted.force(0).z != forces_N[tick] ? 1 : 0; });
  CHECK(different == 0);
  const double pressed_N = in_series_N(0.015 - 0.005);  // of 15 mm 5 mm are free
  CHECK(forces_N.back() == Approx(pressed_N).margin(kDryFriction_N));
  CHECK(both.force(1).z == Approx(pressed_N).margin(kDryFriction_N));
  CHECK(faulted.force(1).z == 0);
  CHECK(both.summaries[0].stats.fault_count + both.summaries[1].stats.fault_count == 0);
  CHECK(faulted.summaries[0].stats.fault_count == 0);
  CHECK(faulted.summaries[1].stats.fault_count == 1);
  CHECK(session::judge(faulted.summaries[0]).exit_code() == 0);
  CHECK(session::judge(faulted.summaries[1]).exit_code() == 1);
}

TEST_CASE("A hand whose device is unplugged leaves what both hold to the other") {
  Bench bench(tug_text(), "", "unplugged@1000+5000");
  double most_N = 0;
  bench.run(3000, [&](std::uint64_t tick) {
    if (tick > 1000) most_N = std::max(most_N, std::abs(bench.force(0).x));
  });
  CHECK(bench.summaries[0].stats.fault_count == 0);
  CHECK(bench.summaries[1].stats.fault_count == 1);
  CHECK(most_N < 1.1 * in_series_N(0.02));  // the resistance ends, without an impact
  CHECK(std::abs(bench.force(0).x) < 2 * kDryFriction_N);
  CHECK(bench.two->part_x_m() < -0.03);  // drawn along
}

TEST_CASE("A reset of any hand waits for all of them, and starts for all") {
  const bool first = GENERATE(true, false);
  Bench bench(hand_over_text(), first ? "reset@1700" : "", first ? "" : "reset@1700");
  double at_1690_m = 0;
  bench.run(3200, [&](std::uint64_t tick) {
    if (tick == 1690) at_1690_m = bench.two->part_x_m();
  });
  CHECK(at_1690_m > 0.03);
  CHECK(bench.two->world().statistics().resets == 1);
  for (unsigned d = 0; d < 2; ++d) CHECK((*bench.two)[d].loop->sub_world().epoch() == 1);
  CHECK(std::abs(bench.two->part_x_m()) < 0.04);  // the trial is in its first second again
  for (const auto& summary : bench.summaries) CHECK(summary.stats.fault_count == 0);
}

TEST_CASE("Each hand has a tape, and each replays with the same bits", "[slow]") {
  const test::TemporaryFile first;
  CHECK(session::file_of_hand("a/my.tape", 0) == "a/my.tape");
  CHECK(session::file_of_hand("a/my.tape", 1) == "a/my.2.tape");
  const std::string second = session::file_of_hand(first.path(), 1);
  Bench bench(hand_over_text());
  REQUIRE(bench.two.has_value());
  REQUIRE(bench.two->hands().record(first.path()).ok());
  bench.run(2200);
  const std::string paths[] = {first.path(), second};
  for (std::size_t d = 0; d < 2; ++d) {
    CHECK(bench.summaries[d].tape == paths[d]);
    const auto report = session::replay(paths[d]);
    INFO(report.message());
    REQUIRE(report.ok());
    CHECK(report.value().compared == 2200);
    CHECK(report.value().good());
    CHECK(report.value().state_hash == bench.summaries[d].state_hash);
    const auto tape = session::open_tape(paths[d]);
    REQUIRE(tape.ok());
    CHECK(session::why_not_rebuilt(tape.value()).find("one hand") != std::string::npos);
  }
  CHECK(session::replay(paths[0]).value().state_hash != session::replay(paths[1]).value().state_hash);
  (void)std::remove(second.c_str());
}

TEST_CASE("What several hands cannot have is refused in one line") {
  const auto one = session::Session::create(scene_of(tug_text()), {});
  CHECK(one.message().find("has 2 hands") != std::string::npos);
  const auto three = session::Hands::create(scene_of(tug_text()), std::vector<session::RunOptions>(3),
                                            std::vector<session::Hardware>(3));
  CHECK(three.message().find("3 devices for 2 hands") != std::string::npos);
  for (const auto scheme : haptics::kCouplingSchemes) {
    const bool several = scheme == haptics::CouplingScheme::kSubWorld;
    const Bench bench(tug_text(), "", "", scheme);
    INFO(bench.error);
    CHECK(bench.two.has_value() == several);
    CHECK(bench.error.find('\n') == std::string::npos);
  }
  CHECK(Bench(tug_text(), "", "teleport").error.starts_with("hand 2: --inject"));
}

TEST_CASE("Two hands on one body bear less stiffness the later they feel each other, and a run keeps to that",
          "[slow]") {
  const sim::Scene scene = scene_of(tug_text());
  const auto device = hal::find_profile("virtuose6d")->properties;
  session::RunOptions options;
  double before = 1e9;
  for (const unsigned ratio : {2u, 10u, 20u}) {
    options.ratio = ratio;
    const double formula = shared_formula_limit(scene, options, device, session::SharedAxis::kTranslation);
    INFO("ratio " << ratio << ", formula " << formula);
    CHECK(formula < before);
    before = formula;
    for (const double share : {0.5, 1.0})
      CHECK(shared_body_rings_out(scene, options, device, session::SharedAxis::kTranslation, share * formula));
    CHECK_FALSE(shared_body_rings_out(scene, options, device, session::SharedAxis::kTranslation, 20 * formula));
  }
  // Far too stiff for 20 to 40 ms: the run takes what is stable, and says so.
  options.virtual_time = true;
  const auto made = [&] {
    return session::Hands::create(scene, {options, options}, std::vector<session::Hardware>(2));
  };
  const auto lowered = made();
  REQUIRE(lowered.ok());
  const session::SchemeGains found = lowered.value()[1].summary().gains;
  CHECK(found.lowered());
  const double limit = found.stiffness_limit_N_per_m;
  CHECK(found.gains.stiffness_N_per_m <= haptics::kAllowedStiffnessShare * limit);
  CHECK(found.gains.stiffness_N_per_m > 0.99 * haptics::kAllowedStiffnessShare * limit);
  CHECK(lowered.value()[1].loop->config().sub_world.gains.stiffness_N_per_m == found.gains.stiffness_N_per_m);
  CHECK(shared_body_rings_out(scene, options, device, session::SharedAxis::kTranslation, limit));
  CHECK_FALSE(shared_body_rings_out(scene, options, device, session::SharedAxis::kTranslation, 1.2 * limit));
  options.keep_gains = true;
  CHECK(made().message().find("each feels the other 20 to 40 ms late; accepted: up to") != std::string::npos);
  options.ratio = 2;
  const auto kept = made();
  REQUIRE(kept.ok());
  CHECK_FALSE(kept.value()[0].summary().gains.lowered());
}
