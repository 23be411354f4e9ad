#include "tools/tune/search.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::tune;

namespace {

constexpr Limits kLimits{.tick_us = 600, .global_us = 800, .members = 256, .sub_steps = 16, .bodies = 64};

// A machine and a scene by formula: each factor buys its share of the error and costs its time.
struct Model {
  double us_per_member_sub_step{1};
  double global_us{1600};  // of a step

  Trial operator()(const CostSetting& s) const {
    Trial trial;
    trial.setting = s;
    trial.force_error = 0.2 / s.sub_steps + (s.relax_sweeps == 1 ? 0.05 : 0) + 0.5 * (1 - s.members / 64.0) +
                        0.002 * (s.members < 64 ? s.scheme.ratio : 0);
    trial.tick_us_p99 = us_per_member_sub_step * s.members * s.sub_steps * (s.relax_sweeps + 1) / 2;
    trial.global_us_per_tick = global_us / s.scheme.ratio;
    return trial;
  }
};

CostSetting setting(unsigned sub_steps, unsigned relax_sweeps, unsigned members, unsigned ratio) {
  return {.sub_steps = sub_steps,
          .relax_sweeps = relax_sweeps,
          .contact_Hz = 250,
          .members = members,
          .scheme = {.ratio = ratio}};
}

}  // namespace

TEST_CASE("Where time allows everything, everything is taken") {
  Model model{.us_per_member_sub_step = 0.1};
  const Found found = search(setting(4, 1, 16, 8), kLimits, std::ref(model));
  CHECK(found.fits);
  CHECK(found.best.setting.sub_steps == 16);
  CHECK(found.best.setting.relax_sweeps == 2);
  CHECK(found.best.setting.members == 64);
}

TEST_CASE("What is chosen fits, and no change from there is more accurate and fits too") {
  for (const double cost : {0.3, 0.7, 1.3, 2.0, 4.0}) {
    Model model{.us_per_member_sub_step = cost};
    const Found found = search(setting(4, 1, 16, 8), kLimits, std::ref(model));
    INFO(cost);
    CHECK(found.fits);
    CHECK(found.best.fits(kLimits));
    CHECK(found.best.force_error <= model(setting(4, 1, 16, 8)).force_error);
    for (const SettingStep& change : changes_up(found.best.setting, kLimits)) {
      const Trial further = model(change.setting);
      CHECK((!further.fits(kLimits) || further.force_error >= 0.98 * found.best.force_error));
    }
  }
}

TEST_CASE("A scene that is too much for the machine is taken back until it fits") {
  Model model{.us_per_member_sub_step = 2.5};
  const Found found = search(setting(16, 2, 64, 8), kLimits, std::ref(model));
  CHECK(found.fits);
  CHECK(found.best.tick_us_p99 <= kLimits.tick_us);
}

TEST_CASE("Where the global world is too slow the ratio rises, and where nothing helps that is said") {
  Model slow{.us_per_member_sub_step = 0.1, .global_us = 6000};
  const Found found = search(setting(4, 1, 16, 4), kLimits, std::ref(slow));
  CHECK(found.fits);
  CHECK(found.best.setting.scheme.ratio >= 8);
  Model hopeless{.us_per_member_sub_step = 1e6};
  CHECK_FALSE(search(setting(4, 1, 16, 8), kLimits, std::ref(hopeless)).fits);
}

TEST_CASE("A change of setting is of one factor, stays within the limits and resolves the contacts") {
  Limits limits = kLimits;
  limits.members = 20;
  limits.sub_steps = 8;
  for (const CostSetting& s : {setting(1, 1, 2, 16), setting(4, 2, 16, 10), setting(8, 2, 20, 1)}) {
    for (const auto& changes : {changes_up(s, limits), changes_down(s, limits)})
      for (const SettingStep& change : changes) {
        const CostSetting& to = change.setting;
        CHECK((to.sub_steps != s.sub_steps) + (to.relax_sweeps != s.relax_sweeps) + (to.members != s.members) +
                  (to.scheme.ratio != s.scheme.ratio) ==
              1);
        CHECK(to.members <= 20);
        CHECK(to.members >= 1);
        CHECK(to.sub_steps <= 8);
        CHECK(to.contact_Hz <= 0.25 * to.sub_steps * 1000);
      }
  }
  CHECK(changes_stiffer(setting(1, 1, 2, 8)).empty());
  REQUIRE(changes_stiffer(setting(2, 1, 2, 8)).size() == 1);
  CHECK(changes_stiffer(setting(2, 1, 2, 8))[0].setting.contact_Hz == 500);
}
