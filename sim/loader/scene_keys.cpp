#include "sim/loader/scene_keys.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/loader/scene_load_effects.h"
#include "sim/loader/scene_load_generators.h"
#include "sim/loader/scene_meanings.h"
#include "sim/model/scene_effects.h"

namespace tactus::sim {
namespace {

// The head of a scene that declares every effect; one variant of a table is appended at a time.
std::string head() {
  std::string effects;
  for (const auto& effect : known_effects()) effects += fmt::format("\"{}\", ", effect.name);
  return "effects = [" + effects +
         "]\n[simulation]\nglobal_sub_steps_per_tick = 16\n[[hull_file]]\n[[mesh_file]]\nname = \"a.stl\"\n"
         "corners_m = [0, 0, 0, 1, 0, 0, 0, 1, 0]\ntriangles = [0, 1, 2]\n"
         "[[motion_file]]\nname = \"a.csv\"\nrows = [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]\n[proxy]\nshape = "
         "\"sphere\"\n";
}

struct Variant {
  std::string_view table;
  std::string name, text;
};

void add_part_variants(std::vector<Variant>& all) {
  const auto add = [&all](const std::string& shape, const std::string& keys) {
    const std::string parts = fmt::format("shape = \"compound\"\nparts = [{{shape = \"{}\"{}}}]\n", shape, keys);
    all.push_back({"[[body]] parts", shape, head() + "[[body]]\n" + parts});
    all.push_back({"[proxy] parts", shape, "[proxy]\n" + parts});
  };
  for (const physics::ShapeKind kind : physics::kShapeKinds) {
    if (!traits_of(kind).is_part) continue;
    const std::string shape{traits_of(kind).name};
    if (shape == "hull") add(shape, ", file = \"a.stl\"");
    add(shape, shape == "hull" ? ", points_m = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]" : "");
  }
}

std::vector<Variant> variants() {
  const std::string pointed = "points_m = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
  std::vector<Variant> all;
  for (const physics::ShapeKind kind : physics::kShapeKinds) {
    const std::string shape{traits_of(kind).name};
    std::string text = fmt::format("{}[[body]]\nshape = \"{}\"\n", head(), shape);
    if (shape == "mesh") text += "file = \"a.stl\"\n";
    if (shape == "compound") {  // with a mass of its own, then without
      text += "parts = [{shape = \"sphere\"}]\n";
      all.push_back({"[[body]]", shape, text + "mass_kg = 1\n"});
    }
    // With points, then with a file: the loader requests only one of the two at a time.
    if (shape == "hull") {
      all.push_back({"[[body]]", shape, text + "file = \"a.stl\"\n"});
      text += pointed;
    }
    all.push_back({"[[body]]", shape, text});
    all.push_back({"[[body]]", shape,
                   text + "kinematic = true\nrepeat_path = true\npath = [{time_s = 0, position_m = [0, 0, 0]}]\n"});
    if (traits_of(kind).moves) {
      std::string proxy = fmt::format("[proxy]\nshape = \"{}\"\n", shape);
      if (shape == "hull") {
        all.push_back({"[proxy]", shape, proxy + "file = \"a.stl\"\n"});
        proxy += pointed;
      }
      if (shape == "compound") {
        proxy += "parts = [{shape = \"sphere\"}]\n";
        all.push_back({"[proxy]", shape, proxy + "mass_kg = 1\n"});
      }
      all.push_back({"[proxy]", shape, proxy});
    }
  }
  add_part_variants(all);
  for (const std::string_view kind : generator_names())
    all.push_back({"[[generate]]", std::string(kind), fmt::format("{}[[generate]]\nkind = \"{}\"\n", head(), kind)});
  for (const std::string_view kind : kJointKinds)
    all.push_back({"[[joint]]", std::string(kind),
                   fmt::format("{}[[joint]]\nkind = \"{}\"\nb = \"proxy\"\nbreak_force_N = 1\nbreak_torque_Nm = 1\n",
                               head(), kind)});
  all.push_back({"[hand]", "path", head() + "[hand]\npath = [{time_s = 0, position_m = [0, 0, 0]}]\n"});
  all.push_back({"[hand]", "file", head() + "[hand]\nfile = \"a.csv\"\n"});
  all.push_back({"", "", head() + "[[attraction]]\n"});
  return all;
}

const Meaning* find_meaning(std::string_view table, std::string_view key) {
  for (const auto& m : kMeanings)
    if (m.table == table && m.key == key) return &m;
  return nullptr;
}

// The entry of the key's own table, else the shared one of bodies, surfaces or poses.
const Meaning* meaning_of(const text::AskedKey& asked) {
  if (const Meaning* own = find_meaning(asked.table, asked.key)) return own;
  const bool is_body = asked.table == "[[body]]" || asked.table == "[proxy]";
  if (asked.table == "[[body]] parts" || asked.table == "[proxy] parts") {
    const Meaning* own = find_meaning("part", asked.key);
    return own != nullptr ? own : find_meaning("body", asked.key);
  }
  const bool has_surface = is_body || asked.table == "[[generate]]";
  if (is_body)
    if (const Meaning* m = find_meaning("body", asked.key)) return m;
  if (has_surface)
    if (const Meaning* m = find_meaning("surface", asked.key)) return m;
  if (has_surface || asked.table == "[device]") return find_meaning("pose", asked.key);
  return nullptr;
}

struct Found {
  text::AskedKey asked;
  std::vector<std::string> with;  // the variants of its table that have it
};

// The same key with different defaults or ranges, as in generators and joints, is a separate row, unless the default is
// given in words.
bool is_same(const text::AskedKey& a, const text::AskedKey& b) {
  if (a.table != b.table || a.key != b.key) return false;
  const Meaning* meaning = meaning_of(a);
  const bool said = meaning != nullptr && !meaning->fallback.empty();
  return said || a.type == text::AskedKey::Type::kUnknown || b.type == text::AskedKey::Type::kUnknown ||
         (a.fallback == b.fallback && a.low == b.low && a.high == b.high);
}

std::vector<Found> ask_everything(std::vector<std::pair<std::string, std::string>>& tried) {
  std::vector<Found> found;
  for (const Variant& variant : variants()) {
    const std::pair<std::string, std::string> name{variant.table, variant.name};
    if (std::find(tried.begin(), tried.end(), name) == tried.end()) tried.push_back(name);
    for (text::AskedKey& asked : asked_keys(variant.text)) {
      const auto same = [&](const Found& f) { return is_same(f.asked, asked); };
      auto at = std::find_if(found.begin(), found.end(), same);
      if (at == found.end()) at = found.insert(found.end(), Found{asked, {}});
      if (at->asked.type == text::AskedKey::Type::kUnknown) at->asked = asked;
      if (asked.table != variant.table) continue;
      if (at->with.empty() || at->with.back() != variant.name) at->with.push_back(variant.name);
    }
  }
  return found;
}

std::size_t order_of(const text::AskedKey& asked) {
  const Meaning* meaning = meaning_of(asked);
  return meaning == nullptr ? std::size(kMeanings) : static_cast<std::size_t>(meaning - kMeanings);
}

// "box, hull"; empty if all variants of the table have the key.
std::string some_of(const std::vector<std::string>& with, std::size_t variants_of_table) {
  std::string list;
  if (with.size() < variants_of_table)
    for (const std::string& name : with) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

std::span<const EitherKey> either_keys() noexcept {
  // Table, only with, key, other key, one of them needed.
  static constexpr EitherKey kEither[] = {{"[[body]]", "", "mass_kg", "density_kg_per_m3", true},
                                          {"[proxy]", "", "mass_kg", "density_kg_per_m3", true},
                                          {"[[body]]", "hull", "points_m", "file", true},
                                          {"[proxy]", "hull", "points_m", "file", true},
                                          {"[[body]] parts", "hull", "points_m", "file", true},
                                          {"[proxy] parts", "hull", "points_m", "file", true},
                                          {"[hand]", "", "path", "file", false}};
  return kEither;
}

std::vector<SceneTable> scene_language() {
  std::vector<std::pair<std::string, std::string>> tried;
  const auto found = ask_everything(tried);
  std::vector<SceneTable> language;
  for (const Purpose& purpose : kPurposes)
    language.push_back({std::string(purpose.table), std::string(purpose.text), {}});
  for (const Found& f : found) {
    auto table = std::find_if(language.begin(), language.end(), [&](const auto& t) { return t.name == f.asked.table; });
    if (table == language.end()) table = language.insert(language.end(), {f.asked.table, "", {}});
    const auto variants_of_table = static_cast<std::size_t>(
        std::count_if(tried.begin(), tried.end(), [&](const auto& v) { return v.first == f.asked.table; }));
    SceneKey key{
        .asked = f.asked, .only_with = some_of(f.with, variants_of_table), .meaning = "", .fallback = f.asked.fallback};
    if (const Meaning* meaning = meaning_of(f.asked)) {
      key.meaning = meaning->text;
      if (!meaning->fallback.empty()) {
        key.fallback = meaning->fallback;
        key.asked.required = false;
      }
    }
    if (key.asked.required) key.fallback.clear();
    table->keys.push_back(std::move(key));
  }
  for (SceneTable& table : language)
    std::stable_sort(table.keys.begin(), table.keys.end(),
                     [](const SceneKey& a, const SceneKey& b) { return order_of(a.asked) < order_of(b.asked); });
  return language;
}

std::vector<std::string> superfluous_meanings() {
  std::vector<std::pair<std::string, std::string>> tried;
  const auto found = ask_everything(tried);
  std::vector<std::string> list;
  for (const Meaning& meaning : kMeanings)
    if (std::none_of(found.begin(), found.end(), [&](const Found& f) { return meaning_of(f.asked) == &meaning; }))
      list.push_back(fmt::format("{} {}", meaning.table, meaning.key));
  return list;
}

std::string type_of(const text::AskedKey& key) {
  switch (key.type) {
    case text::AskedKey::Type::kNumber:
      return "number";
    case text::AskedKey::Type::kCount:
    case text::AskedKey::Type::kSeed:
      return "whole number";
    case text::AskedKey::Type::kFlag:
      return "true or false";
    case text::AskedKey::Type::kText:
      return "text";
    case text::AskedKey::Type::kWord:
      return "one of";
    case text::AskedKey::Type::kVector:
      return "[x, y, z]";
    case text::AskedKey::Type::kTable:
      return "table";
    case text::AskedKey::Type::kArray:
      return "list";
    case text::AskedKey::Type::kUnknown:
      break;
  }
  return "";
}

std::string unit_of(const text::AskedKey& key) {
  static constexpr std::pair<std::string_view, std::string_view> kUnits[] = {{"_kg_per_m3", "kg/m3"},
                                                                             {"_Ns_per_m", "N s/m"},
                                                                             {"_Nms_per_rad", "N m s/rad"},
                                                                             {"_N_per_m", "N/m"},
                                                                             {"_Nm_per_rad", "N m/rad"},
                                                                             {"_rad_per_s", "rad/s"},
                                                                             {"_m_per_s2", "m/s2"},
                                                                             {"_m_per_s", "m/s"},
                                                                             {"_per_s", "1/s"},
                                                                             {"_kg_m2", "kg m2"},
                                                                             {"_Nm2", "N m2"},
                                                                             {"_Nm", "N m"},
                                                                             {"_N", "N"},
                                                                             {"_Hz", "Hz"},
                                                                             {"_rad", "rad"},
                                                                             {"_kg", "kg"},
                                                                             {"_s", "s"},
                                                                             {"_m", "m"}};
  for (const auto& [end, unit] : kUnits)
    if (key.key.size() > end.size() && std::string_view(key.key).substr(key.key.size() - end.size()) == end)
      return std::string(unit);
  return "";
}

std::string values_of(const text::AskedKey& key) {
  switch (key.type) {
    case text::AskedKey::Type::kNumber:
    case text::AskedKey::Type::kCount:
      return fmt::format("{:g} to {:g}", key.low, key.high);
    case text::AskedKey::Type::kVector:
      return fmt::format("each {:g} to {:g}", key.low, key.high);
    case text::AskedKey::Type::kSeed:
      return "0 and more";
    case text::AskedKey::Type::kText:
      return fmt::format("at most {:g} characters", key.high);
    case text::AskedKey::Type::kArray:
      return fmt::format("at most {:g}", key.high);
    case text::AskedKey::Type::kWord: {
      std::string list;
      for (const std::string& word : key.words) list += (list.empty() ? "" : ", ") + word;
      return list;
    }
    default:
      return "";
  }
}

}  // namespace tactus::sim
