#include "rt/text/table_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/text/nearest_word.h"

namespace tactus::text {
namespace {

// Up to so many keys are listed in a message that also suggests one.
constexpr std::size_t kFewKeys = 10;

std::string accepted(const Range& range) { return fmt::format("a number >= {:g} and <= {:g}", range.low, range.high); }

bool is_number(const TomlNode& node) { return node.kind == TomlKind::kNumber || node.kind == TomlKind::kInteger; }

// True also for NaN.
bool outside(double value, const Range& range) { return !(value >= range.low && value <= range.high); }

// Number of characters of a UTF-8 text.
std::size_t characters_in(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }));
}

std::string list_of(std::span<const std::string_view> words) {
  std::string list;
  for (const auto word : words) list += fmt::format("{}{}", list.empty() ? "" : ", ", word);
  return list;
}

// The table's name in the scene language: "[[body]] path" for "[body.3] path.2".
std::string table_name(std::string where) {
  const auto dot = where.find('.'), end = where.find(']');
  const bool of_array = dot != std::string::npos && end != std::string::npos && dot < end;
  if (of_array) where = "[" + where.substr(0, dot) + "]" + where.substr(end);
  const auto number = where.find('.');
  return number == std::string::npos ? where : where.substr(0, number);
}

std::string as_written(const Vec3d& v) { return fmt::format("[{:g}, {:g}, {:g}]", v.x, v.y, v.z); }
std::string in_quotes(const std::string& text) { return text.empty() ? text : fmt::format("\"{}\"", text); }

}  // namespace

TableReader::TableReader(const TomlNode* table, std::string where, Diagnostics& diagnostics)
    : table_(table), where_(std::move(where)), diagnostics_(diagnostics) {
  if (table_ != nullptr && table_->kind != TomlKind::kTable) {
    diagnostics_.add({.line = table_->line,
                      .column = table_->column,
                      .where = where_,
                      .what = table_->shown() + " is not a table",
                      .accepted = "a table"});
    table_ = nullptr;
  }
}

const TomlNode* TableReader::find(const char* key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  return table_ == nullptr ? nullptr : table_->find(key);
}

void TableReader::note(const char* key, AskedKey question) {
  auto& asked = *diagnostics_.asked;
  question.table = table_name(where_);
  question.key = key;
  const auto same = [&](const AskedKey& a) { return a.table == question.table && a.key == question.key; };
  const auto found = std::find_if(asked.begin(), asked.end(), same);
  if (found == asked.end()) return asked.push_back(std::move(question));
  question.required |= found->required;
  if (found->type == AskedKey::Type::kUnknown)
    *found = std::move(question);
  else
    found->required = question.required;
}

bool TableReader::has(std::string_view key) { return table_ != nullptr && table_->find(key) != nullptr; }

Mistake TableReader::at(const char* key, std::string what, std::string accepted_text) {
  const TomlNode* node = table_ == nullptr ? nullptr : table_->find(key);
  if (node == nullptr) node = table_;
  return {.line = node == nullptr ? 0 : node->line,
          .column = node == nullptr ? 0 : node->column,
          .where = name_of(key),
          .what = std::move(what),
          .accepted = std::move(accepted_text)};
}

std::string TableReader::name_of(std::string_view key) const {
  return where_.empty() ? std::string(key) : fmt::format("{} {}", where_, key);
}

std::string TableReader::table_name_of(std::string_view key) const {
  std::string name = table_name(where_);
  std::erase_if(name, [](char c) { return c == '[' || c == ']'; });
  std::replace(name.begin(), name.end(), ' ', '.');
  return name.empty() ? std::string(key) : fmt::format("{}.{}", name, key);
}

void TableReader::mistake(const char* key, std::string what, std::string accepted_text) {
  diagnostics_.add(at(key, std::move(what), std::move(accepted_text)));
}

void TableReader::warning(const char* key, std::string what, std::string accepted_text) {
  diagnostics_.warnings.push_back(at(key, std::move(what), std::move(accepted_text)));
}

