// The picture of the scores, of a made report.
#include "tools/validation/report.h"

#include <catch2/catch.hpp>
#include <regex>

using namespace tactus::hard_cases;
using Catch::Contains;

namespace {

Outcome no_run(const Setting&) { return {}; }

}  // namespace

TEST_CASE(
    "the picture of the scores has a box for each case and setting, with its score, and a grey one without a run") {
  const HardCase both{1, "a < b", true, no_run}, fine{2, "only in 1 ms", false, no_run};
  Report report;
  for (const HardCase* one : {&both, &fine})
    for (const double step_s : {1e-3, 1e-2}) {
      if (step_s > 5e-3 && !one->global_step) continue;
      Row row{one, {Accuracy::kBalanced, step_s}, {}};
      row.outcome.at_most("error", one == &both && step_s > 5e-3 ? 1 : 0, 0.1);
      report.rows.push_back(row);
    }
  const std::string svg = report_svg(report);
  const std::regex box("<rect [^>]*fill=\"([^\"]*)\"/>\n<text class=\"boxed\"[^>]*>([^<]*)<");
  std::vector<std::string> boxes;
  for (std::sregex_iterator at(svg.begin(), svg.end(), box), end; at != end; ++at)
    boxes.push_back((*at)[1].str() + " " + (*at)[2].str());
  // A factor of ten beyond the tolerance costs a half: 120 degrees of colour are green, 60 yellow.
  CHECK(boxes == std::vector<std::string>{"hsl(120,60%,70%) 1.00", "hsl(60,60%,70%) 0.50 FAIL", "hsl(120,60%,70%) 1.00",
                                          "#e5e5e5 -"});
  CHECK_THAT(svg,
             Contains(">1 a &lt; b</text>") && Contains(">balanced 1 ms</text>") && Contains(">balanced 10 ms</text>"));
}
