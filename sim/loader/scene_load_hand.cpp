#include "sim/loader/scene_load_hand.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/base/rotation_vector.h"
#include "sim/loader/scene_load_files.h"
#include "sim/loader/scene_load_ranges.h"

namespace tactus::sim {
namespace {

std::string table_of(const std::string& file, const std::vector<MotionRow>& rows) {
  std::string text = fmt::format("\n[[motion_file]]\nname = {}\nrows = [\n", quoted(file));
  for (const MotionRow& row : rows) text += fmt::format("  {},\n", fmt::join(row, ", "));  // round-trips exactly
  return text + "]\n";
}

Quatd unit_rotation_of(const MotionRow& row) { return normalized(rotation_of(row)); }

// Mean velocities between two rows, m/s and rad/s.
struct Leg {
  double time_s;
  Vec3d velocity, angular_velocity;

  static Leg between(const MotionRow& a, const MotionRow& b) {
    const double time_s = b[0] - a[0];
    const Vec3d move = Vec3d{b[1], b[2], b[3]} - Vec3d{a[1], a[2], a[3]};
    return {time_s, move * (1 / time_s),
            rotation_vector_of(unit_rotation_of(b) * conjugate(unit_rotation_of(a))) * (1 / time_s)};
  }
};

// Velocity at a row between two legs, limited to three times each leg's mean speed. A faster cubic overshoots the leg's
// ends (Fritsch and Carlson, 1980): between a pause and a quick move, by most of the move.
Vec3d velocity_between(const Vec3d& to, const Vec3d& from, double share_of_to) {
  const Vec3d parabola = share_of_to * to + (1 - share_of_to) * from;
  const double most = 3 * std::min(norm(to), norm(from)), speed = norm(parabola);
  return speed > most ? parabola * (most / speed) : parabola;
}

}  // namespace

void HandReader::read_kept(std::span<const text::TomlNode> tables) {
  unsigned number = 0;
  for (const text::TomlNode& node : tables) {
    text::TableReader t(&node, fmt::format("[motion_file.{}]", ++number), diagnostics_);
    if (!t.there()) continue;
    t.require("name", "the name of a file, as [hand] has it");
    t.require("rows", "[time, x, y, z, w, x, y, z, time, ...]: rows of eight numbers");
    const std::string name = t.text("name", "", kLongestFileName);
    const auto numbers = t.array("rows", kMotionRowWidth * kMaxMotionRows);
    t.finish();
    std::vector<MotionRow> rows(numbers.size() / kMotionRowWidth);
    std::string wrong;
    if (rows.size() < 2 || numbers.size() % kMotionRowWidth != 0)
      wrong = fmt::format("{} numbers make no motion; accepted: two rows or more, of eight numbers", numbers.size());
    for (std::size_t i = 0; i < rows.size() && wrong.empty(); ++i) {
      for (std::size_t k = 0; k < kMotionRowWidth; ++k) {
        const text::TomlNode& n = numbers[kMotionRowWidth * i + k];
        const bool good =
            (n.kind == text::TomlKind::kNumber || n.kind == text::TomlKind::kInteger) && std::isfinite(n.number);
        if (!good) wrong = fmt::format("{} is not a number; accepted: finite numbers", n.shown());
        rows[i][k] = n.number;
      }
      if (wrong.empty()) wrong = judge_motion_row(i > 0 ? &rows[i - 1] : nullptr, rows[i]);
    }
    if (!wrong.empty()) {
      const auto [what, accepted] = halves_of(wrong);
      t.mistake("rows", what, accepted);
      continue;
    }
    given_[name] = std::move(rows);
  }
}

void HandReader::read(text::TableReader hand, HandScript& script, BodyId proxy) {
  script_ = &script;
  const bool recorded = hand.has("file");
  script.repeat = hand.flag("repeat", !recorded);  // a recording seldom ends at its start
  script.stiffness_N_per_m = hand.number("stiffness_N_per_m", script.stiffness_N_per_m, kStiffness);
  script.damping_Ns_per_m = hand.number("damping_Ns_per_m", script.damping_Ns_per_m, kDamping);
  script.stiffness_Nm_per_rad = hand.number("stiffness_Nm_per_rad", script.stiffness_Nm_per_rad, kStiffness);
  script.damping_Nms_per_rad = hand.number("damping_Nms_per_rad", script.damping_Nms_per_rad, kDamping);
  script.mass_kg = hand.number("mass_kg", script.mass_kg, {"a mass of a hand", 0, 10});
  if (recorded) {
    hand.refuse("path", "there is a file already", "path or file");
    const std::string word = hand.word("interpolation", "cubic", {"cubic", "linear"});
    script.motion = word == "linear" ? haptics::HandMotion::kLinear : haptics::HandMotion::kCubic;
    read_file(hand);
  } else {
    hand.refuse("interpolation", "there is no file; between the way points of a path the motion is a smooth step",
                "no such key");
    (void)hand.text("file", "", kLongestFileName);  // absent, but accepted
    unsigned number = 0;
    for (const text::TomlNode& node : hand.array("path", kMaxWaypoints)) read_waypoint(node, ++number);
  }
  check_path(hand, recorded ? "file" : "path", proxy);
  hand.finish();
}

void HandReader::read_waypoint(const text::TomlNode& node, unsigned number) {
  text::TableReader t(&node, fmt::format("[hand] path.{}", number), diagnostics_);
  if (!t.there()) return;
  ScriptWaypoint point;
  t.require("time_s", "a number");
  point.time_s = t.number("time_s", 0, {"a time", 0, 3600});
  point.position_m = t.vector("position_m", {}, {"a place", -1e4, 1e4});
  t.require("position_m", "[x, y, z]");
  point.rotation_vector_rad = t.vector("rotation_vector_rad", {}, {"a rotation", -10, 10});
  auto& path = script_->path;
  if (path.empty() && point.time_s != 0) t.mistake("time_s", fmt::format("the path begins at {} s", point.time_s), "0");
  if (!path.empty() && point.time_s <= path.back().time_s)
    t.mistake("time_s", fmt::format("{} s is not after {} s", point.time_s, path.back().time_s), "ascending times");
  path.push_back(point);
  t.finish();
}

void HandReader::read_file(text::TableReader& hand) {
  const std::string name = hand.text("file", "", kLongestFileName);
  if (name.empty()) {
    hand.mistake("file", "is no name of a file", "a CSV file of a recorded motion");
    return;
  }
  std::vector<MotionRow> rows;
  if (const auto given = given_.find(name); given != given_.end())
    rows = given->second;
  else if (!open_file(hand, name, rows))
    return;
  script_->file = name;
  add_rows(rows);
}

bool HandReader::open_file(text::TableReader& hand, const std::string& name, std::vector<MotionRow>& rows) {
  if (!folder_) {
    hand.mistake("file", "only a scene that is a file itself may name one", "path");
    return false;
  }
  auto motion = read_motion_file(*folder_ / name);
  if (!motion.ok()) {
    const auto [what, accepted] = halves_of(motion.message());
    hand.mistake("file", what, accepted);
    return false;
  }
  for (const std::string& wrong : motion.value().mistakes) {
    const auto [what, accepted] = halves_of(wrong);
    hand.mistake("file", what, accepted);
  }
  if (!motion.value().mistakes.empty()) return false;
  rows = std::move(motion.value().rows);
  kept_ += table_of(name, rows);
  given_[name] = rows;  // another hand may follow the same motion
  return true;
}

void HandReader::add_rows(const std::vector<MotionRow>& rows) {
  auto& path = script_->path;
  for (const MotionRow& row : rows)
    path.push_back({row[0], {row[1], row[2], row[3]}, rotation_vector_of(unit_rotation_of(row))});
  if (script_->motion != haptics::HandMotion::kCubic) return;
  // The velocity at a row is that of the parabola through it and its neighbours, limited against overshoot. At the ends
  // it is 0, or, in a path that repeats, computed from the neighbours across the repeat.
  const std::size_t last = rows.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const bool inner = i > 0 && i < last;
    if (!inner && !script_->repeat) continue;
    const Leg to = inner ? Leg::between(rows[i - 1], rows[i]) : Leg::between(rows[last - 1], rows[last]);
    const Leg from = inner ? Leg::between(rows[i], rows[i + 1]) : Leg::between(rows[0], rows[1]);
    const double share = from.time_s / (to.time_s + from.time_s);
    path[i].velocity_m_per_s = velocity_between(to.velocity, from.velocity, share);
    path[i].angular_velocity_rad_per_s = velocity_between(to.angular_velocity, from.angular_velocity, share);
  }
}

void HandReader::check_path(text::TableReader& hand, const char* key, BodyId proxy) {
  auto& path = script_->path;
  if (proxy == kNoBody) return;
  const Vec3d start = scene_.bodies[proxy].motion.pose.position;
  if (path.empty()) {
    path.push_back({0, start, {}});  // without a path the hand rests at the proxy
    return;
  }
  const auto& first = path.front();
  const auto& last = path.back();
  if (script_->repeat && (first.position_m != last.position_m || first.rotation_vector_rad != last.rotation_vector_rad))
    hand.mistake(key, "repeats, and does not end where it begins", "a last pose like the first, or repeat = false");
  if (norm(first.position_m - start) > 1e-3)
    hand.warning(key, fmt::format("begins {:.3g} m from the proxy", norm(first.position_m - start)),
                 fmt::format("a first {} at the proxy's centre of mass, [{:.6g}, {:.6g}, {:.6g}]",
                             script_->file.empty() ? "way point" : "row", start.x, start.y, start.z));
}

}  // namespace tactus::sim