bool TableReader::require(const char* key, const char* accepted_text) {
  if (is_asked_about()) note(key, {.required = true});
  if (find(key) != nullptr) return true;
  if (table_ != nullptr) mistake(key, "missing", accepted_text);
  return false;
}

void TableReader::refuse(const char* key, std::string what, std::string accepted_text) {
  const std::size_t known = known_.size();
  if (find(key) != nullptr)
    mistake(key, std::move(what), std::move(accepted_text));
  else
    known_.resize(known);  // no key that is accepted
}

double TableReader::number(const char* key, double fallback, const Range& range) {
  if (is_asked_about())
    note(key, {.type = AskedKey::Type::kNumber,
               .fallback = fmt::format("{:g}", fallback),
               .low = range.low,
               .high = range.high});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  if (is_number(*node) && !outside(node->number, range)) return node->number;
  mistake(key, fmt::format("{} is not {}", node->shown(), range.noun), accepted(range));
  return fallback;
}

unsigned TableReader::count(const char* key, unsigned fallback, const Range& range) {
  if (is_asked_about())
    note(key, {.type = AskedKey::Type::kCount,
               .fallback = fmt::format("{}", fallback),
               .low = range.low,
               .high = range.high});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  if (node->kind == TomlKind::kInteger && !outside(node->number, range)) return static_cast<unsigned>(node->integer);
  const bool whole = node->kind == TomlKind::kNumber && !outside(node->number, range) &&
                     node->number == static_cast<double>(static_cast<long long>(node->number));
  mistake(key,
          whole ? fmt::format("{:.0f} is written with a decimal point", node->number)
                : fmt::format("{} is not {}", node->shown(), range.noun),
          fmt::format("a whole number from {:.0f} to {:.0f}{}", range.low, range.high,
                      whole ? fmt::format(", such as {:.0f}", node->number) : ""));
  return fallback;
}

std::uint64_t TableReader::seed(const char* key, std::uint64_t fallback) {
  if (is_asked_about()) note(key, {.type = AskedKey::Type::kSeed, .fallback = fmt::format("{}", fallback)});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  if (node->kind == TomlKind::kInteger && node->integer >= 0) return static_cast<std::uint64_t>(node->integer);
  mistake(key, node->shown() + " is not a seed", "a whole number >= 0");
  return fallback;
}

bool TableReader::flag(const char* key, bool fallback) {
  if (is_asked_about()) note(key, {.type = AskedKey::Type::kFlag, .fallback = fallback ? "true" : "false"});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  if (node->kind == TomlKind::kBoolean) return node->boolean;
  mistake(key, node->shown() + " is neither true nor false", "true, false");
  return fallback;
}

std::string TableReader::text(const char* key, std::string fallback, std::size_t longest) {
  if (is_asked_about())
    note(key, {.type = AskedKey::Type::kText, .fallback = in_quotes(fallback), .high = static_cast<double>(longest)});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  const bool one_line = std::none_of(node->text.begin(), node->text.end(), is_control);
  if (node->kind == TomlKind::kText && characters_in(node->text) <= longest && one_line) return node->text;
  mistake(key,
          node->kind == TomlKind::kText ? "the text is too long or has line breaks" : node->shown() + " is not text",
          fmt::format("one line of at most {} characters in quotes", longest));
  return fallback;
}

std::string TableReader::word(const char* key, std::string fallback, std::span<const std::string_view> words) {
  if (is_asked_about())
    note(key, {.type = AskedKey::Type::kWord, .fallback = in_quotes(fallback), .words = {words.begin(), words.end()}});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  if (node->kind == TomlKind::kText && std::find(words.begin(), words.end(), node->text) != words.end())
    return node->text;
  const auto nearest = node->kind == TomlKind::kText ? nearest_word(node->text, words) : std::string_view{};
  mistake(key,
          fmt::format("{} is not known{}", node->shown(),
                      nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest)),
          list_of(words));
  return fallback;
}

std::string TableReader::required_word(const char* key, std::span<const std::string_view> words) {
  if (!require(key, list_of(words).c_str())) return {};
  return word(key, "", words);
}

