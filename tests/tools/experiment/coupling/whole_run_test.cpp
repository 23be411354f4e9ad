// Whole runs beside the direct coupling: what rests on members, is pushed by them or rolls on them stands. The scenes
// are in tests/border; its README says what each is for, and what no border holds yet.
#include "tools/experiment/coupling/whole_run.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "sim/loader/scene_load.h"

using namespace tactus;
using namespace tactus::experiment;

namespace {

std::vector<WholeRunRow> runs_of(const std::string& name, const std::vector<unsigned>& ratios,
                                 const std::vector<unsigned>& members, double seconds,
                                 physics::BorderMode border = physics::BorderMode::kGhost,
                                 WholeRunHand hand = WholeRunHand::kClosed) {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tests/border/" + name + ".toml");
  REQUIRE(scene.ok());
  WholeRunRequest request;
  request.scenes.push_back(std::move(scene).value());
  for (const unsigned ratio : ratios) request.schemes.push_back({haptics::CouplingScheme::kSubWorld, border, ratio});
  request.hands = {hand};
  request.members = members;
  request.seconds = seconds;
  auto rows = run_whole(request, {});
  REQUIRE(rows.ok());
  REQUIRE(rows.value().size() == ratios.size() * members.size());
  return std::move(rows).value();
}

// The goal of every scene: within 2 % of the smallest body's size of where the direct run has it.
constexpr double kGoal = 0.02;

}  // namespace

TEST_CASE("What rests on members stands as in the direct run, nobody touching it or a hand pulling below") {
  const std::string scene =
      GENERATE("two_cubes", "stack20_foot", "pull_bottom", "table", "portal", "heavy", "block_row");
  for (const WholeRunRow& row : runs_of(scene, {2, 8, 16}, {0, 3, 2}, 4)) {
    INFO(scene << ", ratio " << row.scheme.ratio << ", " << row.members << " members: off by " << 1e3 * row.pose_off_m
               << " mm, " << row.fallen << " fell");
    CHECK(row.stands);
    CHECK(row.pose_off_share < kGoal);
    CHECK(row.energy_gain_J - row.direct_energy_gain_J < 1e-3 * row.energy_at_play_J);
  }
}

TEST_CASE("What tips, rolls, hangs across the border or is hit is felt as in the direct run, at every ratio") {
  // Force error at ratios 2 and 8, and at 16; impacts within 10 % (drop, billiard; the cradle is below). The direct run
  // of whip is off by 3 % of one with twice the sub-steps.
  const auto [scene, most, most_at_16] = GENERATE(table<std::string, double, double>({{"seesaw", 0.02, 0.05},
                                                                                      {"crib", 0.02, 0.05},
                                                                                      {"plate_on_balls", 0.02, 0.05},
                                                                                      {"hanging", 0.02, 0.05},
                                                                                      {"pendulum_cut", 0.02, 0.05},
                                                                                      {"hit", 0.02, 0.05},
                                                                                      {"pyramid_top", 0.02, 0.05},
                                                                                      {"tray", 0.02, 0.05},
                                                                                      {"whip", 0.03, 0.06},
                                                                                      {"drop", 0.1, 0.1},
                                                                                      {"billiard", 0.1, 0.1}}));
  for (const WholeRunRow& row : runs_of(scene, {2, 8, 16}, {0, 4}, 3)) {
    INFO(scene << ", ratio " << row.scheme.ratio << ", " << row.members << " members: " << 100 * row.force_error
               << " %, off by " << 1e3 * row.pose_off_m << " mm, " << row.fallen << " fell, tank empty in "
               << 100 * row.account.spent_share << " % of the ticks");
    CHECK(row.stands);
    const bool misses = scene == "whip" && row.scheme.ratio == 8 && row.members == 4;  // see the next case
    CHECK(row.force_error < (misses ? 0.035 : row.scheme.ratio == 16 ? most_at_16 : most));
    CHECK(row.energy_gain_J - row.direct_energy_gain_J < 1e-2 * row.energy_at_play_J);
    CHECK(row.account.spent_share < 0.1);
  }
}

// 3.1 %; 2.98 % while the hand was extrapolated by its velocity alone.
TEST_CASE("A chain that whips, cut at four members, is felt within 3 % through the border at ratio 8",
          "[!shouldfail]") {
  CHECK(runs_of("whip", {8}, {4}, 3)[0].force_error < 0.03);
}

