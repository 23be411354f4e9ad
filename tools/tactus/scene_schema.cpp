#include "tools/tactus/scene_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/model/scene_effects.h"

namespace tactus::tools {
namespace {

using nlohmann::ordered_json;
using sim::SceneKey;
using sim::SceneTable;
using text::AskedKey;

ordered_json schema_of(const SceneKey& key) {
  ordered_json j;
  switch (key.asked.type) {
    case AskedKey::Type::kNumber:
      j = {{"type", "number"}, {"minimum", key.asked.low}, {"maximum", key.asked.high}};
      break;
    case AskedKey::Type::kCount:
      j = {{"type", "integer"}, {"minimum", key.asked.low}, {"maximum", key.asked.high}};
      break;
    case AskedKey::Type::kSeed:
      j = {{"type", "integer"}, {"minimum", 0}};
      break;
    case AskedKey::Type::kFlag:
      j = {{"type", "boolean"}};
      break;
    case AskedKey::Type::kText:
      j = {{"type", "string"}, {"maxLength", static_cast<unsigned>(key.asked.high)}};
      break;
    case AskedKey::Type::kWord:
      j = {{"enum", key.asked.words}};
      break;
    case AskedKey::Type::kVector:
      j = {{"type", "array"},
           {"items", {{"type", "number"}, {"minimum", key.asked.low}, {"maximum", key.asked.high}}},
           {"minItems", 3},
           {"maxItems", 3}};
      break;
    case AskedKey::Type::kArray:
      j = {{"type", "array"}, {"maxItems", static_cast<unsigned>(key.asked.high)}};
      break;
    default:
      j = {{"type", "object"}};
      break;
  }
  std::string text = key.meaning;
  if (!key.only_with.empty()) text += fmt::format("; of {}", key.only_with);
  if (!key.asked.required && !key.fallback.empty()) text += fmt::format("; default {}", key.fallback);
  j["description"] = text;
  return j;
}

ordered_json has(const std::string& key) { return {{"required", ordered_json::array({key})}}; }
ordered_json is(const std::string& key, const ordered_json& value) {
  ordered_json rule = has(key);
  rule["properties"][key]["const"] = value;
  return rule;
}
ordered_json none_of(const std::vector<ordered_json>& list) {
  ordered_json rule;
  rule["not"]["anyOf"] = list;
  return rule;
}

// True if `only_with` lists the variant, as "box, hull" lists "hull", or is empty (valid for all).
bool is_of(const std::string& only_with, const std::string& variant) {
  return only_with.empty() ||
         fmt::format(", {}, ", only_with).find(fmt::format(", {}, ", variant)) != std::string::npos;
}

// Adds the required and the forbidden keys of each shape or kind.
void add_variants(const SceneTable& table, ordered_json& rules) {
  const auto choice = std::find_if(table.keys.begin(), table.keys.end(), [](const SceneKey& key) {
    return key.asked.key == "shape" || key.asked.key == "kind";
  });
  if (choice == table.keys.end()) return;
  for (const std::string& variant : choice->asked.words) {
    std::map<std::string, bool> known;  // of this variant
    ordered_json required = ordered_json::array(), refused = ordered_json::object();
    for (const SceneKey& key : table.keys) known[key.asked.key] |= is_of(key.only_with, variant);
    for (const auto& [name, has_it] : known)
      if (!has_it) refused[name] = false;
    for (const SceneKey& key : table.keys)
      if (key.asked.required && !key.only_with.empty() && is_of(key.only_with, variant))
        required.push_back(key.asked.key);
    rules.push_back(
        {{"if", is(choice->asked.key, variant)}, {"then", {{"properties", refused}, {"required", required}}}});
  }
}

// Applies a rule only to bodies that need a mass: a fixed body has none, a kinematic one needs none, and that of a
// compound may be its parts'.
ordered_json when_it_has_mass(const ordered_json& rule) {
  const ordered_json without = none_of(
      {is("fixed", true), is("kinematic", true), is("shape", "plane"), is("shape", "mesh"), is("shape", "compound")});
  return {{"if", without}, {"then", rule}};
}

ordered_json rules_of(const SceneTable& table) {
  ordered_json rules = ordered_json::array();
  add_variants(table, rules);
  for (const sim::EitherKey& either : sim::either_keys()) {
    if (either.table != table.name) continue;
    const ordered_json one = has(std::string(either.key)), other = has(std::string(either.other));
    const ordered_json both{{"allOf", ordered_json::array({one, other})}};
    const ordered_json rule =
        either.needed ? ordered_json{{"oneOf", ordered_json::array({one, other})}} : ordered_json{{"not", both}};
    if (!either.only_with.empty())
      rules.push_back({{"if", is("shape", std::string(either.only_with))}, {"then", rule}});
    else
      rules.push_back(table.name == "[[body]]" || table.name == "[proxy]" ? when_it_has_mass(rule) : rule);
    if (either.only_with.empty()) rules.push_back({{"not", both}});
  }
  if (table.name == "[[body]]")
    rules.push_back(
        {{"if", is("fixed", true)},
         {"then", none_of({has("mass_kg"), has("density_kg_per_m3"), has("velocity_m_per_s"),
                           has("angular_velocity_rad_per_s"), has("inertia_kg_m2"), has("centre_of_mass_m")})}});
  if (table.name == "[[body]]")
    rules.push_back({{"if", none_of({is("kinematic", true)})}, {"then", none_of({has("path"), has("repeat_path")})}});
  if (table.name == "[hand]")
    rules.push_back({{"dependentRequired", {{"interpolation", ordered_json::array({"file"})}}}});
  return rules;
}

ordered_json schema_of(const SceneTable& table) {
  ordered_json properties = ordered_json::object(), required = ordered_json::array();
  for (const SceneKey& key : table.keys) {
    const std::string& name = key.asked.key;
    if (properties.contains(name)) {  // generators differ in range or default: accept what any of them accepts
      auto& other = properties[name];
      if (!other.contains("anyOf")) other = {{"anyOf", ordered_json::array({other})}};
      other["anyOf"].push_back(schema_of(key));
      continue;
    }
    properties[name] = schema_of(key);
    if (key.asked.required && key.only_with.empty()) required.push_back(name);
  }
  ordered_json schema{{"type", "object"},
                      {"description", table.purpose},
                      {"properties", properties},
                      {"required", required},
                      {"additionalProperties", false}};
  if (const ordered_json rules = rules_of(table); !rules.empty()) schema["allOf"] = rules;
  return schema;
}

}  // namespace

ordered_json scene_schema(const std::vector<SceneTable>& language) {
  ordered_json root = schema_of(language.front());
  for (const SceneTable& table : language) {
    if (table.name.empty()) continue;
    // "[[body]] path": the list `path` of each entry of the list `body`.
    const bool is_list = table.name.rfind("[[", 0) == 0;
    const std::size_t begin = is_list ? 2 : 1, end = table.name.find(']');
    const std::string name = table.name.substr(begin, end - begin);
    const std::size_t blank = table.name.find(' ');
    ordered_json& own = root["properties"][name];
    if (blank == std::string::npos) {
      (is_list ? own["items"] : own) = schema_of(table);
    } else {
      (is_list ? own["items"] : own)["properties"][table.name.substr(blank + 1)]["items"] = schema_of(table);
    }
  }
  for (const char* of_hand : {"proxy", "device", "coupling", "hand"}) {  // a table, or one for each hand
    ordered_json& own = root["properties"][of_hand];
    const ordered_json description = own["description"];
    const ordered_json list{{"type", "array"}, {"items", own}, {"minItems", 1}, {"maxItems", sim::kMaxHands}};
    own = {{"description", description}, {"anyOf", ordered_json::array({own, list})}};
  }
  ordered_json effects = ordered_json::array();
  for (const auto& effect : sim::known_effects()) effects.push_back(effect.name);
  root["properties"]["effects"]["items"] = {{"enum", effects}};
  root["properties"]["effects"]["uniqueItems"] = true;
  root["properties"]["body"]["items"]["properties"]["points_m"]["items"] = {
      {"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 3}, {"maxItems", 3}};
  ordered_json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "a scene of tactus"}};
  schema.update(root);
  return schema;
}

}  // namespace tactus::tools
