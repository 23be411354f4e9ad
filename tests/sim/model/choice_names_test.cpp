#include "sim/model/choice_names.h"

#include <catch2/catch.hpp>

using namespace tactus;

TEST_CASE("Every choice has a name, and its name gives it back") {
  for (const auto scheme : haptics::kCouplingSchemes) CHECK(sim::parse_coupling_scheme(sim::name_of(scheme)) == scheme);
  for (const auto mode : physics::kBorderModes) CHECK(sim::parse_border_mode(sim::name_of(mode)) == mode);
  for (const auto order : {sim::CutOrder::kBestFirst, sim::CutOrder::kBreadthFirst})
    CHECK(sim::parse_cut_order(sim::name_of(order)) == order);
  for (const auto reach : {sim::Reach::kTwoCycles, sim::Reach::kPaper})
    CHECK(sim::parse_reach(sim::name_of(reach)) == reach);
  for (const auto precision : {physics::SweepPrecision::kFull, physics::SweepPrecision::kSingle})
    CHECK(sim::parse_precision(sim::name_of(precision)) == precision);
  for (const auto sweeps :
       {physics::FrictionSweeps::kAuto, physics::FrictionSweeps::kRelax, physics::FrictionSweeps::kEvery})
    CHECK(sim::parse_friction_sweeps(sim::name_of(sweeps)) == sweeps);
}

TEST_CASE("A value beyond the last choice has no name") {
  CHECK(sim::name_of(haptics::CouplingScheme{7}) == "unknown");
  CHECK(sim::name_of(physics::BorderMode{0}) == "unknown");
  CHECK(sim::name_of(physics::BorderMode{6}) == "unknown");
}

TEST_CASE("Names are the words of the command line") {
  CHECK(sim::name_of(haptics::CouplingScheme::kSubWorld) == "sub-world");
  CHECK(sim::name_of(physics::BorderMode::kReplay) == "replay");
  CHECK(sim::name_of(sim::Reach::kPaper) == "paper");
}

TEST_CASE("Other words name nothing") {
  CHECK_FALSE(sim::parse_coupling_scheme("subworld"));
  CHECK_FALSE(sim::parse_coupling_scheme(""));
  CHECK_FALSE(sim::parse_cut_order("best"));
  CHECK_FALSE(sim::parse_reach("Paper"));
  CHECK_FALSE(sim::parse_precision("float"));
  CHECK_FALSE(sim::parse_friction_sweeps("all"));
}
