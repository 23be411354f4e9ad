// glTF: properties of its nodes, mirrored nodes, depth, and files that are changed at random.
#include <iterator>

#include "tests/support/random.h"
#include "tests/tools/import/import_bench.h"

using namespace tactus;
using namespace tactus::test;
using namespace tactus::scene_import;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == std::string::npos; }

std::string blocks() {
  std::ifstream in(kModels / "blocks.gltf", std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string with(std::string text, const std::string& old, const std::string& now) {
  const std::size_t at = text.find(old);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old.size(), now);
}

// The crate's properties are these.
std::string crate_of(const std::string& properties) {
  return with(blocks(), "\"mass_kg\": 0.3,\n    \"friction\": 0.4", properties);
}

}  // namespace

TEST_CASE("a property of a node that counts is a number within its limits, or refused by its name") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const auto lines_for = [&](const std::string& properties) {
    return refusal(options_for(scratch.write("crate.gltf", crate_of(properties))));
  };
  CHECK_THAT(lines_for("\"friction\": -2"),
             Catch::Matchers::Equals("crate.gltf: node \"crate\": friction: -2; accepted: a number, 0 or more"));
  CHECK_THAT(
      lines_for("\"mass_kg\": \"x\""),
      Catch::Matchers::Equals("crate.gltf: node \"crate\": mass_kg: no number; accepted: a number, 1e-06 kg or more"));
  CHECK_THAT(lines_for("\"density_kg_per_m3\": 0"), Contains("density_kg_per_m3: 0; accepted: "));
  CHECK_THAT(lines_for("\"fixed\": \"yes\""), Contains("fixed: no number; accepted: true or false"));
  CHECK_THAT(lines_for("\"mass_kg\": 1e9"), Contains("mass_kg: 1000000000 is not a mass"));
  CHECK_THAT(lines_for("\"friction\": 1e9"), Contains("friction: 1000000000 is not"));
  CHECK_THAT(lines_for("\"mass_kg\": -1, \"friction\": \"rough\""),
             Contains("mass_kg: -1") && Contains("friction: no number"));
}

TEST_CASE("a property of a node that is not known is left out, and the account says which was meant") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const auto made = imported(
      options_for(scratch.write("crate.gltf", crate_of("\"mas_kg\": 3, \"colour\": \"red\", \"friction\": 0.4"))));
  CHECK(std::ranges::count(made.account.left_out,
                           "custom properties of node \"crate\": colour, mas_kg (did you mean mass_kg?)") == 1);
  CHECK(loaded(made).bodies[1].friction == Approx(0.4));
}

TEST_CASE("a mirrored node is a solid, of the same mass") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const auto made = imported(options_for(scratch.write(
      "mirror.gltf", with(crate_of("\"friction\": 0.4"), "\"mesh\": 0,", "\"mesh\": 0, \"scale\": [-1, 1, 1],"))));
  const auto plain = imported(options_for(scratch.write("plain.gltf", crate_of("\"friction\": 0.4"))));
  CHECK(loaded(made).bodies[1].mass == Approx(loaded(plain).bodies[1].mass).epsilon(1e-6));
}

TEST_CASE("the material that assimp makes up is not counted") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const auto file =
      scratch.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  CHECK(imported(options_for(file)).account.left_out.empty());
  CHECK(imported("blocks.gltf").account.left_out.empty());
}

TEST_CASE("glTF of deep nodes, of nodes in a circle and of deep JSON ends with one line that says so") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const auto chain = [&](unsigned nodes, unsigned last) {
    std::string text = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[";
    for (unsigned i = 0; i + 1 < nodes; ++i) text += fmt::format("{{\"children\":[{}]}},", i + 1);
    text += last == 0 ? "{\"children\":[0]}]}" : "{}]}";
    return scratch.write("deep.gltf", text);
  };
  CHECK_THAT(refusal(options_for(chain(50'000, 1))), StartsWith("deep.gltf: has nodes deeper than 100"));
  CHECK_THAT(refusal(options_for(chain(102, 1))), StartsWith("deep.gltf: has nodes deeper than 100"));
  CHECK_THAT(refusal(options_for(chain(101, 1))), Contains("no triangles"));
  CHECK_THAT(refusal(options_for(chain(3, 0))), Contains("in a circle"));
  const std::string nested(100'000, '[');
  CHECK_THAT(refusal(options_for(scratch.write("nested.gltf", "{\"a\":" + nested))),
             Contains("JSON nested deeper than 100"));
  std::string glb = "{\"a\":" + nested;
  const auto word = [](std::uint32_t value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
  const auto size = static_cast<std::uint32_t>(glb.size());
  glb = "glTF" + word(2) + word(size + 20) + word(size) + "JSON" + glb;
  CHECK_THAT(refusal(options_for(scratch.write("nested.glb", glb))), Contains("JSON nested deeper than 100"));
}

TEST_CASE("glTF that is changed at random ends with a scene or with lines of its name") {
  TACTUS_NEEDS_ASSIMP();
  const Scratch scratch;
  const std::string good = blocks();
  Random random(25);
  for (int i = 0; i < 60; ++i) {
    std::string text = good;
    for (std::uint64_t k = 0, changes = 1 + random.below(8); k < changes; ++k) {
      const std::size_t at = random.below(static_cast<std::uint32_t>(text.size()));
      if (random.below(2) == 0)
        text[at] = static_cast<char>(random.below(256));
      else
        text[at] = "0123456789-.,:[]{}\""[random.below(19)];
    }
    if (i % 10 == 0) text.resize(random.below(static_cast<std::uint32_t>(text.size())));
    CAPTURE(i);
    Imported made;
    const auto error = import_file(options_for(scratch.write("changed.gltf", text)), made);
    if (error) {
      CHECK_THAT(error->message, StartsWith("changed.gltf: "));
      CHECK(is_one_line(error->message));
    } else if (made.account.refused.empty()) {
      loaded(made);
    } else {
      CHECK(made.files.text.empty());
    }
  }
}
