// A TOML document as plain values with their positions in the text; hides the TOML library from the rest of the
// program.
//
// Thread: [setup]. Bound: the text's size, nesting and number of values are limited before and while it is read, so
// that no text can exhaust the stack or the memory; beyond the limits the result is a mistake instead of a document.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rt/text/diagnostics.h"

namespace tactus::text {

inline constexpr std::size_t kMaxTomlBytes = 4u << 20;  // of any file of the program

enum class TomlKind { kBoolean, kInteger, kNumber, kText, kArray, kTable, kDate };

struct TomlNode {
  TomlKind kind{TomlKind::kTable};
  unsigned line{0}, column{0};
  bool boolean{false};
  std::int64_t integer{0};
  double number{0};  // also set for an integer
  std::string text;
  std::vector<TomlNode> items;  // of an array, in order; of a table, by key
  std::string key;              // of an entry of a table
  unsigned key_line{0}, key_column{0};

  const TomlNode* find(std::string_view key_sought) const noexcept;  // entry of a table; null if absent
  // For messages: the value in TOML syntax, or its kind if that is too long.
  std::string shown() const;
};

// Fills `root` and returns true, or adds one mistake and returns false.
bool read_toml(std::string_view text, TomlNode& root, Diagnostics& diagnostics);

}  // namespace tactus::text
