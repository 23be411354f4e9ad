#include "sim/loader/motion_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "rt/base/rotation_vector.h"
#include "sim/geometry/shape_words.h"
#include "sim/loader/scene_load.h"

namespace tactus::sim {
namespace {

constexpr std::size_t kMaxBytes = 16u << 20;
constexpr std::string_view kColumns[] = {"time_s",     "position_x_m", "position_y_m", "position_z_m",
                                         "rotation_w", "rotation_x",   "rotation_y",   "rotation_z"};
constexpr std::size_t kWithoutRotation = 4, kWithRotation = 8;
constexpr double kUnitTolerance = 1e-3;  // accepts unit quaternions written with four digits

std::string header(std::size_t columns) {
  return fmt::format("{}", fmt::join(std::begin(kColumns), std::begin(kColumns) + columns, ","));
}

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

// The lines of a text, without an empty last one.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = trimmed(rest_.substr(0, end));
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }
  bool only_blanks_follow() const { return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

 private:
  std::string_view rest_;
  std::size_t number_{0};
};

// Checks the first line. Returns an error's text, or empty and sets `columns`, the number of values in a row.
std::string judge_header(std::string_view line, std::size_t& columns) {
  const auto names = fields_of(line);
  const std::string accepted = fmt::format("accepted: {}, or without rotation_w to rotation_z", header(kWithRotation));
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i >= kWithRotation) return fmt::format("column {} is {}; {}", i + 1, shown(names[i]), accepted);
    if (names[i] != kColumns[i])
      return fmt::format("column {} is {}, not {}; {}", i + 1, shown(names[i]), kColumns[i], accepted);
  }
  if (names.size() != kWithoutRotation && names.size() != kWithRotation)
    return fmt::format("{} columns; {}", names.size(), accepted);
  columns = names.size();
  return {};
}

std::string read_row(std::string_view line, std::size_t columns, MotionRow& row) {
  const auto fields = fields_of(line);
  if (fields.size() != columns)
    return fmt::format("{} columns; accepted: {}, as the first line names them", line.empty() ? 0 : fields.size(),
                       columns);
  row = {0, 0, 0, 0, 1, 0, 0, 0};
  for (std::size_t i = 0; i < columns; ++i)
    if (!parse_number(fields[i], row[i]))
      return fmt::format("{} in {} is not a finite number; accepted: numbers such as 0.25", shown(fields[i]),
                         kColumns[i]);
  return {};
}

}  // namespace

std::string judge_motion_row(const MotionRow* before, const MotionRow& row) {
  for (std::size_t i = 1; i < kWithoutRotation; ++i)
    if (std::abs(row[i]) > kFarthestMotion_m)
      return fmt::format("{} is {:g}; accepted: at most {:g} m from 0", kColumns[i], row[i], kFarthestMotion_m);
  const Quatd rotation = rotation_of(row);
  const double length = std::sqrt(rotation.w * rotation.w + dot(rotation.vec(), rotation.vec()));
  if (!(std::abs(length - 1) <= kUnitTolerance))
    return fmt::format("the rotation is a quaternion of length {:.6g}; accepted: length 1, w first", length);
  if (before == nullptr) return {};
  if (!(row[0] > (*before)[0]))
    return fmt::format("time {:.9g} s is not after {:.9g} s, the one before; accepted: ascending times", row[0],
                       (*before)[0]);
  if (row[0] > kMaxMotion_s)
    return fmt::format("is {:g} s after the first; accepted: at most {:g} s", row[0], kMaxMotion_s);
  const Quatd turn = normalized(rotation) * conjugate(normalized(rotation_of(*before)));
  if (const double angle = norm(rotation_vector_of(turn)); angle > kMaxTurnBetweenRows_rad)
    return fmt::format("turns by {:.3g} rad from the row before; accepted: at most {:g} rad between two rows", angle,
                       kMaxTurnBetweenRows_rad);
  return {};
}

MotionFile parse_motion(std::string_view text, std::string_view name) {
  MotionFile motion;
  Lines lines(text);
  const auto mistake = [&](const std::string& what) {
    motion.mistakes.push_back(fmt::format("{}:{}: {}", name, std::max<std::size_t>(lines.number(), 1), what));
  };
  std::string_view line;
  std::size_t columns = 0;
  if (!lines.next(line)) line = {};
  if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // UTF-8 byte order mark of spreadsheets
  if (const std::string wrong = judge_header(line, columns); !wrong.empty()) {
    mistake(wrong);
    return motion;  // the columns are unknown
  }
  double first_s = 0;
  bool has_before = false;
  while (motion.mistakes.size() < text::kMaxReportedMistakes && !lines.only_blanks_follow() && lines.next(line)) {
    if (motion.rows.size() == kMaxMotionRows) {
      mistake(fmt::format("is a row too many; accepted: at most {} rows: leave some out", kMaxMotionRows));
      return motion;
    }
    MotionRow row;
    if (const std::string wrong = read_row(line, columns, row); !wrong.empty()) {
      mistake(wrong);
      continue;
    }
    if (!has_before) first_s = row[0];
    row[0] -= first_s;
    if (const std::string wrong = judge_motion_row(has_before ? &motion.rows.back() : nullptr, row); !wrong.empty()) {
      mistake(wrong);
      continue;
    }
    has_before = true;
    motion.rows.push_back(row);
  }
  if (motion.mistakes.empty() && motion.rows.size() < 2)
    mistake(fmt::format("{} rows make no motion; accepted: two or more", motion.rows.size()));
  return motion;
}

Result<MotionFile> read_motion_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return Status::error(fmt::format("{}: {}; accepted: a path from the scene file's folder", name,
                                     std::filesystem::exists(path, error) ? "is no file" : "there is no such file"));
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMaxBytes)
    return Status::error(fmt::format("{}: is too large; accepted: at most {} rows", name, kMaxMotionRows));
  std::string text(static_cast<std::size_t>(size), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size())))
    return Status::error(fmt::format("{}: cannot be read; accepted: a file that you may read", name));
  return parse_motion(text, name);
}

}  // namespace tactus::sim
