// A recorded motion in a CSV file: where a hand was, and when.
//
//   time_s,position_x_m,position_y_m,position_z_m,rotation_w,rotation_x,rotation_y,rotation_z
//   0,0.1,0,0.2,1,0,0,0
// The first line has these names; without the four of the rotation, a unit quaternion (world_from_tool), nothing turns.
// Each further line is a row; times ascend, and count from the first. Units: SI. Frame: world. Thread: [setup]. Bound:
// kMaxMotionRows.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"

namespace tactus::sim {

// A tape carries them as text (4 MB at most with the rest of its scene).
inline constexpr std::size_t kMaxMotionRows = 20'000;
inline constexpr std::size_t kMotionRowWidth = 8;
inline constexpr double kMaxMotion_s = 3600, kFarthestMotion_m = 1e4;
inline constexpr double kMostTurnBetweenRows_rad = 1.5;  // beyond, the way of the turn is a guess

// Time, position, rotation (w, x, y, z), as in the file but for the time, which begins at 0.
using MotionRow = std::array<double, kMotionRowWidth>;

struct MotionFile {
  std::vector<MotionRow> rows;
  std::vector<std::string> mistakes;  // one line each: "motion.csv:12: what; accepted: what"; none: the rows are good
};

// An error where the file cannot be read at all. Row i is in line i + kFirstMotionLine.
Result<MotionFile> read_motion_file(const std::filesystem::path& path);
MotionFile parse_motion(std::string_view text, std::string_view name);

// What is wrong with a row after the one before it (null: it is the first), as "what; accepted: what"; empty: nothing.
std::string judge_motion_row(const MotionRow* before, const MotionRow& row);

}  // namespace tactus::sim
