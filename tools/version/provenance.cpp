#include "tools/version/provenance.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "rt/tape/tape.h"
#include "rt/thread/realtime_setup.h"
#include "tools/version/version.h"

namespace tactus {

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const auto colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
  return "unknown";
}

std::string shell_word(const std::string& word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:,+=@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

Provenance provenance(const std::string& command) {
  utsname kernel{};
  uname(&kernel);
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return {.date_utc = fmt::format("{:%Y-%m-%d %H:%M} UTC", utc),
          .version = version(),
          .built_for = std::string(loop::tape_isa_tag()),
          .machine = fmt::format("{}, {} cores, {} {}{}", cpu_model(), sysconf(_SC_NPROCESSORS_ONLN), kernel.sysname,
                                 kernel.release, loop::kernel_is_preempt_rt() ? ", PREEMPT_RT" : ""),
          .command = command};
}

nlohmann::ordered_json to_json(const Provenance& of) {
  return {{"date_utc", of.date_utc},
          {"version", of.version},
          {"built_for", of.built_for},
          {"machine", of.machine},
          {"command", of.command}};
}

}  // namespace tactus
