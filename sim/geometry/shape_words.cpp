#include "sim/geometry/shape_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tactus::sim {
namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

}  // namespace

std::string_view Words::next(bool same_line) {
  while (!rest_.empty() && is_space(rest_.front())) {
    if (rest_.front() == '\n') {
      if (same_line) return {};
      ++line_;
    }
    rest_.remove_prefix(1);
  }
  const auto end = std::find_if(rest_.begin(), rest_.end(), is_space);
  const std::string_view word(rest_.begin(), end);
  rest_.remove_prefix(word.size());
  return word;
}

void Words::skip_line() {
  const std::size_t end = rest_.find('\n');
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end);
}

bool parse_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

std::string shown(std::string_view word) {
  if (word.empty()) return "nothing";
  std::string text(word.substr(0, 40));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return "\"" + text + "\"";
}

std::string read_place(Words& words, Vec3d& place) {
  for (int i = 0; i < 3; ++i) {
    const std::string_view word = words.next(true);
    if (!parse_number(word, place[i])) return fmt::format("{} in {} is not a finite number", shown(word), "xyz"[i]);
  }
  return {};
}

}  // namespace tactus::sim
