// The scene language as a list: every table and key that the loader reads, with type, range and default as the loader
// itself asks for them, and a sentence for each. Reference pages, the manual page and the JSON schema are written from
// this list, and a test compares it with what the loader asks: a key without a sentence, or a sentence without a key,
// fails. Thread: [setup].
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/loader/scene_load.h"

namespace tactus::sim {

struct SceneKey {
  AskedKey asked;
  std::string only_with;  // "box": the shape or kind, of several with commas, that has the key; empty: all have it
  std::string meaning;    // one sentence, with the unit where the key has none in its name; empty: nobody wrote it
  std::string fallback;   // the default in words, where it depends on others; else asked.fallback
};

struct SceneTable {
  std::string name;     // "[[body]]"; empty: the file's own keys
  std::string purpose;  // a sentence
  std::vector<SceneKey> keys;
};

// Two keys of a table of which the loader takes one; `needed`: and not neither.
struct EitherKey {
  std::string_view table, only_with, key, other;
  bool needed;
};
std::span<const EitherKey> either_keys() noexcept;

// In the order of the documentation.
std::vector<SceneTable> scene_language();

// "table key" of each sentence that no key has.
std::vector<std::string> superfluous_meanings();

std::string type_of(const AskedKey& key);  // "number", "whole number", "one of", ...
std::string unit_of(const AskedKey& key);  // from the end of its name: "N/m"; empty: none
std::string values_of(
    const AskedKey& key);  // what is accepted: "0 to 1000", "box, sphere"; empty: anything of the type

}  // namespace tactus::sim
