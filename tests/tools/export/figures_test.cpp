// Figures of columns against their definitions, over ticks whose numbers are known.
#include "tools/export/figures.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace tactus;
using namespace tactus::exporting;
using Catch::Matchers::Contains;

namespace {

// Ticks 0 to 99; the force's z is 1 to 100 N in an order that is not sorted; members count down.
std::vector<std::pair<std::string, double>> figures_of(std::vector<std::string> words, unsigned ticks = 100) {
  auto parsed = parse_figures(words);
  INFO(parsed.message());
  REQUIRE(parsed.ok());
  Figures figures(std::move(parsed).value(), 1e-3);
  for (unsigned i = 0; i < ticks; ++i) {
    loop::TickRecord tick;
    tick.out.tick = i;
    tick.out.command.wrench.force.z = (i * 37) % 100 + 1;
    tick.out.members = 200 - i;
    figures.take(tick);
  }
  return figures.values();
}

}  // namespace

TEST_CASE("figures are those of their definitions") {
  const auto values =
      figures_of({"force_z_N:mean", "force_z_N:rms", "force_z_N:min", "force_z_N:max", "force_z_N:last",
                  "force_z_N:p50", "force_z_N:p99", "force_z_N:p0", "force_z_N:p100", "members:min", "time_s:last"});
  REQUIRE(values.size() == 11);
  CHECK(values[0].first == "force_z_N:mean");
  CHECK(values[0].second == 50.5);
  CHECK(values[1].second == Approx(std::sqrt(101.0 * 201.0 / 6)));  // sum of squares: n (n + 1) (2 n + 1) / 6
  CHECK(values[2].second == 1);
  CHECK(values[3].second == 100);
  CHECK(values[4].second == (99 * 37) % 100 + 1);
  CHECK(values[5].second == 50);
  CHECK(values[6].second == 99);
  CHECK(values[7].second == 1);
  CHECK(values[8].second == 100);
  CHECK(values[9].second == 101);
  CHECK(values[10].second == Approx(0.1));
  CHECK(std::isnan(figures_of({"force_z_N:p50"}, 0)[0].second));
}

TEST_CASE("what is no figure is named, with what is accepted") {
  const auto [word, said] = GENERATE(table<const char*, const char*>({{"force_z_N", "'force_z_N' is no figure"},
                                                                      {"force_z_N:median", "mean, rms, min"},
                                                                      {"force_z_N:p101", "is no figure"},
                                                                      {"force_z_N:p5x", "is no figure"},
                                                                      {"force_z:rms", "did you mean force_z_N?"},
                                                                      {"force:rms", "is a group"}}));
  const std::vector<std::string> words{word};
  CHECK_THAT(parse_figures(words).message(), Contains(said));
}
