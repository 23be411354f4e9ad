// Where figures come from: what a page and a plot say beside them. Thread: any normal one. Bound: none.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tactus {

// As /proc/cpuinfo names it; "unknown" where it does not.
std::string cpu_model();

struct Provenance {
  std::string date_utc;  // "2026-01-31 23:59 UTC"
  std::string version;   // tools/version/version.h
  std::string built_for;
  std::string machine;  // CPU, the cores that are on line, kernel
  std::string command;  // what a person types to get the same
};

// A word of such a command as a shell reads it: in quotes where it needs them.
std::string shell_word(const std::string& word);

// Of this moment, on this machine.
Provenance provenance(const std::string& command);

nlohmann::ordered_json to_json(const Provenance& of);

}  // namespace tactus
