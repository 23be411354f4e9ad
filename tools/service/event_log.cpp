#include "tools/service/event_log.h"

#include <fmt/format.h>

#include <cstdlib>

namespace tactus::service {
namespace {

std::string quoted(const std::string& value) {
  if (!value.empty() && value.find_first_of(" \t\n\"=") == std::string::npos) return value;
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') text += '\\';
    text += c == '\n' ? ' ' : c;
  }
  return text + "\"";
}

}  // namespace

void EventLog::event(LogLevel level, const std::string& name, Fields fields, double now_s) {
  const auto [place, first] = seen_.try_emplace(name, Seen{now_s, 0});
  Seen& seen = place->second;
  if (!first && now_s - seen.last_s < interval_s_) {
    ++seen.suppressed;
    return;
  }
  std::string line = with_level_ ? fmt::format("<{}>{}", static_cast<int>(level), name) : name;
  if (hand_ > 0) line += fmt::format(" hand={}", hand_);
  for (const auto& [key, value] : fields) line += fmt::format(" {}={}", key, quoted(value));
  if (seen.suppressed > 0) line += fmt::format(" suppressed={}", seen.suppressed);
  seen = {now_s, 0};
  std::fputs((line + "\n").c_str(), out_);
  std::fflush(out_);
}

bool EventLog::to_journal() { return std::getenv("JOURNAL_STREAM") != nullptr; }

}  // namespace tactus::service
