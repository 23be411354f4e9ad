// The JSON library's classes, compiled once for all of tools, in json_templates.cpp: in each file that prints a report
// they would take as long to compile as the rest of the file. Thread: none; declarations only.
#pragma once

#include <nlohmann/json.hpp>

extern template class nlohmann::basic_json<>;
extern template class nlohmann::basic_json<nlohmann::ordered_map>;
extern template class nlohmann::detail::serializer<nlohmann::json>;
extern template class nlohmann::detail::serializer<nlohmann::ordered_json>;
