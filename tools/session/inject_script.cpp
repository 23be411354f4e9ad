#include "tools/session/inject_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace tactus::session {
namespace {

constexpr std::uint64_t kMaxTicks = 1'000'000'000;

bool read_number(std::string_view& text, std::uint64_t& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || value > kMaxTicks) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool read_stall(std::string_view text, WorldStall& stall) {
  if (!read_number(text, stall.at_tick) || !text.starts_with('+')) return false;
  text.remove_prefix(1);
  return read_number(text, stall.ticks) && text.empty() && stall.ticks > 0;
}

}  // namespace

Result<InjectScript> split_inject_script(const std::string& script) {
  InjectScript result;
  for (std::string_view rest = script; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view item = rest.substr(0, comma);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
    if (item.starts_with("reset@")) {
      std::string_view text = item.substr(6);
      std::uint64_t tick = 0;
      if (!read_number(text, tick) || !text.empty())
        return Status::error(fmt::format("--inject: '{}' is no reset; accepted: reset@TICK", item));
      result.resets.push_back(tick);
      continue;
    }
    if (!item.starts_with("stall@")) {
      if (!result.device.empty()) result.device.push_back(',');
      result.device.append(item);
      continue;
    }
    WorldStall stall;
    if (!read_stall(item.substr(6), stall))
      return Status::error(fmt::format("--inject: '{}' is no stall; accepted: stall@TICK+TICKS", item));
    result.stalls.push_back(stall);
  }
  std::stable_sort(result.stalls.begin(), result.stalls.end(),
                   [](const WorldStall& a, const WorldStall& b) { return a.at_tick < b.at_tick; });
  std::sort(result.resets.begin(), result.resets.end());
  return result;
}

}  // namespace tactus::session
