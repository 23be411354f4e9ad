// Reads words and numbers of a text shape file, with their line. Internal to the readers of shape files.
// Thread: [setup].
#pragma once

#include <string>
#include <string_view>

#include "rt/base/spatial.h"

namespace tactus::sim {

// The words of a text, one after the other, and the line of the last one.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  // Empty at the end of the text; with `same_line`, also at the end of the line.
  std::string_view next(bool same_line);
  void skip_line();
  std::size_t line() const { return line_; }

 private:
  std::string_view rest_;
  std::size_t line_{1};
};

bool parse_number(std::string_view word, double& value);

// A word in a form for messages: short, printable, in quotes; "nothing" if it is empty.
std::string shown(std::string_view word);

// Reads three numbers on the line. Returns an error's text, or empty.
std::string read_place(Words& words, Vec3d& place);

}  // namespace tactus::sim
