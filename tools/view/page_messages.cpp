#include "tools/view/page_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

namespace tactus::view {
namespace {

constexpr std::array<std::string_view, 12> kAsks{"disarm", "stop", "reset", "arm",  "rearm", "play",
                                                 "pause",  "tick", "cycle", "back", "take",  "rest"};
constexpr double kFarthest = 10;  // m, and of a rotation vector rad
constexpr std::array<std::string_view, 2> kAsksWithValue{"seek", "pace"};
constexpr double kMinPace = 0.01, kMaxPace = 100, kMaxSeek_s = 1e7;

bool is_one_of(std::span<const std::string_view> words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool accepts(std::string_view ask, double value) noexcept {
  if (ask == "seek") return value >= 0 && value <= kMaxSeek_s;
  return value == 0 || (value >= kMinPace && value <= kMaxPace);
}

bool parse_hand(const nlohmann::json& list, std::array<double, 6>& hand) {
  if (!list.is_array() || list.size() != hand.size()) return false;
  for (std::size_t i = 0; i < hand.size(); ++i) {
    if (!list[i].is_number()) return false;
    hand[i] = list[i].get<double>();
    if (!(std::abs(hand[i]) <= kFarthest)) return false;
  }
  return true;
}

}  // namespace

Result<PageMessage> parse_message(std::string_view text) {
  const auto bad = [](const char* what) {
    return Status::error(
        std::string(what) +
        R"(; accepted: {"ack": N}, {"ask": "disarm"} or stop, reset, arm, rearm, play, pause, tick, cycle, back, take, )"
        R"(rest, {"hand": [x, y, z, rx, ry, rz]}, {"ask": "seek", "value": s}, {"ask": "pace", "value": 0 or 0.01 to 100}, of at most 256 bytes)");
  };
  if (text.size() > kLongestMessage) return bad("the message is too long");
  const auto object = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object() || object.empty() || object.size() > 2)
    return bad("the message is no object of a key or two");
  PageMessage message;
  if (const auto ack = object.find("ack"); ack != object.end()) {
    if (object.size() != 1 || !ack->is_number_unsigned() || *ack == 0u || *ack > 0xffffffffu)
      return bad("'ack' is no number of a message");
    message.acknowledged = ack->get<std::uint32_t>();
    return message;
  }
  if (const auto hand = object.find("hand"); hand != object.end()) {
    if (object.size() != 1 || !parse_hand(*hand, message.hand.emplace()))
      return bad("'hand' is no list of six numbers of up to 10");
    return message;
  }
  const auto ask = object.find("ask");
  if (ask == object.end() || !ask->is_string()) return bad("the message is unknown");
  message.ask = ask->get<std::string>();
  if (object.size() == 1) {
    if (!is_one_of(kAsks, message.ask)) return bad("the request is unknown");
    return message;
  }
  const auto value = object.find("value");
  if (!is_one_of(kAsksWithValue, message.ask) || value == object.end() || !value->is_number())
    return bad("the request is unknown");
  message.value = value->get<double>();
  if (!accepts(message.ask, message.value)) return bad("'value' is out of its range");
  return message;
}

bool gives_force(std::string_view ask) noexcept { return ask == "arm" || ask == "rearm" || ask == "reset"; }

}  // namespace tactus::view
