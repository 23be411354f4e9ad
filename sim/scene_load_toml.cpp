#include "sim/scene_load_toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

// The one file that sees the TOML library. Compiled in, not linked, because the limit on nesting is a constant of its
// build: the default of 256, times the dots that a key may have, would be deep enough to overflow the stack.
// Its assertions fail on texts that people write ("[" before a line break), and a release build takes them for granted,
// which is undefined behaviour: here they are exceptions, in every build, that refuse the text.
namespace {
struct TomlAssertion {};
[[noreturn]] void refuse_text() { throw TomlAssertion{}; }
}  // namespace
#define TOML_ASSERT(...) ((__VA_ARGS__) ? void(0) : refuse_text())
#undef NDEBUG
#undef TOML_HEADER_ONLY
#undef TOML_SHARED_LIB
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#define TOML_MAX_NESTED_VALUES 16
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
// Its tables of Unicode call letters outside them "unreachable" (an accent right after a number): the answer is no.
#include <toml++/impl/preprocessor.h>
#undef TOML_UNREACHABLE
#define TOML_UNREACHABLE return false
#include <toml++/impl/unicode.h>
#undef TOML_UNREACHABLE
#define TOML_UNREACHABLE __builtin_unreachable()
#include <toml++/toml.h>
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

namespace tactus::sim {
namespace {

constexpr std::size_t kMaxDotsPerLine = 500;  // each may open a table: a key cannot span lines
constexpr std::size_t kMaxValues = 1'000'000;
constexpr unsigned kMaxDepth = 24;  // a scene needs 5

// The library frees and builds tables by recursion and does not limit how many a dotted key opens.
bool too_many_dots(std::string_view text, SceneDiagnostics& diagnostics) {
  unsigned line = 1;
  std::size_t dots = 0;
  for (const char c : text) {
    if (c == '\n') ++line, dots = 0;
    if (c == '.' && ++dots > kMaxDotsPerLine) {
      diagnostics.add({line, 1, "the file", fmt::format("the line has more than {} dots", kMaxDotsPerLine),
                       "shorter lines: break long arrays"});
      return true;
    }
  }
  return false;
}

// Does the library's parser fail an assertion of its own on this text?
bool breaks_parser(std::string_view text) {
  try {
    (void)toml::parse(text);
    return false;
  } catch (const TomlAssertion&) { return true; }
}

// The line that breaks it: the parser goes from left to right, so the first lines break it from that line on.
unsigned breaking_line(std::string_view text) {
  std::vector<std::size_t> ends;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') ends.push_back(i + 1);
  const auto breaks = [text](std::size_t end) { return breaks_parser(text.substr(0, end)); };
  const auto first = std::partition_point(ends.begin(), ends.end(), [&](std::size_t end) { return !breaks(end); });
  return static_cast<unsigned>(first - ends.begin()) + 1;
}

// Nothing, and one mistake, where the text is no TOML.
std::optional<toml::table> parse_text(std::string_view text, SceneDiagnostics& diagnostics) {
  try {
    toml::parse_result parsed = toml::parse(text);
    if (parsed) return std::move(parsed).table();
    const auto& at = parsed.error().source().begin;
    diagnostics.add({at.line, at.column, "the file", std::string(parsed.error().description()), "TOML 1.0"});
  } catch (const TomlAssertion&) {
    diagnostics.add({breaking_line(text), 1, "the file", "a key or a bracket that is not complete", "TOML 1.0"});
  }
  return std::nullopt;
}

class Converter {
 public:
  explicit Converter(SceneDiagnostics& diagnostics) : diagnostics_(diagnostics) {}

  bool convert(const toml::node& from, TomlNode& to, unsigned depth) {
    to.line = from.source().begin.line, to.column = from.source().begin.column;
    if (++values_ > kMaxValues) return refuse(to, fmt::format("more than {} values", kMaxValues));
    if (depth > kMaxDepth) return refuse(to, fmt::format("tables and arrays more than {} deep", kMaxDepth));
    switch (from.type()) {
      case toml::node_type::boolean:
        to.kind = TomlKind::kBoolean, to.boolean = from.as_boolean()->get();
        return true;
      case toml::node_type::integer:
        to.kind = TomlKind::kInteger, to.integer = from.as_integer()->get();
        to.number = static_cast<double>(to.integer);
        return true;
      case toml::node_type::floating_point:
        to.kind = TomlKind::kNumber, to.number = from.as_floating_point()->get();
        return true;
      case toml::node_type::string:
        to.kind = TomlKind::kText, to.text = from.as_string()->get();
        return true;
      case toml::node_type::array:
        return convert_array(*from.as_array(), to, depth);
      case toml::node_type::table:
        return convert_table(*from.as_table(), to, depth);
      default:
        to.kind = TomlKind::kDate;
        return true;
    }
  }

 private:
  bool convert_array(const toml::array& from, TomlNode& to, unsigned depth) {
    to.kind = TomlKind::kArray;
    to.items.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i)
      if (!convert(from[i], to.items[i], depth + 1)) return false;
    return true;
  }

  bool convert_table(const toml::table& from, TomlNode& to, unsigned depth) {
    to.kind = TomlKind::kTable;
    to.items.resize(from.size());
    std::size_t i = 0;
    for (auto&& [key, value] : from) {
      TomlNode& item = to.items[i++];
      item.key = std::string(key.str());
      item.key_line = key.source().begin.line, item.key_column = key.source().begin.column;
      if (!convert(value, item, depth + 1)) return false;
    }
    return true;
  }

  bool refuse(const TomlNode& at, std::string what) {
    diagnostics_.add({at.line, at.column, "the file", std::move(what), "a smaller scene"});
    return false;
  }

  SceneDiagnostics& diagnostics_;
  std::size_t values_{0};
};

}  // namespace

const TomlNode* TomlNode::find(std::string_view key_sought) const noexcept {
  if (kind != TomlKind::kTable) return nullptr;
  for (const TomlNode& item : items)
    if (item.key == key_sought) return &item;
  return nullptr;
}

std::string TomlNode::shown() const {
  switch (kind) {
    case TomlKind::kBoolean:
      return boolean ? "true" : "false";
    case TomlKind::kInteger:
      return fmt::format("{}", integer);
    case TomlKind::kNumber:
      return fmt::format("{}", number);
    case TomlKind::kText:
      return text.size() <= 40 ? fmt::format("\"{}\"", text) : fmt::format("\"{:.37}...\"", text);
    case TomlKind::kArray:
      return fmt::format("an array of {}", items.size());
    case TomlKind::kTable:
      return "a table";
    case TomlKind::kDate:
      return "a date or time";
  }
  return {};
}

bool read_toml(std::string_view text, TomlNode& root, SceneDiagnostics& diagnostics) {
  if (text.size() > kMaxSceneBytes) {
    diagnostics.add(
        {0, 0, "the file", fmt::format("{} bytes", text.size()), fmt::format("at most {} bytes", kMaxSceneBytes)});
    return false;
  }
  if (too_many_dots(text, diagnostics)) return false;
  const auto table = parse_text(text, diagnostics);
  return table && Converter(diagnostics).convert(*table, root, 0);
}

}  // namespace tactus::sim
