// Reads the keys of one TOML table: each with its range, its default and a sentence for what is wrong with it.
//
// A wrong value adds a mistake and reads as the default, so that reading goes on and all mistakes are found. Keys that
// nobody asked for are mistakes too, with the nearest known key as advice. Thread: [setup].
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/spatial.h"
#include "sim/loader/scene_load_toml.h"

namespace tactus::sim {

// What a number may be, and the word for it: "-1 is not a mass".
struct Range {
  const char* noun;
  double low, high;
};

class TableReader {
 public:
  // `table` may be null: every key then reads as its default, and nothing is required.
  TableReader(const TomlNode* table, std::string where, SceneDiagnostics& diagnostics);

  bool there() const noexcept { return table_ != nullptr; }
  bool has(std::string_view key);

  double number(const char* key, double fallback, const Range& range);
  unsigned count(const char* key, unsigned fallback, const Range& range);
  std::uint64_t seed(const char* key, std::uint64_t fallback);
  bool flag(const char* key, bool fallback);
  std::string text(const char* key, std::string fallback, std::size_t longest);
  // One word of a few; the first where it is wrong.
  std::string word(const char* key, std::string fallback, std::initializer_list<const char*> words);
  Vec3d vector(const char* key, const Vec3d& fallback, const Range& range);  // each component in the range
  Posed pose();                                                              // position_m, rotation_vector_rad
  const TomlNode* table(const char* key);                                    // null where missing or wrong
  std::span<const TomlNode> array(const char* key, std::size_t longest);

  // What a mistake calls the key: "[body.3] mass_kg".
  std::string name_of(std::string_view key) const;
  // A mistake where the key is missing. Returns whether it is there.
  bool require(const char* key, const char* accepted);
  // A mistake where the key is there.
  void refuse(const char* key, std::string what, std::string accepted);
  // A mistake at the key's value, or at the table where the key is missing.
  void mistake(const char* key, std::string what, std::string accepted);
  void warning(const char* key, std::string what, std::string accepted);
  void finish();                                        // unknown keys
  void ignore_the_rest() noexcept { judged_ = false; }  // finish() does nothing: which keys there may be is not known

 private:
  const TomlNode* find(const char* key);
  // Adds the question to SceneDiagnostics::asked, or completes it. Only where is_asked_about().
  void note(const char* key, AskedKey question);
  bool is_asked_about() const noexcept { return diagnostics_.asked != nullptr; }
  Mistake at(const char* key, std::string what, std::string accepted);

  const TomlNode* table_;
  std::string where_;
  SceneDiagnostics& diagnostics_;
  std::vector<std::string_view> known_;
  bool judged_{true};
};

}  // namespace tactus::sim
