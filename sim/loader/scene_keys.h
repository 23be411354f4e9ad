// The scene language as a list: every table and key that the loader reads, with the loader's own type, range and
// default, and a sentence for each. Reference pages, the manual page and the JSON schema are generated from this list.
// A test compares it with the keys that the loader requests: a key without a sentence, or a sentence without a key,
// fails.
// Thread: [setup].
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/loader/scene_load.h"

namespace tactus::sim {

struct SceneKey {
  text::AskedKey asked;
  std::string only_with;  // the shapes or kinds that have the key, separated by commas: "box"; empty: all have it
  std::string meaning;    // one sentence, with the unit if the key's name has none; empty: missing
  std::string fallback;   // the default in words if it depends on other keys; else asked.fallback
};

struct SceneTable {
  std::string name;     // "[[body]]"; empty: the file's own keys
  std::string purpose;  // a sentence
  std::vector<SceneKey> keys;
};

// Two keys of a table that exclude each other; `needed`: one of them is required.
struct EitherKey {
  std::string_view table, only_with, key, other;
  bool needed;
};
std::span<const EitherKey> either_keys() noexcept;

// In the order of the documentation.
std::vector<SceneTable> scene_language();

// "table key" of each sentence without a key.
std::vector<std::string> superfluous_meanings();

std::string type_of(const text::AskedKey& key);  // "number", "whole number", "one of", ...
std::string unit_of(const text::AskedKey& key);  // from the suffix of its name: "N/m"; empty: none
std::string values_of(
    const text::AskedKey& key);  // what is accepted: "0 to 1000", "box, sphere"; empty: anything of the type

}  // namespace tactus::sim