// With the border of two steps later and bodies of now the proxy jumped by 2.5 mm at the first synchronisation.
TEST_CASE("A scene that does not start at rest creates no energy in its first cycles") {
  for (const WholeRunRow& row :
       runs_of("tray", {2, 8, 16}, {4, 2}, 1, physics::BorderMode::kGhost, WholeRunHand::kNone)) {
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: " << row.energy_unexplained_J << " J of "
                  << row.energy_at_play_J << " J, " << 1e3 * row.deepest_m << " mm");
    CHECK(row.energy_unexplained_J - row.direct_energy_unexplained_J < 1e-3 * row.energy_at_play_J);
    CHECK(row.pose_off_most_m < 5e-4);
  }
}

TEST_CASE("Poses are compared at equal times, also at ratios that do not divide the time between comparisons") {
  for (const WholeRunRow& row : runs_of("two_cubes", {3, 7, 16}, {2}, 2)) CHECK(row.pose_off_most_m < 1e-4);
}

// In a cycle of 16 ms a ball that is hit meets the next one, which is outside.
TEST_CASE("Balls that are pushed into a row are felt within 10 % through the border at ratio 16") {
  for (const WholeRunRow& row : runs_of("billiard", {16}, {3, 2}, 2)) {
    INFO(row.members << " members: " << 100 * row.force_error << " %");
    CHECK(row.force_error < 0.1);
  }
}

// Off by 18 % at ratio 16 while the hand was extrapolated by its velocity alone (sim/exchange/extrapolated_hand.h).
TEST_CASE("Newton's cradle is felt within 10 % through the border at ratios 2 to 16") {
  for (const WholeRunRow& row : runs_of("cradle", {2, 8, 16}, {3, 2}, 3)) {
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: " << 100 * row.force_error << " %");
    CHECK(row.force_error < 0.1);
    CHECK(row.stands);
  }
}

// The border took the impact's energy, the global step too; the difference, which corrections gave or took, was settled
// nowhere, and the tank was empty from there on (90 % of the ticks).
TEST_CASE("An impact through the border leaves its tank as it was: both worlds count the same energy") {
  const auto [scene, members] = GENERATE(table<std::string, unsigned>({{"billiard", 2}, {"knock", 2}, {"drop", 2}}));
  for (const WholeRunRow& row : runs_of(scene, {8, 16}, {members}, 3)) {
    const EnergyAccount& account = row.account;
    INFO(scene << ", ratio " << row.scheme.ratio << ": border " << account.border_work_J << " J, corrections "
               << account.corrected_J << " J, global " << account.global_work_J << " J, tank " << account.tank_J
               << " J");
    CHECK(account.spent_share < 0.01);
    CHECK(std::abs(account.border_work_J + account.corrected_J - account.global_work_J) < 0.02);
  }
}

// The cycles of these ratios are about half the period of the members' modes (sim/exchange/apparent_inertia.h).
TEST_CASE("A tall stack that the border cuts in the middle does not shake") {
  for (const WholeRunRow& row : runs_of("../../sim/scenes/stack20", {3, 4, 5, 6}, {10, 13}, 4)) {
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: off by " << 1e3 * row.pose_off_m << " mm, "
                  << 100 * row.force_error << " %");
    CHECK(row.pose_off_share < kGoal);
    CHECK(row.force_error < 0.02);
  }
}

// With friction impulses of their own in each world, the two rest in two places, and what leans on members creeps
// (rt/haptics/coupling/border_correction.h): these were off by 3 to 7 %.
TEST_CASE("What leans on members does not creep: both worlds rest in one place") {
  const auto [scene, members] = GENERATE(table<std::string, unsigned>({{"block_row", 4}, {"pyramid_top", 6}}));
  for (const WholeRunRow& row : runs_of(scene, {8}, {members}, 20)) {
    INFO(scene << ": off by " << 1e3 * row.pose_off_m << " mm, " << 100 * row.force_error << " %");
    CHECK(row.force_error < 0.02);
    CHECK(row.pose_off_share < 0.005);
  }
}

TEST_CASE("The judge sees a scene fall: an upper cube that a border of frozen bodies lets slide off") {
  const auto rows = runs_of("two_cubes", {8}, {0}, 10, physics::BorderMode::kFrozen);
  CHECK_FALSE(rows[0].stands);
  CHECK(rows[0].fallen == 1);
}

// Before the two worlds agreed on impacts the force was off by 76 and 87 % at ratio 8.
TEST_CASE("A ball that is pushed into a row feels the impacts that go through the border") {
  for (const WholeRunRow& row : runs_of("billiard", {2, 8}, {3, 2}, 2)) {
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: " << 100 * row.force_error << " %");
    CHECK(row.force_error < 0.1);
    CHECK(row.kinetic_over_work < 1);
  }
}

