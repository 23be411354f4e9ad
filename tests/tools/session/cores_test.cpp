// Cores on which a thread may stay.
#include "tools/session/cores.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::session;
using Catch::Matchers::Contains;

TEST_CASE("the cores without one are all the others, and that one where it is the only one") {
  const std::vector<int> all = cores_without(-1);
  REQUIRE_FALSE(all.empty());
  CHECK(cores_without(all.back()).size() == (all.size() > 1 ? all.size() - 1 : 1));
}

TEST_CASE("the core of a hand is the one that is asked for, else the last one, for the next hand the one before it") {
  const std::vector<int> all = cores_without(-1);
  CHECK(core_of_hand(3) == 3);
  CHECK(core_of_hand(-1) == all.back());
  CHECK(core_of_hand(-1, 1) == all[all.size() > 1 ? all.size() - 2 : 0]);
  CHECK(core_of_hand(-1, all.size()) == all.back());
}

TEST_CASE("a core that the process cannot stay on is one line with the option and a core that it can") {
  for (const int cpu : cores_without(-1)) CHECK(check_core("--cpu", cpu).ok());
  CHECK(check_core("--cpu", -1).ok());
  CHECK_THAT(check_core("--world-cpu", 1023).message(),
             Contains("--world-cpu: this program cannot stay on core 1023; accepted: ") &&
                 Contains("such as " + std::to_string(cores_without(-1).back())));
}
