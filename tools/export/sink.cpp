#include "tools/export/sink.h"

#include <array>
#include <charconv>
#include <cmath>

namespace tactus::exporting {

std::string_view name_of(MemberRole role) noexcept {
  switch (role) {
    case MemberRole::kProxy:
      return "proxy";
    case MemberRole::kMember:
      return "member";
    case MemberRole::kBorder:
      return "border";
  }
  return "";
}

// The shortest text that reads as the same number.
void append_number(std::string& text, double number, bool for_json) {
  if (!std::isfinite(number)) {
    text += for_json ? "null" : std::isnan(number) ? "nan" : number < 0 ? "-inf" : "inf";
    return;
  }
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text.append(digits.data(), end.ptr);
  if (for_json && number == 0 && std::signbit(number))
    text += ".0";  // "-0" is an integer to some readers, without sign
}

void append_number(std::string& text, std::uint64_t number) {
  std::array<char, 24> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text.append(digits.data(), end.ptr);
}

void append_value(std::string& text, const Column& column, const Value& value, bool for_json) {
  if (column.is_real())
    append_number(text, value.real, for_json);
  else
    append_number(text, value.count);
}

}  // namespace tactus::exporting
