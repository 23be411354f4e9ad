#include "hal/gpio/gpio_options.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <utility>

namespace tactus::hal {
namespace {

constexpr std::string_view kAccepted = "accepted: chip=NAME with any of estop=, enable=, probe=, heartbeat=N[-low]";
constexpr std::string_view kLow = "-low";

Status refused(std::string_view part, std::string_view why) {
  return Status::error(fmt::format("--gpio: '{}' {}; {}", part, why, kAccepted));
}

std::optional<GpioLine> parse_line(std::string_view text) {
  GpioLine line;
  if (text.ends_with(kLow)) {
    line.active_low = true;
    text.remove_suffix(kLow.size());
  }
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, line.offset);
  if (error != std::errc() || stopped != end || line.offset > kMaxGpioOffset) return std::nullopt;
  return line;
}

}  // namespace

Result<GpioOptions> parse_gpio_options(std::string_view text) {
  GpioOptions options;
  const std::array<std::pair<std::string_view, std::optional<GpioLine>*>, 4> lines{{{"estop", &options.estop},
                                                                                    {"enable", &options.enable},
                                                                                    {"probe", &options.probe},
                                                                                    {"heartbeat", &options.heartbeat}}};
  std::string_view rest = text;
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    more = comma != std::string_view::npos;
    const std::string_view part = rest.substr(0, comma);
    if (more) rest.remove_prefix(comma + 1);
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) return refused(part, "names nothing");
    const std::string_view key = part.substr(0, equals), value = part.substr(equals + 1);
    if (key == "chip") {
      if (value.empty() || !options.chip.empty()) return refused(part, "is empty or comes twice");
      options.chip = value;
      continue;
    }
    std::optional<GpioLine>* target = nullptr;
    for (const auto& [name, line] : lines)
      if (key == name) target = line;
    if (target == nullptr) return refused(part, "is not known");
    if (target->has_value()) return refused(part, "comes twice");
    *target = parse_line(value);
    if (!target->has_value()) return refused(part, fmt::format("is no offset from 0 to {}", kMaxGpioOffset));
  }

  if (options.chip.empty()) return refused(text, "names no chip");
  bool any = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& line = *lines[i].second;
    any = any || line.has_value();
    for (std::size_t j = 0; j < i && line; ++j)
      if (*lines[j].second && (*lines[j].second)->offset == line->offset)
        return refused(text,
                       fmt::format("uses line {} for both {} and {}", line->offset, lines[j].first, lines[i].first));
  }
  if (!any) return refused(text, "names no line");
  return options;
}

}  // namespace tactus::hal
