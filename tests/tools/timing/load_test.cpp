// The load on the other cores: there while it is wanted, gone with it.
#include "tools/timing/load.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/skip.h"
#include "tools/session/cores.h"

using namespace tactus;
using namespace tactus::timing;

namespace {

// Processes whose parent is this one, dead ones that nobody waited for among them.
std::size_t children() {
  std::ifstream file("/proc/self/task/" + std::to_string(getpid()) + "/children");
  std::string line;
  std::getline(file, line);
  std::istringstream words(line);
  std::size_t count = 0;
  for (std::string word; words >> word;) ++count;
  return count;
}

}  // namespace

TEST_CASE("loads have names, and anything else is one line that says which") {
  CHECK(parse_load("none").value() == LoadKind::kNone);
  CHECK(parse_load("memory").value() == LoadKind::kMemory);
  CHECK(parse_load("stress-ng").value() == LoadKind::kStressNg);
  CHECK(parse_load("gpu").message().find("accepted: none, cpu, memory, stress-ng") != std::string::npos);
}

TEST_CASE("a load is a process on every core but the loop's, and ends with its owner") {
  TACTUS_NEEDS(std::ifstream("/proc/self/task/" + std::to_string(getpid()) + "/children").good(),
               "this kernel does not list children (CONFIG_PROC_CHILDREN)");
  const std::vector<int> all = session::cores_without(-1);
  const std::size_t others = session::cores_without(all.back()).size();
  {
    Load load;
    REQUIRE(load.start(LoadKind::kCpu, all.back()).ok());
    CHECK(load.processes() == others);
    CHECK(children() == others);
  }
  CHECK(children() == 0);
}
