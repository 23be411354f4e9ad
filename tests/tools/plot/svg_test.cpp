// Plots: every drawn point lies at the place of its value, and any text gives a valid file.
#include "tools/plot/svg.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <regex>

#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::plot;
using Catch::Contains;

namespace {

struct Tick {
  double at_px{0};
  std::string words;
};

// The ticks of the axis "x" or "y", as drawn.
std::vector<Tick> ticks_of(const std::string& svg, const std::string& axis) {
  const std::regex pattern("<text class=\"" + axis + "tick\" x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"[^>]*>([^<]*)</text>");
  std::vector<Tick> ticks;
  for (std::sregex_iterator at(svg.begin(), svg.end(), pattern), end; at != end; ++at)
    ticks.push_back({std::stod((*at)[axis == "x" ? 1 : 2]), (*at)[3]});
  return ticks;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++found;
  return found;
}

}  // namespace

TEST_CASE("a logarithmic axis holds its values in whole decades, each as long as the others") {
  auto random = test::Random(1);
  for (int i = 0; i < 200; ++i) {
    const double least = std::pow(10, random(-6, 6)), most = least * std::pow(10, random(0, 4));
    LogAxis axis{.start = 400, .end = 20};
    axis.hold(least, most);
    CAPTURE(least, most, axis.low, axis.high);
    CHECK(axis.high - axis.low >= 1);
    CHECK(std::pow(10, axis.low) <= least * (1 + 1e-12));
    CHECK(std::pow(10, axis.high) >= most * (1 - 1e-12));
    CHECK(std::pow(10, axis.low + 1) > least * (1 - 1e-12));
    const double decade = (axis.end - axis.start) / (axis.high - axis.low);
    CHECK(axis.at(10 * least) - axis.at(least) == Approx(decade));
    CHECK(axis.at(std::pow(10, axis.low)) == Approx(axis.start));
    CHECK(axis.at(std::pow(10, axis.high)) == Approx(axis.end));
  }
}

TEST_CASE("a value below a logarithmic axis, and 0, is drawn at its start") {
  const LogAxis axis{.low = 0, .high = 3, .start = 50, .end = 500};
  CHECK(axis.at(0.01) == 50);
  CHECK(axis.at(0) == 50);
}

TEST_CASE("a logarithmic axis has a tick at each decade, and at three of it where there are few decades") {
  CHECK(LogAxis{.low = -1, .high = 2}.ticks().size() == 4);
  const auto values = LogAxis{.low = 0, .high = 2, .threes = true}.ticks();
  REQUIRE(values.size() == 5);
  for (std::size_t i = 0; i < values.size(); ++i)
    CHECK(values[i] == Approx((i % 2 == 0 ? 1 : 3) * std::pow(10, static_cast<double>(i / 2))));
  CHECK(LogAxis{.low = 0, .high = 5, .threes = true}.ticks().size() == 6);
}

TEST_CASE("each tick of a plot is drawn at the value that it names, and each axis has its label") {
  const LogAxis x{.low = 0, .high = 3, .start = 70, .end = 600, .label = "time [s]", .threes = true};
  const LogAxis up{.low = -2, .high = 1, .start = 370, .end = 60, .label = "force [N]"};
  LogAxis down = up;
  std::swap(down.start, down.end);
  for (const LogAxis& y : {up, down}) {
    Drawing drawing;
    drawing.axes(x, y);
    const std::string svg = drawing.svg("a title", {640, 420});
    const auto along = ticks_of(svg, "x"), upward = ticks_of(svg, "y");
    REQUIRE(along.size() == 7);
    REQUIRE(upward.size() == 4);
    for (const Tick& tick : along) CHECK(tick.at_px == Approx(x.at(std::stod(tick.words))).margin(0.06));
    // The line of figures has its middle 4 px above its base.
    for (const Tick& tick : upward) CHECK(tick.at_px - 4 == Approx(y.at(std::stod(tick.words))).margin(0.06));
    CHECK(count(svg, "<line class=\"grid\"") == 11);
    CHECK_THAT(svg, Contains(">time [s]</text>") && Contains(">force [N]</text>"));
  }
}

TEST_CASE("an axis with words of its own for its ticks says these") {
  Drawing drawing;
  drawing.axes({.low = 0, .high = 1, .start = 0, .end = 9},
               {.low = 0, .high = 1, .start = 0, .end = 9, .tick_text = [](double n) {
                  return n == 1 ? std::string("all") : "1 in " + number_text(n);
                }});
  const auto ticks = ticks_of(drawing.svg("", {9, 9}), "y");
  REQUIRE(ticks.size() == 2);
  CHECK(ticks[0].words == "all");
  CHECK(ticks[1].words == "1 in 10");
}

TEST_CASE("a curve goes through its points in order, a mark and a box lie where they are put") {
  Drawing drawing;
  drawing.curve(2, "a name", {{1, 2}, {3.25, 4}});
  drawing.mark(0, {5, 6});
  drawing.box({7, 8}, {9, 10}, "#e5e5e5");
  const std::string svg = drawing.svg("a title", {640, 420});
  CHECK_THAT(svg, Contains("<polyline class=\"series s2\" data-series=\"a name\" points=\"1.0,2.0 3.2,4.0 \"/>"));
  CHECK_THAT(svg, Contains("<circle class=\"series s0\" cx=\"5.0\" cy=\"6.0\""));
  CHECK_THAT(svg, Contains("<rect x=\"7.0\" y=\"8.0\" width=\"9.0\" height=\"10.0\" fill=\"#e5e5e5\"/>"));
}

TEST_CASE("any text is drawn as text: no character of it ends or begins an element, and no control character stays") {
  const std::string odd = "</text> & \"\x01\n<svg";
  const std::string written = "&lt;/text&gt; &amp; &quot;  &lt;svg";
  Drawing drawing;
  drawing.text("key", {0, 0}, Anchor::kStart, odd);
  drawing.curve(0, odd, {});
  drawing.axes({.label = odd}, {.label = odd});
  const std::string svg = drawing.svg(odd, {640, 420});
  CHECK(count(svg, written) == 5);
  CHECK(count(svg, "<svg") == 1);
  CHECK(count(svg, "<text ") == count(svg, "</text>"));
  CHECK(svg.find('\x01') == std::string::npos);
  CHECK_THAT(svg, Catch::StartsWith("<svg ") && Catch::EndsWith("</svg>\n"));
}

TEST_CASE("a paragraph is divided at spaces, never between a number and its unit") {
  Drawing drawing;
  CHECK(drawing.paragraph("made", {8, 24}, "half were done 12 ms after", 17) == 24 + 2 * 16);
  const std::string svg = drawing.svg("", {99, 99});
  CHECK_THAT(svg, Contains("y=\"24.0\" text-anchor=\"start\">half were done</text>"));
  CHECK_THAT(svg, Contains("y=\"40.0\" text-anchor=\"start\">12 ms after</text>"));
}

TEST_CASE("no line of a paragraph is longer than asked, and together they have every letter") {
  auto random = test::Random(2);
  for (int i = 0; i < 100; ++i) {
    std::string words;
    for (int k = 0; k < 60; ++k) words += random(0, 1) < 0.15 ? ' ' : 'a';
    Drawing drawing;
    drawing.paragraph("made", {0, 0}, words, 20);
    const std::string svg = drawing.svg("", {99, 99});
    static const std::regex kLine(">([ a]*)</text>");
    std::size_t letters = 0;
    for (std::sregex_iterator at(svg.begin(), svg.end(), kLine), end; at != end; ++at) {
      const std::string line = (*at)[1];
      CHECK(line.size() <= 20);
      letters += count(line, "a");
    }
    CHECK(letters == count(words, "a"));
  }
}
