#include "rt/text/diagnostics.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/text/without_control.h"

namespace tactus::text {
namespace {

void sort_list(std::vector<Mistake>& list) {
  std::stable_sort(list.begin(), list.end(), [](const Mistake& a, const Mistake& b) {
    return std::pair(a.line, a.column) < std::pair(b.line, b.column);
  });
}

std::string lines_of(const std::string& name, std::vector<Mistake> list, const char* label) {
  sort_list(list);
  std::string text;
  for (const Mistake& m : list) {
    const std::string place = m.line == 0 ? "" : fmt::format(":{}:{}", m.line, m.column);
    const std::string line =
        fmt::format("{}{}: {}{}: {}; accepted: {}", name, place, label, m.where, m.what, m.accepted);
    text += (text.empty() ? "" : "\n") + without_control(line);  // each message is one line
  }
  return text;
}

}  // namespace

void Diagnostics::add(Mistake mistake) {
  if (full())
    ++left_out;
  else
    mistakes.push_back(std::move(mistake));
}

std::string Diagnostics::message() const {
  std::string text = lines_of(name, mistakes, "");
  if (left_out > 0) text += fmt::format("\n{}: and {} more", name, left_out);
  return text;
}

std::string Diagnostics::warning_message() const { return lines_of(name, warnings, "warning: "); }

void Diagnostics::sort_by_place() {
  sort_list(mistakes);
  sort_list(warnings);
}

}  // namespace tactus::text
