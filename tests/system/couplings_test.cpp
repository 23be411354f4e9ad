// Every coupling on every scene that ships, as a user runs it: no fault, no number that is none, no force beyond twice
// what the direct coupling has on the same scene, and 2 N (2026-11-23: at most 1.8 N above the direct one, free.toml).
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "rt/base/sanitizer.h"
#include "sim/model/choice_names.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;
using haptics::CouplingScheme;

namespace {

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(TACTUS_SOURCE_DIR "/sim/scenes"))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

// So many that the hand is in contact on most; of the large worlds a few cycles, and under the address sanitizer of the
// middle ones too.
std::uint64_t ticks_of(const sim::Scene& scene, CouplingScheme coupling) {
  if (scene.bodies.size() > 10000) return coupling == CouplingScheme::kDirect ? 2 : 30;
  return scene.bodies.size() > (TACTUS_ADDRESS_SANITIZER ? 200 : 2000) ? 60 : 1500;
}

struct Felt {
  double most_N{0};
  std::uint64_t not_finite{0};
  bool fault{false};
};

Felt feel(const sim::Scene& scene, CouplingScheme coupling) {
  session::RunOptions options = virtual_options();
  options.coupling = coupling;
  auto session = make_session(scene, options);
  Felt felt;
  const auto summary = run(*session, ticks_of(scene, coupling), [&](const loop::TickOutput& out) {
    if (!is_finite(out.wanted)) ++felt.not_finite;
    felt.most_N = std::max(felt.most_N, norm(out.wanted.force));
    return true;
  });
  felt.fault = !summary.stats.faults.empty();
  return felt;
}

// A share of the scenes, so that a machine of several cores shares the work.
void every_coupling_runs(std::size_t share, std::size_t shares) {
  const auto scenes = shipped_scenes();
  REQUIRE(scenes.size() >= 17);
  for (std::size_t i = share; i < scenes.size(); i += shares) {
    const sim::Scene scene = scene_file(scenes[i]);
    const Felt direct = feel(scene, CouplingScheme::kDirect);
    for (const auto coupling : haptics::kCouplingSchemes) {
      if (coupling == CouplingScheme::kDirect) continue;
      const Felt felt = feel(scene, coupling);
      INFO(scenes[i] << " " << sim::name_of(coupling));
      CHECK_FALSE(felt.fault);
      CHECK(felt.not_finite == 0);
      CHECK(felt.most_N <= 2 * direct.most_N + 2);
    }
    CHECK_FALSE(direct.fault);
  }
}

}  // namespace

TEST_CASE("every coupling runs every scene that ships, without a fault, near the direct force: first half", "[slow]") {
  every_coupling_runs(0, 2);
}
TEST_CASE("every coupling runs every scene that ships, without a fault, near the direct force: second half", "[slow]") {
  every_coupling_runs(1, 2);
}
