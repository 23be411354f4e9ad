// Results of parts cross to another process whole, or are refused.
#include "tools/experiment/part_bytes.h"

#include <catch2/catch.hpp>

#include "tools/experiment/coupling/study_fields.h"

using namespace tactus;
using namespace tactus::experiment;

namespace {

StudyReport some_report() {
  StudyReport report;
  report.seeds = 3;
  report.window_s = 0.2;
  StudyRow row;
  row.scene = "a scene";
  row.scheme.ratio = 16;
  row.force_error = 0.1;
  row.by_seed = {{.force_error = 1}, {.force_error = 2}};
  row.spectrum = {1, 0.5, 0.25};
  report.rows = {row, row};
  StudyScene scene;
  scene.name = "a scene";
  scene.bodies = 7;
  report.scenes = {scene};
  WholeRunRow whole;
  whole.force_error_quarter = {1, 2, 3, 4};
  whole.end.resize(2);
  whole.end[1].id = 12;
  report.whole = {whole};
  return report;
}

}  // namespace

TEST_CASE("a report is what it was, in another process") {
  const StudyReport report = some_report();
  const auto again = from_part_bytes<StudyReport>(to_part_bytes(report));
  REQUIRE(again.ok());
  CHECK(study_json(again.value()) == study_json(report));
  CHECK(again.value().rows[1].by_seed[1].force_error == 2);
  CHECK(again.value().whole[0].end[1].id == 12);
  CHECK(again.value().whole[0].force_error_quarter[3] == 4);
}

TEST_CASE("bytes that are cut off anywhere, or go on, are refused") {
  const std::string bytes = to_part_bytes(some_report());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    REQUIRE_FALSE(from_part_bytes<StudyReport>(bytes.substr(0, size)).ok());
  CHECK_FALSE(from_part_bytes<StudyReport>(bytes + "x").ok());
  CHECK_FALSE(from_part_bytes<std::vector<double>>(std::string(8, char(0xff))).ok());
}
