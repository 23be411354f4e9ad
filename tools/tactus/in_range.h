// Check of a number on the command line. A value out of its range is refused in the words of the configuration files:
// "--rate: 50 is out of range; accepted: 100 to 10000 Hz". Ends are included. Thread: [setup].
#pragma once

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <string>

#include "tools/session/run_options.h"

namespace tactus::tools {

// `unit`: follows the range in the message. What is not a number is left to CLI11, which knows the option's type.
template <class T>
CLI::Validator in_range(T least, T most, const char* unit = "") {
  const auto mistake_of = [=](const std::string& text) -> std::string {
    T value{};
    if (!CLI::detail::lexical_cast(text, value) || (value >= least && value <= most)) return {};
    return fmt::format("{} is out of range; accepted: {} to {}{}{}", text, least, most, *unit == '\0' ? "" : " ", unit);
  };
  return {mistake_of, fmt::format("in [{} - {}]", least, most)};
}

template <class T>
CLI::Validator in_range(const session::Range<T>& range, const char* unit = "") {
  return in_range(range.least, range.most, unit);
}

}  // namespace tactus::tools
