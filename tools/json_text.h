// The only way from a JSON value to text. Bytes that are no UTF-8, such as those of a file's name, become U+FFFD, where
// nlohmann::json::dump would throw; a number that is not finite becomes null. Thread: any normal one. Bound: the value.
// Errors: none but a lack of memory.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tactus {

// indent: spaces a level; below 0: all on one line.
template <class Json>
std::string json_text(const Json& value, int indent = -1) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tactus
