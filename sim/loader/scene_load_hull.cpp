#include "sim/loader/scene_load_hull.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/physics/shapes/hull_mass.h"
#include "sim/geometry/hull_gap.h"
#include "sim/geometry/mesh_files.h"
#include "sim/geometry/shape_files.h"
#include "sim/loader/scene_load_files.h"

namespace tactus::sim {
namespace {

// Reads positions. If an entry is not one: false, and one mistake.
bool read_points(std::span<const text::TomlNode> nodes, const std::string& where, text::Diagnostics& diagnostics,
                 std::vector<Vec3d>& points) {
  const auto is_coordinate = [](const text::TomlNode& n) {
    return (n.kind == text::TomlKind::kNumber || n.kind == text::TomlKind::kInteger) && std::isfinite(n.number);
  };
  for (const text::TomlNode& node : nodes) {
    if (node.kind != text::TomlKind::kArray || node.items.size() != 3 ||
        !std::all_of(node.items.begin(), node.items.end(), is_coordinate)) {
      diagnostics.add({.line = node.line,
                       .column = node.column,
                       .where = where,
                       .what = node.shown() + " is not a place",
                       .accepted = "[x, y, z], finite numbers"});
      return false;
    }
    points.push_back({node.items[0].number, node.items[1].number, node.items[2].number});
  }
  return true;
}

std::string table_of(const std::string& file, double unit_m, const std::vector<Vec3d>& vertices) {
  std::string text = fmt::format("\n[[hull_file]]\nname = {}\nfile_unit_m = {}\npoints_m = [\n", quoted(file), unit_m);
  for (const Vec3d& v : vertices) text += fmt::format("  [{}, {}, {}],\n", v.x, v.y, v.z);  // round-trips exactly
  return text + "]\n";
}

}  // namespace

void HullReader::read_kept(std::span<const text::TomlNode> tables) {
  unsigned number = 0;
  for (const text::TomlNode& node : tables) {
    text::TableReader t(&node, fmt::format("[hull_file.{}]", ++number), diagnostics_);
    if (!t.there()) continue;
    t.require("name", "the name of a file, as a body has it");
    t.require("points_m", "[[x, y, z], ...]: the corners of the hull");
    const FileKey key{t.text("name", "", kLongestFileName), t.number("file_unit_m", 1, kFileUnit)};
    std::vector<Vec3d> points;
    if (read_points(t.array("points_m", kMaxHullPoints), t.name_of("points_m"), diagnostics_, points))
      given_[key] = std::move(points);
    t.finish();
  }
}

std::optional<HullOfBody> HullReader::read(text::TableReader& body) {
  if (body.has("file")) {
    body.refuse("points_m", "there is a file already", "points_m or file");
    return read_file(body);
  }
  body.refuse("file_unit_m", "there is no file", "no such key");
  if (!body.require("points_m", "points_m = [[x, y, z], ...], or file = \"name.obj\" or \"name.stl\""))
    return std::nullopt;
  const std::size_t mistakes = diagnostics_.mistakes.size() + diagnostics_.left_out;
  const auto nodes = body.array("points_m", kMaxHullPoints);
  std::vector<Vec3d> points;
  if (!read_points(nodes, body.name_of("points_m"), diagnostics_, points)) return std::nullopt;
  if (diagnostics_.mistakes.size() + diagnostics_.left_out != mistakes) return std::nullopt;
  auto built = build(body, "points_m", points);
  if (!built) return std::nullopt;
  return add(*built);
}

std::optional<HullOfBody> HullReader::read_file(text::TableReader& body) {
  const FileKey key{body.text("file", "", kLongestFileName), body.number("file_unit_m", 1, kFileUnit)};
  if (key.first.empty()) {
    body.mistake("file", "is no name of a file", "a name that ends in .obj or .stl");
    return std::nullopt;
  }
  if (const auto known = of_file_.find(key); known != of_file_.end()) return known->second;
  std::vector<Vec3d> points;
  const auto given = given_.find(key);
  if (given != given_.end()) {
    points = given->second;
  } else if (!folder_) {
    body.mistake("file", "only a scene that is a file itself may name one", "points_m");
    return std::nullopt;
  } else {
    auto corners = read_shape_file(*folder_ / key.first);
    if (!corners.ok()) {
      const auto [what, accepted] = halves_of(corners.message());
      body.mistake("file", what, accepted);
      return std::nullopt;
    }
    for (const Vec3d& corner : corners.value()) points.push_back(corner * key.second);
  }
  auto built = build(body, "file", points);
  if (!built) return std::nullopt;
  if (given == given_.end()) kept_ += table_of(key.first, key.second, built->vertices);
  if (given == given_.end()) compare_with_mesh(body, *folder_ / key.first, key.second, *built);
  return of_file_[key] = add(*built);
}

// Warns if the hull fills concave or open regions of the file's surface: the user would feel a surface there that the
// file does not have. A file with corners only has no surface to compare with.
void HullReader::compare_with_mesh(text::TableReader& body, const std::filesystem::path& file, double unit_m,
                                   const BuiltHull& built) {
  auto soup = read_triangle_file(file);
  if (!soup.ok()) {
    if (soup.message().find("holds no triangles") != std::string::npos) return;
    const auto [what, accepted] = halves_of(soup.message());
    body.warning("file", fmt::format("its hull is not compared with its triangles: {}", what), accepted);
    return;
  }
  for (Vec3d& corner : soup.value().corners) corner = corner * unit_m;
  const auto gap = find_hull_gap(weld(soup.value()), built.hull, built.given_from_body);
  if (!gap.ok()) {
    const auto [what, accepted] = halves_of(gap.message());
    body.warning("file", fmt::format("its hull is not compared with its triangles: it {}", what), accepted);
    return;
  }
  const HullGap& found = gap.value();
  if (found.open_edges > 0)
    body.warning("file",
                 fmt::format("its surface is open: it ends at {} edges, and the hull closes it", found.open_edges),
                 "a closed surface");
  if (found.gap_m > kSmallestGap_m)
    body.warning("file",
                 fmt::format("is not convex: between its surface and its hull, which is what is felt, there are up to "
                             "{:.3g} mm, at [{:.4g}, {:.4g}, {:.4g}] m in its own frame",
                             1e3 * found.gap_m, found.at_m.x, found.at_m.y, found.at_m.z),
                 "a convex shape; what is hollow or branches is built from several bodies");
}

std::optional<BuiltHull> HullReader::build(text::TableReader& body, const char* key, std::span<const Vec3d> points) {
  if (scene_.hulls.size() >= kMaxSceneHulls) {
    body.mistake(key, fmt::format("is one hull more than {}", kMaxSceneHulls),
                 "fewer hulls, or bodies that share a file");
    return std::nullopt;
  }
  for (const Vec3d& p : points) {
    if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kFarthest_m) continue;
    body.mistake(key, fmt::format("has a point at [{:g}, {:g}, {:g}] m", p.x, p.y, p.z),
                 fmt::format("points within {:g} m: is file_unit_m right?", kFarthest_m));
    return std::nullopt;
  }
  auto built = build_hull(points);
  if (built.ok()) return std::move(built).value();
  const auto [what, accepted] = halves_of(built.message());
  body.mistake(key, what, accepted);
  return std::nullopt;
}

std::optional<HullOfBody> HullReader::with_mass(const HullOfBody& made, const Vec3d& centre,
                                                const SymMat3d& inertia_per_kg) {
  BuiltHull changed{scene_.hulls[made.index], made.given_from_body, {}};
  if (physics::set_mass_properties(centre, inertia_per_kg, changed.hull, changed.given_from_body) !=
      physics::HullFault::kNone)
    return std::nullopt;
  return add(changed);
}

HullOfBody HullReader::add(const BuiltHull& built) {
  scene_.hulls.push_back(built.hull);
  return {static_cast<std::uint32_t>(scene_.hulls.size() - 1), built.given_from_body};
}

}  // namespace tactus::sim
