#include "hal/fault_injection.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

namespace tactus::hal {
namespace {

enum class Amount { kNone, kOptional, kRequired };

struct KindRule {
  std::string_view word;
  FaultKind kind;
  bool may_choose_direction;
  FaultDirection usual_direction;
  Amount amount;
  double usual_amount, least, most;
  bool whole;
};

constexpr FaultDirection kState = FaultDirection::kState, kBoth = FaultDirection::kBoth;
// In the order of the fields.
constexpr KindRule kRules[] = {
    {"lost", FaultKind::kLost, true, kBoth, Amount::kNone, 0, 0, 0, false},
    {"late", FaultKind::kLate, true, kBoth, Amount::kRequired, 0, 1, kMaxLateTicks, true},
    {"duplicated", FaultKind::kDuplicated, true, kBoth, Amount::kNone, 0, 0, 0, false},
    {"corrupted", FaultKind::kCorrupted, true, kBoth, Amount::kOptional, 1, 1, 5, true},
    {"nan", FaultKind::kNan, true, kState, Amount::kNone, 0, 0, 0, false},
    {"wild", FaultKind::kWild, false, kState, Amount::kNone, 0, 0, 0, false},
    {"teleport", FaultKind::kTeleport, false, kState, Amount::kRequired, 0, -10, 10, false},
    {"frozen", FaultKind::kFrozen, false, kBoth, Amount::kNone, 0, 0, 0, false},
    {"unplugged", FaultKind::kUnplugged, false, kBoth, Amount::kNone, 0, 0, 0, false},
    {"estop", FaultKind::kEmergencyStop, false, kBoth, Amount::kNone, 0, 0, 0, false},
};

constexpr std::uint64_t kMaxTick = 1ull << 40;

std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// Removes and returns the text before the first of `marks`; `rest` then begins with that mark.
std::string_view take_until(std::string_view& rest, std::string_view marks) noexcept {
  const std::size_t end = std::min(rest.find_first_of(marks), rest.size());
  const std::string_view taken = rest.substr(0, end);
  rest.remove_prefix(end);
  return taken;
}

bool skip(std::string_view& rest, char mark) noexcept {
  if (rest.empty() || rest.front() != mark) return false;
  rest.remove_prefix(1);
  return true;
}

template <class Number>
bool read_whole(std::string_view text, Number& value) noexcept {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

std::string plain(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

const KindRule* find_rule(std::string_view word) noexcept {
  for (const KindRule& rule : kRules)
    if (rule.word == word) return &rule;
  return nullptr;
}

Status complain(std::string_view fault, const std::string& why) {
  return Status::error("fault \"" + std::string(fault) + "\": " + why);
}

Status read_amount(std::string_view whole, std::string_view rest, bool given, const KindRule& rule, double& amount) {
  const std::string word(rule.word);
  amount = rule.usual_amount;
  if (!given && rule.amount == Amount::kRequired)
    return complain(whole,
                    word + " needs an amount after ':', for example " + word + "@1000:" + (rule.whole ? "2" : "0.1"));
  if (!given) return Status::good();
  if (rule.amount == Amount::kNone) return complain(whole, word + " takes no amount, leave out ':' and what follows");
  const bool readable = read_whole(rest, amount) && std::isfinite(amount);
  if (!readable || amount < rule.least || amount > rule.most || (rule.whole && amount != std::floor(amount)))
    return complain(whole, std::string("the amount after ':' must be a ") + (rule.whole ? "whole " : "") +
                               "number from " + plain(rule.least) + " to " + plain(rule.most) +
                               (rule.kind == FaultKind::kTeleport ? " (metres)" : ""));
  return Status::good();
}

Result<InjectedFault> parse_fault(std::string_view whole) {
  std::string_view rest = whole;
  InjectedFault fault;
  const std::string_view word = take_until(rest, "/@+:");
  const KindRule* rule = find_rule(word);
  if (rule == nullptr) {
    std::string known;
    for (const KindRule& r : kRules) known += (known.empty() ? "" : ", ") + std::string(r.word);
    return complain(whole, "unknown kind \"" + std::string(word) + "\"; accepted of the device: " + known);
  }
  fault.kind = rule->kind;
  fault.direction = rule->usual_direction;

  if (skip(rest, '/')) {
    const std::string_view direction = take_until(rest, "@+:");
    if (!rule->may_choose_direction)
      return complain(whole, std::string(word) + " has no direction, leave out '/' and what follows it");
    if (direction != "state" && direction != "command")
      return complain(whole, "the direction after '/' must be state or command");
    fault.direction = direction == "state" ? FaultDirection::kState : FaultDirection::kCommand;
  }
  if (!skip(rest, '@')) return complain(whole, "the tick is missing, for example " + std::string(word) + "@1000");
  if (!read_whole(take_until(rest, "+:"), fault.tick) || fault.tick > kMaxTick)
    return complain(whole, "the tick after '@' must be a whole number from 0");
  if (skip(rest, '+') && (!read_whole(take_until(rest, ":"), fault.ticks) || fault.ticks < 1 || fault.ticks > kMaxTick))
    return complain(whole, "the number of ticks after '+' must be a whole number from 1");
  const bool amount_given = skip(rest, ':');
  if (const Status status = read_amount(whole, rest, amount_given, *rule, fault.amount); !status.ok()) return status;
  return fault;
}

}  // namespace

const InjectedFault* FaultScript::active(FaultKind kind, FaultDirection direction, std::uint64_t tick) const noexcept {
  for (std::uint32_t i = 0; i < count; ++i) {
    const InjectedFault& f = faults[i];
    const bool same_way = (static_cast<unsigned>(f.direction) & static_cast<unsigned>(direction)) != 0;
    if (f.kind == kind && same_way && tick >= f.tick && tick - f.tick < f.ticks) return &f;
  }
  return nullptr;
}

Result<FaultScript> parse_fault_script(std::string_view text) {
  FaultScript script;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    const std::string_view one = trimmed(take_until(rest, ","));
    const bool more = skip(rest, ',');
    if (one.empty() || (more && trimmed(rest).empty()))
      return Status::error("fault list: a fault is missing beside a comma");
    if (script.count == kMaxFaults)
      return Status::error("fault list: more than " + std::to_string(kMaxFaults) + " faults");
    Result<InjectedFault> fault = parse_fault(one);
    if (!fault.ok()) return fault.status();
    script.faults[script.count++] = fault.value();
  }
  return script;
}

}  // namespace tactus::hal