// Without border contacts before the impact the blocks overlap by 1.5 mm at ratios 8 and 16, and have 15 % more energy
// after it than the hand has put in.
TEST_CASE("A member that is pushed against an outside body neither overlaps it nor gains energy") {
  for (const WholeRunRow& row : runs_of("knock", {2, 8, 16}, {2}, 1)) {
    INFO("ratio " << row.scheme.ratio << ": " << 1e3 * row.deepest_m << " mm, kinetic energy over work "
                  << row.kinetic_over_work);
    CHECK(row.deepest_m < 2e-4);
    CHECK(row.kinetic_over_work < 1);
  }
}

// The border below the heavy one, below the first light one and through the light ones.
TEST_CASE("A tonne stands on light cubes, wherever the border runs") {
  for (const WholeRunRow& row : runs_of("thousand", {2, 8, 16}, {2, 0, 5}, 5)) {
    const EnergyAccount& account = row.account;
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: off by " << 1e3 * row.pose_off_m
                  << " mm, border " << account.border_work_J << " J, corrections " << account.corrected_J
                  << " J, global " << account.global_work_J << " J, tank empty in " << 100 * account.spent_share
                  << " % of the ticks");
    CHECK(row.stands);
    CHECK(account.spent_share < 0.1);
    // With two members, proxy and tonne, all that acts on the tonne goes through the border but for the proxy. Their
    // contact dissipates in each world its own energy: m (2 v)^2 / 2 in an impact, v: the tonne's greatest speed. The
    // difference varies between -9 and 7 mJ with proxies of 0.05 to 0.4 kg.
    const double impact_J = 4 * 0.2 / 1000 * row.kinetic_J;
    if (row.members == 2)
      CHECK(std::abs(account.border_work_J + account.corrected_J - account.global_work_J) < 2 * impact_J);
    CHECK(row.pose_off_share < kGoal);
  }
}

// Where members' impulses on outside bodies through joints were not returned to these, the chain rang at ratios 4 and 6
// (8.6 and 4.9 % of the force).
TEST_CASE("A link that hangs across the border is felt as in the direct run") {
  for (const WholeRunRow& row : runs_of("pendulum_cut", {2, 3, 4, 5, 6, 8, 16}, {2, 0, 5}, 4)) {
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: " << 100 * row.force_error << " %");
    CHECK(row.force_error < 0.02);
    CHECK(row.account.spent_share < 0.05);
    CHECK(row.pose_off_share < kGoal);
  }
}

// With more than 200 bodies a global step has the scene's two sub-steps a tick, and the sub-world four. The ghosts
// emptied the tank while a joint could give any amount in a sub-step, and while impulses were returned then, the chain
// flew apart at ratio 16 (63 % of the force, 74 J).
TEST_CASE("A link that hangs across the border of a large world is held, and the tank lasts") {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tests/border/pendulum_cut.toml");
  REQUIRE(scene.ok());
  for (int k = 0; k < 220; ++k)
    scene.value().bodies.push_back(physics::make_dynamic_body(static_cast<BodyId>(100 + k),
                                                              physics::Shape::sphere(0.02), 0.1, 0.5,
                                                              {{5 + 0.1 * (k % 20), 0.1 * (k / 20), 0}, {}}));
  for (std::size_t k = scene.value().bodies.size() - 220; k < scene.value().bodies.size(); ++k)
    scene.value().bodies[k].gravity_scale = 0;
  WholeRunRequest request;
  request.scenes.push_back(std::move(scene).value());
  for (const unsigned ratio : {8u, 16u})
    request.schemes.push_back({haptics::CouplingScheme::kSubWorld, physics::BorderMode::kGhost, ratio});
  request.members = {3, 4};
  request.seconds = 4;
  const auto rows = run_whole(request, {});
  REQUIRE(rows.ok());
  for (const WholeRunRow& row : rows.value()) {
    INFO("ratio " << row.scheme.ratio << ", " << row.members << " members: " << 100 * row.force_error << " %");
    CHECK(row.stands);
    CHECK(row.force_error < 0.05);
    CHECK(row.account.spent_share < 0.001);
  }
}

