// The plot of times as SVG: what a reader must see lies within the drawing, however late a tick was.
#include "tools/timing/plot.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <regex>

using namespace tactus;
using namespace tactus::timing;

namespace {

constexpr double kDigit_px = 8;  // the widest digit of the plot's fonts at 12 px, rounded up

struct Tick {
  double x_px;
  std::string label;
};

std::vector<Tick> time_ticks(const std::string& svg) {
  static const std::regex kTick("<text class=\"xtick\" x=\"([0-9.]+)\"[^>]*>([^<]*)</text>");
  std::vector<Tick> ticks;
  for (std::sregex_iterator at(svg.begin(), svg.end(), kTick), end; at != end; ++at)
    ticks.push_back({std::stod((*at)[1]), (*at)[2]});
  return ticks;
}

double width_px(const std::string& svg) {
  static const std::regex kWidth("<svg [^>]*width=\"([0-9.]+)\"");
  std::smatch found;
  REQUIRE(std::regex_search(svg, found, kWidth));
  return std::stod(found[1]);
}

}  // namespace

TEST_CASE("the labels of the time axis lie within the plot, for ticks of a microsecond to ten seconds") {
  for (std::int64_t latest_ns = 1'000; latest_ns <= 10'000'000'000; latest_ns *= 10) {
    INFO("the latest tick took " << latest_ns << " ns");
    Histogram times;
    times.record(700);
    times.record(latest_ns);
    const std::string svg = histogram_svg("a sentence", {}, {{"ticks", &times}}, 1'000'000);
    const auto ticks = time_ticks(svg);
    REQUIRE(ticks.size() >= 3);
    for (const Tick& tick : ticks) {
      const double half_px = 0.5 * kDigit_px * static_cast<double>(tick.label.size());
      CAPTURE(tick.label);
      CHECK(tick.x_px - half_px >= 0);
      CHECK(tick.x_px + half_px <= width_px(svg));
    }
  }
}