Vec3d TableReader::vector(const char* key, const Vec3d& fallback, const Range& range) {
  if (is_asked_about())
    note(key,
         {.type = AskedKey::Type::kVector, .fallback = as_written(fallback), .low = range.low, .high = range.high});
  const TomlNode* node = find(key);
  if (node == nullptr) return fallback;
  const std::string wanted = fmt::format("[x, y, z], each {}", accepted(range));
  if (node->kind != TomlKind::kArray || node->items.size() != 3) {
    mistake(key, fmt::format("{} is not {}", node->shown(), range.noun), wanted);
    return fallback;
  }
  Vec3d value;
  for (int i = 0; i < 3; ++i) {
    const TomlNode& item = node->items[static_cast<std::size_t>(i)];
    if (!is_number(item) || outside(item.number, range)) {
      mistake(key, fmt::format("{} in {} is not {}", item.shown(), "xyz"[i], range.noun), wanted);
      return fallback;
    }
    value[i] = item.number;
  }
  return value;
}

Posed TableReader::pose() {
  const Vec3d position = vector("position_m", {}, {"a place", -1e4, 1e4});
  const Vec3d rotation = vector("rotation_vector_rad", {}, {"a rotation", -10, 10});
  return {position, quat_from_rotation_vector(rotation)};
}

const TomlNode* TableReader::table(const char* key) {
  if (is_asked_about()) note(key, {.type = AskedKey::Type::kTable});
  const TomlNode* node = find(key);
  if (node == nullptr || node->kind == TomlKind::kTable) return node;
  mistake(key, node->shown() + " is not a table", fmt::format("a table: [{}]", key));
  return nullptr;
}

std::span<const TomlNode> TableReader::tables(const char* key, std::size_t most) {
  if (is_asked_about()) note(key, {.type = AskedKey::Type::kTable});
  const TomlNode* node = find(key);
  if (node == nullptr) return {};
  if (node->kind == TomlKind::kTable) return {node, 1};
  if (node->kind == TomlKind::kArray && !node->items.empty() && node->items.size() <= most) return node->items;
  mistake(key,
          node->kind == TomlKind::kArray ? fmt::format("{} entries", node->items.size())
                                         : node->shown() + " is not a table",
          fmt::format("a table: [{0}], or 1 to {1} of them: [[{0}]]", key, most));
  return {};
}

std::span<const TomlNode> TableReader::array(const char* key, std::size_t longest) {
  if (is_asked_about()) note(key, {.type = AskedKey::Type::kArray, .high = static_cast<double>(longest)});
  const TomlNode* node = find(key);
  if (node == nullptr) return {};
  if (node->kind == TomlKind::kArray && node->items.size() <= longest) return node->items;
  mistake(key,
          node->kind == TomlKind::kArray ? fmt::format("{} entries", node->items.size())
                                         : node->shown() + " is not an array",
          node->kind == TomlKind::kTable ? fmt::format("[[{}]] for each, at most {}", table_name_of(key), longest)
                                         : fmt::format("an array of at most {}", longest));
  return {};
}

void TableReader::finish() {
  if (table_ == nullptr || !judged_) return;
  std::sort(known_.begin(), known_.end());
  for (const TomlNode& item : table_->items) {
    if (std::find(known_.begin(), known_.end(), item.key) != known_.end()) continue;
    if (diagnostics_.full()) {
      ++diagnostics_.left_out;  // skips the search for the nearest word
      continue;
    }
    const auto nearest = nearest_word(item.key, known_);
    const std::string key = item.key.size() <= 60 ? item.key : item.key.substr(0, 57) + "...";
    const bool long_list = !nearest.empty() && known_.size() > kFewKeys;
    diagnostics_.add(
        {.line = item.key_line,
         .column = item.key_column,
         .where = where_.empty() ? key : fmt::format("{} {}", where_, key),
         .what = nearest.empty() ? "not a key" : fmt::format("not a key, did you mean {}?", nearest),
         .accepted = long_list ? fmt::format("{} and {} others", nearest, known_.size() - 1) : list_of(known_)});
  }
}

}  // namespace tactus::text
