// What a command prints with --json: one object, which begins with the program's version. Thread: any normal one.
// Bound: the object. Errors: none but a lack of memory.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/json_text.h"
#include "tools/version/version.h"

namespace tactus {

template <class Json>
std::string report_text(const Json& object, int indent = -1) {
  nlohmann::ordered_json report{{"version", version()}};
  for (const auto& [key, value] : object.items()) report[key] = value;
  return json_text(report, indent);
}

}  // namespace tactus
