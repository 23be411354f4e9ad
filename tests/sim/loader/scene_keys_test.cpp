#include "sim/loader/scene_keys.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "rt/text/toml.h"

using namespace tactus;
using namespace tactus::sim;

namespace {

const SceneTable& table(const std::vector<SceneTable>& language, std::string_view name) {
  for (const auto& t : language)
    if (t.name == name) return t;
  FAIL("no table " << name);
  throw;
}

const SceneKey& key(const SceneTable& t, std::string_view name, std::string_view with = "") {
  for (const auto& k : t.keys)
    if (k.asked.key == name && (with.empty() || k.only_with == with)) return k;
  FAIL("no key " << name << " in " << t.name);
  throw;
}

// "table key" of everything in a document that the language does not have.
void collect_unknown(const text::TomlNode& node, const std::string& where, const std::vector<SceneTable>& language,
                     std::vector<std::string>& unknown) {
  const SceneTable& t = table(language, where);
  for (const text::TomlNode& item : node.items) {
    const bool known =
        std::any_of(t.keys.begin(), t.keys.end(), [&](const auto& k) { return k.asked.key == item.key; });
    if (!known) unknown.push_back(where + " " + item.key);
    const bool is_list =
        item.kind == text::TomlKind::kArray && !item.items.empty() && item.items[0].kind == text::TomlKind::kTable;
    const std::string below = !where.empty() ? where + " " + item.key
                              : is_list      ? "[[" + item.key + "]]"
                                             : "[" + item.key + "]";
    if (item.kind == text::TomlKind::kTable) collect_unknown(item, below, language, unknown);
    if (is_list)
      for (const text::TomlNode& entry : item.items) collect_unknown(entry, below, language, unknown);
  }
}

}  // namespace

TEST_CASE("every key that the loader reads has a sentence and a type, and no sentence is left over") {
  const auto language = scene_language();
  std::size_t keys = 0;
  for (const auto& t : language) {
    CHECK(!t.purpose.empty());
    for (const auto& k : t.keys) {
      INFO(t.name << ' ' << k.asked.key);
      CHECK(!k.meaning.empty());
      CHECK(!type_of(k.asked).empty());
      ++keys;
    }
  }
  CHECK(keys > 150);
  CHECK(superfluous_meanings() == std::vector<std::string>{});
}

TEST_CASE("every key of every scene that ships is in the scene language") {
  const auto language = scene_language();
  for (const auto& entry : std::filesystem::directory_iterator(TACTUS_SOURCE_DIR "/sim/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    INFO(entry.path());
    std::ifstream file(entry.path());
    std::stringstream text;
    text << file.rdbuf();
    text::Diagnostics diagnostics;
    text::TomlNode root;
    REQUIRE(text::read_toml(text.str(), root, diagnostics));
    std::vector<std::string> unknown;
    collect_unknown(root, "", language, unknown);
    CHECK(unknown == std::vector<std::string>{});
  }
}

TEST_CASE("a key is listed with the shapes, generators and joints that have it, its range and its default") {
  const auto language = scene_language();
  const auto& body = table(language, "[[body]]");
  CHECK(key(body, "size_m").only_with == "box");
  CHECK(key(body, "size_m").asked.required);
  CHECK(key(body, "radius_m").only_with == "sphere, capsule, cylinder, cone");
  CHECK(key(body, "file").only_with == "hull, mesh");
  CHECK(key(body, "friction").only_with.empty());
  CHECK(key(body, "mass_kg").only_with == "box, sphere, capsule, cylinder, cone, hull, compound");
  CHECK(key(body, "shape").asked.required);
  const auto& generate = table(language, "[[generate]]");
  CHECK(key(generate, "count", "pile").fallback == "700");
  CHECK(key(generate, "count", "domino_row").fallback == "20");
  CHECK(key(generate, "levels").only_with == "card_house");
  const auto& joint = table(language, "[[joint]]");
  CHECK(key(joint, "axis").only_with == "hinge, slider");
  CHECK(key(joint, "motor_torque_Nm").only_with == "hinge");
  const auto& hand = table(language, "[hand]");
  CHECK(key(hand, "path").only_with == "path");
  CHECK(key(hand, "interpolation").only_with == "file");
  CHECK(key(hand, "mass_kg").only_with.empty());
  const auto& simulation = table(language, "[simulation]");
  CHECK(values_of(key(simulation, "ratio").asked) == "1 to 64");
  CHECK(key(simulation, "ratio").fallback == "10");
  CHECK(type_of(key(simulation, "ratio").asked) == "whole number");
  CHECK(values_of(key(simulation, "far_sub_steps_per_tick").asked) == "0.1 to 16");
  CHECK_FALSE(key(body, "mass_kg").asked.required);  // or a density
  CHECK(unit_of(key(table(language, "[coupling]"), "damping_Nms_per_rad").asked) == "N m s/rad");
  CHECK(unit_of(key(table(language, "[hand] path"), "time_s").asked) == "s");
}

TEST_CASE("reading a scene notes each key of a table once, whether it is there or not") {
  const auto asked = asked_keys("[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 1\n[simulation]\nratio = 8\n");
  std::set<std::string> seen;
  for (const auto& a : asked) {
    INFO(a.table << ' ' << a.key);
    CHECK(seen.insert(a.table + ' ' + a.key).second);
  }
  CHECK(seen.count("[simulation] ratio") == 1);
  CHECK(seen.count("[simulation] members") == 1);  // not in the text
  CHECK(seen.count("[proxy] radius_m") == 1);
  CHECK(seen.count("[proxy] size_m") == 0);  // a box has it
}

TEST_CASE("of two keys that stand in each other's place the loader takes one") {
  const std::string proxy = "[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 1\n";
  const auto written = [](std::string_view key) {
    if (key == "path") return std::string("path = [{time_s = 0, position_m = [0, 0, 0]}]\n");
    if (key == "file") return std::string("file = \"no.obj\"\n");
    if (key == "points_m") return std::string("points_m = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]\n");
    return std::string(key) + " = 1000\n";
  };
  for (const EitherKey& either : either_keys()) {
    INFO(either.table << ' ' << either.key << ' ' << either.other);
    std::string head = std::string(either.table) + "\n";
    if (either.table == "[[body]] parts") head = "[[body]]\nshape = \"compound\"\nmass_kg = 1\n[[body.parts]]\n";
    if (either.table == "[proxy] parts") head = "[proxy]\nshape = \"compound\"\nmass_kg = 1\n[[proxy.parts]]\n";
    const bool of_part = head.find("parts") != std::string::npos, of_proxy = either.table.starts_with("[proxy]");
    if (either.table != "[hand]" && either.only_with.empty()) head += "shape = \"sphere\"\nradius_m = 0.01\n";
    if (either.only_with == "hull") head += of_part ? "shape = \"hull\"\n" : "shape = \"hull\"\nmass_kg = 1\n";
    const auto says = [&](const std::string& keys) {
      return parse_scene(head + keys + (of_proxy ? "" : proxy), "x.toml").message();
    };
    const std::string both = says(written(either.key) + written(either.other)), neither = says("");
    CHECK(both.find("already") != std::string::npos);
    CHECK((neither.find("missing") != std::string::npos) == either.needed);
    CHECK(says(written(either.key)).empty());
  }
}
