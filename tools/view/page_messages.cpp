#include "tools/view/page_messages.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace tactus::view {
namespace {

constexpr std::array<std::string_view, 5> kAsks{"disarm", "stop", "reset", "arm", "rearm"};

}  // namespace

Result<PageMessage> parse_message(std::string_view text) {
  const auto bad = [](const char* what) {
    return Status::error(
        std::string(what) +
        R"(; accepted: {"ack": N}, {"ask": "disarm"} or stop, reset, arm, rearm, of at most 256 bytes)");
  };
  if (text.size() > kLongestMessage) return bad("the message is too long");
  const auto object = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object() || object.size() != 1) return bad("the message is no object of one key");
  PageMessage message;
  if (const auto ack = object.find("ack"); ack != object.end()) {
    if (!ack->is_number_unsigned() || *ack == 0u || *ack > 0xffffffffu) return bad("'ack' is no number of a message");
    message.acknowledged = ack->get<std::uint32_t>();
    return message;
  }
  const auto ask = object.find("ask");
  if (ask == object.end() || !ask->is_string()) return bad("the message is unknown");
  message.ask = ask->get<std::string>();
  if (std::find(kAsks.begin(), kAsks.end(), message.ask) == kAsks.end()) return bad("the request is unknown");
  return message;
}

bool gives_force(std::string_view ask) noexcept { return ask == "arm" || ask == "rearm" || ask == "reset"; }

}  // namespace tactus::view