TEST_CASE("How far direct runs go apart, from 1 um aside and with finer steps, stands beside the coupled runs, once") {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tests/border/table.toml");
  REQUIRE(scene.ok());
  WholeRunRequest request;
  request.scenes.push_back(std::move(scene).value());
  for (const unsigned ratio : {2u, 8u})
    request.schemes.push_back({haptics::CouplingScheme::kSubWorld, physics::BorderMode::kGhost, ratio});
  request.seconds = 0.2;
  request.floor = true;
  const auto rows = run_whole(request, {});
  REQUIRE(rows.ok());
  REQUIRE(rows.value().size() == 4);
  const WholeRunRow& floor = rows.value()[0];
  CHECK(floor.apart_m == 1e-6);
  CHECK(floor.scheme.coupling == haptics::CouplingScheme::kDirect);
  CHECK(floor.pose_off_most_m >= 0.5e-6);  // the proxy's own microns
  CHECK(floor.pose_off_most_m < 1e-4);
  CHECK(floor.stands);
  const WholeRunRow& finer = rows.value()[1];
  CHECK(finer.apart_m == 0);
  CHECK(finer.sub_steps_times == 2);
  CHECK(finer.scheme.coupling == haptics::CouplingScheme::kDirect);
  CHECK(finer.pose_off_most_m > 0);
  CHECK(finer.pose_off_most_m < 1e-4);
  CHECK(rows.value()[2].apart_m == 0);
  CHECK(rows.value()[2].sub_steps_times == 1);
}

TEST_CASE("A run is the same bit by bit when it is run again, in either hand") {
  const auto first = runs_of("table", {8}, {4}, 1), again = runs_of("table", {8}, {4}, 1);
  CHECK(first[0].force_error == again[0].force_error);
  CHECK(first[0].pose_off_m == again[0].pose_off_m);
}

TEST_CASE("Without a hand no force is felt, and the energy of all bodies never rises by more than 0.1 %") {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tests/border/pyramid_top.toml");
  REQUIRE(scene.ok());
  WholeRunRequest request;
  request.scenes.push_back(std::move(scene).value());
  request.schemes = {{haptics::CouplingScheme::kSubWorld, physics::BorderMode::kGhost, 8}};
  request.members = {4};
  request.seconds = 1;
  request.hands = {WholeRunHand::kClosed, WholeRunHand::kNone};
  const auto rows = run_whole(request, {});
  REQUIRE(rows.ok());
  REQUIRE(rows.value().size() == 2);
  const WholeRunRow &closed = rows.value()[0], &alone = rows.value()[1];
  CHECK(closed.hand == WholeRunHand::kClosed);
  CHECK(closed.force_rms_N > 0.5);
  CHECK(alone.hand == WholeRunHand::kNone);
  CHECK(alone.force_rms_N == 0);
  CHECK(alone.account.device_J == 0);
  CHECK(alone.stands);
  CHECK(alone.energy_rise_J < 1e-3 * alone.energy_at_play_J);
  CHECK(alone.direct_energy_rise_J < 1e-3 * alone.energy_at_play_J);
}

namespace {

WholeRunRow run_alone(const char* scene, physics::BorderMode border, unsigned members, double seconds) {
  auto loaded = sim::load_scene(std::string(TACTUS_SOURCE_DIR "/tests/border/") + scene + ".toml");
  REQUIRE(loaded.ok());
  WholeRunRequest request;
  request.scenes.push_back(std::move(loaded).value());
  request.schemes = {{haptics::CouplingScheme::kSubWorld, border, 8}};
  request.members = {members};
  request.seconds = seconds;
  request.hands = {WholeRunHand::kNone};
  const auto rows = run_whole(request, {});
  REQUIRE(rows.ok());
  return rows.value().front();
}

}  // namespace

TEST_CASE("An impact's energy on its way through the border, and in springs of joints, is no energy from nowhere") {
  const WholeRunRow hit = run_alone("drop", physics::BorderMode::kGhost, 3, 0.3);
  CHECK(hit.energy_rise_J > 1e-2 * hit.energy_at_play_J);  // the members get a part of the impulse one snapshot later
  CHECK(hit.energy_unexplained_J < 1e-3 * hit.energy_at_play_J);
  const WholeRunRow chain = run_alone("pendulum_cut", physics::BorderMode::kGhost, 3, 0.3);
  CHECK(chain.direct_energy_rise_J > 1e-3 * chain.energy_at_play_J);  // joints that sag and come back
  CHECK(chain.direct_energy_unexplained_J < 1e-4 * chain.energy_at_play_J);
  CHECK(chain.energy_unexplained_J < 1e-3 * chain.energy_at_play_J);
}

TEST_CASE("The table of whole runs as CSV has a value for each column") {
  const std::string csv = whole_csv(runs_of("two_cubes", {2, 8}, {0}, 0.2));
  std::vector<long> columns;
  for (std::size_t from = 0; from < csv.size();) {
    const std::size_t to = csv.find('\n', from);
    columns.push_back(std::count(csv.begin() + static_cast<long>(from), csv.begin() + static_cast<long>(to), ','));
    from = to + 1;
  }
  REQUIRE(columns.size() == 3);
  CHECK(columns[1] == columns[0]);
  CHECK(columns[2] == columns[0]);
}
