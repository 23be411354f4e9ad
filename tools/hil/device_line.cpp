#include "tools/hil/device_line.h"

#include <fmt/format.h>

#include <sstream>
#include <vector>

#include "rt/text/toml.h"

namespace tactus::hil {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

// The line without its leading and trailing blanks.
std::string trimmed(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : line.substr(first, last - first + 1);
}

// "[device]", with a comment behind it too.
bool opens_device(const std::string& line) {
  const std::size_t end = line.find(']');
  return end != std::string::npos && line[0] == '[' && trimmed(line.substr(1, end - 1)) == "device";
}

bool sets_name(const std::string& line) {
  const std::size_t equals = line.find('=');
  return equals != std::string::npos && trimmed(line.substr(0, equals)) == "name";
}

bool names(const std::string& text, const std::string& name) {
  text::TomlNode root;
  text::Diagnostics diagnostics;
  if (!text::read_toml(text, root, diagnostics)) return false;
  const text::TomlNode* const device = root.find("device");
  const text::TomlNode* const found = device != nullptr ? device->find("name") : nullptr;
  return found != nullptr && found->text == name;
}

}  // namespace

Result<std::string> with_device_name(const std::string& text, const std::string& name, const std::string& note) {
  text::TomlNode root;
  text::Diagnostics diagnostics;
  if (!text::read_toml(text, root, diagnostics)) return Status::error("it is no TOML: " + diagnostics.message());
  const std::string lines = fmt::format("{}\nname = {}\n", note, quoted(name));
  std::string result;
  bool in_device = false, written = false;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::string bare = trimmed(line);
    if (!bare.empty() && bare[0] == '[') in_device = opens_device(bare);
    if (in_device && (bare.starts_with(kMeasuredNote) || sets_name(bare))) continue;  // written below its table's name
    result += line + "\n";
    if (!in_device || written || !opens_device(bare)) continue;
    result += lines;
    written = true;
  }
  if (!written) result += fmt::format("{}[device]\n{}", result.empty() ? "" : "\n", lines);
  if (names(result, name)) return result;
  return Status::error(
      fmt::format("its device is written in another form; put name = {} there yourself", quoted(name)));
}

}  // namespace tactus::hil
