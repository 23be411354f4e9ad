// Reads a recorded hand motion from a CSV file.
//
//   time_s,position_x_m,position_y_m,position_z_m,rotation_w,rotation_x,rotation_y,rotation_z
//   0,0.1,0,0.2,1,0,0,0
// The first line has these names. The rotation is a unit quaternion (world_from_tool); without its four columns there
// is no rotation. Each further line is a row; times ascend and are relative to the first. Units: SI. Frame: world.
// Thread: [setup]. Bound: kMaxMotionRows.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/spatial.h"

namespace tactus::sim {

// A tape stores the rows as text (4 MB at most with the rest of its scene).
inline constexpr std::size_t kMaxMotionRows = 20'000;
inline constexpr std::size_t kMotionRowWidth = 8;
inline constexpr double kMaxMotion_s = 3600, kFarthestMotion_m = 1e4;
inline constexpr double kMaxTurnBetweenRows_rad = 1.5;  // beyond, the direction of rotation is ambiguous

// Time [s], position [m], rotation (w, x, y, z), as in the file; the time is shifted to start at 0.
using MotionRow = std::array<double, kMotionRowWidth>;
inline Quatd rotation_of(const MotionRow& row) noexcept { return {row[4], row[5], row[6], row[7]}; }

struct MotionFile {
  std::vector<MotionRow> rows;
  std::vector<std::string> mistakes;  // one line each: "motion.csv:12: what; accepted: what"; empty: the rows are valid
};

// An error only if the file cannot be read at all. Row i is in line i + kFirstMotionLine.
Result<MotionFile> read_motion_file(const std::filesystem::path& path);
MotionFile parse_motion(std::string_view text, std::string_view name);

// Checks a row that follows `before` (null: the first row). Returns "what; accepted: what", or empty if it is valid.
std::string judge_motion_row(const MotionRow* before, const MotionRow& row);

}  // namespace tactus::sim
