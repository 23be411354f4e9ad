#include "firmware/boards/linux/mechanics_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

namespace tactus::firmware {
namespace {

// m or rad: quantum of an axis that is not described; the controller requires a positive one.
constexpr float kQuantumOfNoAxis = 1e-5f;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// Each of these functions sets its target, or returns what is accepted.
template <class Number>
std::string set_number(std::string_view text, double least, double most, Number& target) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = std::is_floating_point_v<Number> || number == std::floor(number);
  if (error != std::errc{} || end != text.data() + text.size() || !(number >= least && number <= most) || !whole) {
    char range[64];
    std::snprintf(range, sizeof range, "a %s from %g to %g", std::is_integral_v<Number> ? "whole number" : "number",
                  least, most);
    return range;
  }
  target = static_cast<Number>(number);
  return "";
}

std::string set_path(std::string_view text, std::string& target) {
  if (text.empty() || text.front() != '/') return "a path from /";
  target = text;
  return "";
}

std::string set_level(std::string_view text, char& target) {
  if (text != "0" && text != "1") return "0 or 1";
  target = text.front();
  return "";
}

constexpr double kSmall = 1e-9, kLarge = 1e6;

std::string set_axis(unsigned axis, std::string_view key, std::string_view value, MechanicsDescription& description,
                     bool& known) {
  AxisDescription& io = description.axes[axis];
  Config& control = description.control;
  if (key == "count") return set_path(value, io.count);
  if (key == "pwm") return set_path(value, io.pwm);
  if (key == "direction") return set_path(value, io.direction);
  if (key == "count_bits") return set_number(value, 8, 64, io.count_bits);
  if (key == "full_effort") return set_number(value, kSmall, kLarge, io.full_effort);
  if (key == "quantum") return set_number(value, kSmall, 1, control.quantum[axis]);
  if (key == "max_effort") return set_number(value, kSmall, kLarge, control.max_effort[axis]);
  if (key == "max_speed") return set_number(value, kSmall, kLarge, control.max_speed[axis]);
  known = false;
  return "";
}

std::string set_key(std::string_view key, std::string_view value, MechanicsDescription& description, bool& known) {
  MechanicsDescription& d = description;
  if (key.size() > 6 && key.starts_with("axis") && key[4] >= '0' && key[4] < '0' + static_cast<int>(kAxes) &&
      key[5] == '.')
    return set_axis(static_cast<unsigned>(key[4] - '0'), key.substr(6), value, d, known);
  if (key == "max_force_N") return set_number(value, 0, kLarge, d.control.max_force_N);
  if (key == "max_torque_Nm") return set_number(value, 0, kLarge, d.control.max_torque_Nm);
  if (key == "pwm_period_ns") return set_number(value, 1000, 10'000'000, d.pwm_period_ns);
  if (key == "stop_line") return set_path(value, d.stop_line.path);
  if (key == "stop_line_active") return set_level(value, d.stop_line.active);
  if (key == "motor_bus") return set_path(value, d.motor_bus.path);
  if (key == "motor_bus_good") return set_level(value, d.motor_bus.active);
  if (key == "brake_line") return set_path(value, d.brake_line.path);
  if (key == "brake_line_active") return set_level(value, d.brake_line.active);
  if (key == "device_class") {
    std::uint32_t number = 0;
    std::string accepted = set_number(value, 0, 65535, number);
    if (accepted.empty()) d.device_class = static_cast<MechanismClass>(number);
    return accepted;
  }
  known = false;
  return "";
}

// Checks the consistency of all lines together.
std::string check(const MechanicsDescription& description) {
  bool any = false;
  for (unsigned i = 0; i < kAxes; ++i) {
    const AxisDescription& axis = description.axes[i];
    const Config& control = description.control;
    const std::string name = "axis" + std::to_string(i);
    any = any || !axis.count.empty();
    if (!axis.count.empty() && !(control.quantum[i] > 0)) return name + ".quantum is missing: what is one count?";
    if (!axis.count.empty() && !(control.max_speed[i] > 0))
      return name + ".max_speed is missing: beyond it the device brakes";
    if (axis.pwm.empty() != (control.max_effort[i] == 0))
      return name + " needs pwm and max_effort together, or neither";
    if (!axis.pwm.empty() && !(axis.full_effort >= control.max_effort[i]))
      return name + ".full_effort: at full duty, at least max_effort";
    if (!axis.pwm.empty() && axis.direction.empty()) return name + ".direction is missing: the motor's second line";
  }
  return any ? "" : "no axis has a counter: give at least axis0.count";
}

}  // namespace

std::string parse_mechanics(std::string_view text, const std::string& name, MechanicsDescription& description) {
  description = {};
  std::set<std::string, std::less<>> seen;
  for (unsigned number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::string where = name + ":" + std::to_string(number) + ": ";
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) return where + "'" + std::string(line) + "'; accepted: key = value";
    const std::string_view key = trimmed(line.substr(0, equals)), value = trimmed(line.substr(equals + 1));
    if (!seen.emplace(key).second) return where + std::string(key) + " stands twice";
    bool known = true;
    const std::string accepted = set_key(key, value, description, known);
    if (!known)
      return where + "unknown key '" + std::string(key) + "'; firmware/boards/linux/example_mechanics.txt has them all";
    if (!accepted.empty()) return where + std::string(key) + " = '" + std::string(value) + "'; accepted: " + accepted;
  }
  if (std::string wrong = check(description); !wrong.empty()) return name + ": " + wrong;
  for (unsigned i = 0; i < kAxes; ++i) {
    if (!description.axes[i].count.empty()) continue;
    description.control.quantum[i] = kQuantumOfNoAxis;
    description.control.max_speed[i] = 1;
  }
  return "";
}

std::string read_mechanics(const std::string& path, MechanicsDescription& description) {
  std::ifstream file(path);
  file.peek();  // of a folder it fails here, where the iterators would throw
  if (file.bad() || !file.is_open()) return path + ": cannot be read";
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return parse_mechanics(text, path, description);
}

}  // namespace tactus::firmware
