#include "tools/device/registers_text.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

#include "hal/device_words.h"
#include "rt/text/nearest_word.h"

namespace tactus::device {
namespace {

using firmware::Register;
using firmware::RegisterType;

template <class N>
bool whole_number(std::string_view text, N& number) {
  const bool hexadecimal = text.starts_with("0x");
  if (hexadecimal) text.remove_prefix(2);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, hexadecimal ? 16 : 10);
  return error == std::errc() && end == text.data() + text.size();
}

Result<RegisterName> find_by_number(const std::string& text) {
  std::uint32_t number = 0;
  const bool read = whole_number(text, number) && number <= std::numeric_limits<std::uint16_t>::max();
  const Register* row = read ? firmware::find_register(static_cast<std::uint16_t>(number)) : nullptr;
  if (row == nullptr)
    return Status::error(fmt::format("{}: no such register; accepted: a name or number of firmware/PROTOCOL.md", text));
  return RegisterName{row, number - row->number, 1};
}

bool is_bits(const Register& row) noexcept {
  return row.number < firmware::number::kQuantum || std::string_view(row.unit) == "bits";
}

}  // namespace

Result<RegisterName> find_by_name(const std::string& text) {
  if (text.starts_with("0x")) return find_by_number(text);
  const std::size_t bracket = std::min(text.find('['), text.size());
  const std::string_view name = std::string_view(text).substr(0, bracket);
  std::vector<std::string_view> names;
  const Register* row = nullptr;
  for (const Register& each : firmware::all_registers()) {
    names.emplace_back(each.name);
    if (name == each.name) row = &each;
  }
  if (row == nullptr) {
    const auto nearest = text::nearest_word(name, names);
    return Status::error(fmt::format("{}: no such register{}; accepted: a name or number of firmware/PROTOCOL.md", name,
                                     nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest)));
  }
  if (bracket == text.size()) return RegisterName{row, 0, row->count};
  unsigned index = 0;
  const bool closed =
      text.back() == ']' && whole_number(std::string_view(text).substr(bracket + 1, text.size() - bracket - 2), index);
  if (!closed || index >= row->count)
    return Status::error(fmt::format("{}: accepted: {}[0] to {}[{}]", text, name, name, row->count - 1));
  return RegisterName{row, index, 1};
}

std::string name_of(const Register& row, unsigned index) {
  return row.count == 1 ? row.name : fmt::format("{}[{}]", row.name, index);
}

std::string value_text(const Register& row, std::uint32_t bits) {
  if (row.type == RegisterType::kF32) return fmt::format("{:g}", std::bit_cast<float>(bits));
  if (row.type == RegisterType::kI32) return fmt::format("{}", std::bit_cast<std::int32_t>(bits));
  return is_bits(row) ? fmt::format("{:#010x}", bits) : fmt::format("{}", bits);
}

Result<std::uint32_t> parse_value(const Register& row, const std::string& text) {
  std::uint32_t bits = 0;
  bool read = false;
  if (row.type == RegisterType::kF32) {
    float number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    read = error == std::errc() && end == text.data() + text.size();
    bits = std::bit_cast<std::uint32_t>(number);
  } else if (row.type == RegisterType::kI32) {
    std::int32_t number = 0;
    read = whole_number(text, number);
    bits = std::bit_cast<std::uint32_t>(number);
  } else {
    read = whole_number(text, bits);
  }
  if (read && firmware::is_in_range(row, bits)) return bits;
  const std::string unit = row.unit[0] == 0 ? "" : fmt::format(" {}", row.unit);
  return Status::error(fmt::format("{}: {} is {}; accepted: {} to {}{}", row.name, text,
                                   read ? "out of range" : "no number of its type", value_text(row, row.low),
                                   value_text(row, row.high), unit));
}

std::string fault_entry_text(const std::uint32_t (&words)[firmware::kFaultLogWords]) {
  const std::uint32_t fault = words[0] & 0xffffu, axis = words[0] >> 24;
  if (fault == 0) return {};
  const auto state = static_cast<haptics::DeviceState>(words[0] >> 16 & 0xffu);
  const double time_s = 1e-6 * static_cast<double>(std::uint64_t{words[2]} << 32 | words[1]);
  std::string text = fmt::format("{:.6f} s, in {}: {}", time_s, hal::name_of(state), hal::describe_device_fault(fault));
  constexpr std::uint32_t kNoAxis = 255;
  if (axis != kNoAxis) text += fmt::format("; axis {}", axis);
  const float value = std::bit_cast<float>(words[3]);
  if (value != 0 && std::isfinite(value)) text += fmt::format("; {:g}", value);
  return text;
}

}  // namespace tactus::device
