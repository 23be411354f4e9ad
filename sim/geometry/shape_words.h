// Words and numbers of a shape file in text, with the line that they are in. Inside the readers of shape files.
// Thread: [setup].
#pragma once

#include <string>
#include <string_view>

#include "rt/base/spatial.h"

namespace tactus::sim {

// Words of a text, one after the other, and the line that the last one was in.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  // Empty at the end. `same_line`: also at the end of the line.
  std::string_view next(bool same_line);
  void skip_line();
  std::size_t line() const { return line_; }

 private:
  std::string_view rest_;
  std::size_t line_{1};
};

bool parse_number(std::string_view word, double& value);

// A word for a message: short, printable, in quotes; "nothing" for none.
std::string shown(std::string_view word);

// Three numbers on the line; an error's text otherwise.
std::string read_place(Words& words, Vec3d& place);

}  // namespace tactus::sim
