#include "sim/model/choice_names.h"

#include <catch2/catch.hpp>

using namespace tactus;

namespace {

// Of every value that the type can hold, those that have a name. Each name is found again, and is no other's.
template <class Choice, class Parse>
unsigned named_choices(Parse parse) {
  unsigned named = 0;
  for (int value = 0; value < 256; ++value) {
    const auto choice = static_cast<Choice>(value);
    if (sim::name_of(choice) == "unknown") continue;
    CAPTURE(value, sim::name_of(choice));
    CHECK(parse(sim::name_of(choice)) == choice);
    ++named;
  }
  return named;
}

}  // namespace

TEST_CASE("Every choice has a name, and its name gives it back") {
  CHECK(named_choices<haptics::CouplingScheme>(sim::parse_coupling_scheme) == haptics::kCouplingSchemes.size());
  CHECK(named_choices<physics::BorderMode>(sim::parse_border_mode) == physics::kBorderModes.size());
  CHECK(named_choices<sim::CutOrder>(sim::parse_cut_order) == 2);
  CHECK(named_choices<sim::Reach>(sim::parse_reach) == 2);
  CHECK(named_choices<physics::SweepPrecision>(sim::parse_precision) == 2);
  CHECK(named_choices<physics::FrictionSweeps>(sim::parse_friction_sweeps) == 3);
}

TEST_CASE("A value beyond the last choice has no name") {
  // Schemes are numbered from 0, modes from 1.
  CHECK(sim::name_of(haptics::CouplingScheme{haptics::kCouplingSchemes.size()}) == "unknown");
  CHECK(sim::name_of(physics::BorderMode{physics::kBorderModes.size() + 1}) == "unknown");
  CHECK(sim::name_of(physics::BorderMode{0}) == "unknown");
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
