// Reads the keys of one TOML table, each with its range and default, and adds a mistake for each wrong value.
//
// A wrong value is replaced by the default, so that reading continues and all mistakes are found. Keys that were not
// requested are mistakes too, with the nearest known key as a suggestion.
// Thread: [setup].
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/spatial.h"
#include "rt/text/toml.h"

namespace tactus::text {

// The accepted range of a number, and its noun in messages: "-1 is not a mass".
struct Range {
  const char* noun;
  double low, high;
};

class TableReader {
 public:
  // `table` may be null: every key then returns its default, and none is required.
  TableReader(const TomlNode* table, std::string where, Diagnostics& diagnostics);

  bool there() const noexcept { return table_ != nullptr; }
  bool has(std::string_view key);

  double number(const char* key, double fallback, const Range& range);
  unsigned count(const char* key, unsigned fallback, const Range& range);
  std::uint64_t seed(const char* key, std::uint64_t fallback);
  bool flag(const char* key, bool fallback);
  std::string text(const char* key, std::string fallback, std::size_t longest);
  // One of `words`; the fallback if the value is wrong.
  std::string word(const char* key, std::string fallback, std::span<const std::string_view> words);
  std::string word(const char* key, std::string fallback, std::initializer_list<std::string_view> words) {
    return word(key, std::move(fallback), std::span(words.begin(), words.size()));
  }
  // The same for a required key; empty if it is missing or wrong.
  std::string required_word(const char* key, std::span<const std::string_view> words);
  Vec3d vector(const char* key, const Vec3d& fallback, const Range& range);  // each component in the range
  Posed pose();                                                              // position_m, rotation_vector_rad
  const TomlNode* table(const char* key);                                    // null where missing or wrong
  // [key] once, or [[key]] up to `most` times; empty where missing or wrong.
  std::span<const TomlNode> tables(const char* key, std::size_t most);
  std::span<const TomlNode> array(const char* key, std::size_t longest);

  // The key's name in a mistake: "[body.3] mass_kg".
  std::string name_of(std::string_view key) const;
  // Adds a mistake if the key is missing. Returns whether it is present.
  bool require(const char* key, const char* accepted);
  // Adds a mistake if the key is present.
  void refuse(const char* key, std::string what, std::string accepted);
  // Adds a mistake at the key's value, or at the table if the key is missing.
  void mistake(const char* key, std::string what, std::string accepted);
  void warning(const char* key, std::string what, std::string accepted);
  void finish();                                        // adds a mistake for each unknown key
  void ignore_the_rest() noexcept { judged_ = false; }  // disables finish(): the accepted keys are not known

 private:
  const TomlNode* find(const char* key);
  // Adds the requested key to Diagnostics::asked, or completes its entry. Only if is_asked_about().
  void note(const char* key, AskedKey question);
  bool is_asked_about() const noexcept { return diagnostics_.asked != nullptr; }
  // The header of a table in this one: "body.parts" for "parts" of "[body.3]".
  std::string table_name_of(std::string_view key) const;
  Mistake at(const char* key, std::string what, std::string accepted);

  const TomlNode* table_;
  std::string where_;
  Diagnostics& diagnostics_;
  std::vector<std::string_view> known_;
  bool judged_{true};
};

}  // namespace tactus::text
