#include "rt/text/table_reader.h"

#include <catch2/catch.hpp>

using namespace tactus::text;

namespace {

struct Document {
  Diagnostics diagnostics;
  TomlNode root;

  explicit Document(std::string_view text) {
    diagnostics.name = "x.toml";
    REQUIRE(read_toml(text, root, diagnostics));
  }
  TableReader reader() { return {&root, "[body]", diagnostics}; }
};

constexpr Range kMass{"a mass", 0, 10};

}  // namespace

TEST_CASE("a key gives its value, an absent one the default") {
  Document document("mass_kg = 2.5\ncopies = 3\nfixed = true\nname = \"lid\"\nposition_m = [1, 2, 3]\n");
  TableReader t = document.reader();
  CHECK(t.number("mass_kg", 1, kMass) == 2.5);
  CHECK(t.count("copies", 1, {"a number of copies", 1, 5}) == 3);
  CHECK(t.flag("fixed", false));
  CHECK(t.text("name", "", 10) == "lid");
  CHECK(t.vector("position_m", {}, {"a place", -5, 5}) == tactus::Vec3d{1, 2, 3});
  CHECK(t.number("density", 7, kMass) == 7);
  t.finish();
  CHECK(document.diagnostics.ok());
}

TEST_CASE("each mistake is one line with its place, what is there and what is accepted, in the order of the text") {
  Document document("mas_kg = 2\nmass_kg = -1\nshape = \"bal\"\ncopies = 2.0\nmotor = 1\n");
  TableReader t = document.reader();
  CHECK(t.word("shape", "box", {"box", "ball"}) == "box");
  CHECK(t.number("mass_kg", 5, kMass) == 5);
  CHECK(t.count("copies", 1, {"a number of copies", 1, 5}) == 1);
  t.refuse("motor", "a box has none", "leave it out");
  t.finish();
  document.diagnostics.sort_by_place();
  CHECK(document.diagnostics.message() ==
        "x.toml:1:1: [body] mas_kg: not a key, did you mean mass_kg?; accepted: copies, mass_kg, motor, shape\n"
        "x.toml:2:11: [body] mass_kg: -1 is not a mass; accepted: a number >= 0 and <= 10\n"
        "x.toml:3:9: [body] shape: \"bal\" is not known, did you mean ball?; accepted: box, ball\n"
        "x.toml:4:10: [body] copies: 2 is written with a decimal point; accepted: a whole number from 1 to 5, such as "
        "2\n"
        "x.toml:5:9: [body] motor: a box has none; accepted: leave it out");
}

TEST_CASE("a number that is none is outside of every range") {
  Document document("mass_kg = nan\n");
  CHECK(document.reader().number("mass_kg", 5, kMass) == 5);
  CHECK(document.diagnostics.mistakes.size() == 1);
}

TEST_CASE("mistakes beyond the limit are counted") {
  Diagnostics diagnostics;
  diagnostics.name = "x.toml";
  for (std::size_t i = 0; i < kMaxReportedMistakes + 7; ++i) diagnostics.add({1, 1, "k", "wrong", "right"});
  CHECK(diagnostics.mistakes.size() == kMaxReportedMistakes);
  CHECK_THAT(diagnostics.message(), Catch::EndsWith("x.toml: and 7 more"));
}
