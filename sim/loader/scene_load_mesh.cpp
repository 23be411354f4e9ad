#include "sim/loader/scene_load_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/loader/scene_load_files.h"

namespace tactus::sim {
namespace {

// Reads all numbers of an array; a mistake at the first entry that is not a number.
bool read_numbers(text::TableReader& table, const char* key, std::size_t longest, text::Diagnostics& diagnostics,
                  std::vector<double>& numbers) {
  for (const text::TomlNode& node : table.array(key, longest)) {
    const bool is_number = node.kind == text::TomlKind::kNumber || node.kind == text::TomlKind::kInteger;
    if (!is_number || !std::isfinite(node.number)) {
      diagnostics.add({.line = node.line,
                       .column = node.column,
                       .where = table.name_of(key),
                       .what = node.shown() + " is not a number",
                       .accepted = "finite numbers"});
      return false;
    }
    numbers.push_back(node.number);
  }
  return true;
}

std::string table_of(const std::string& file, double unit_m, const TriangleSoup& soup) {
  std::string text = fmt::format("\n[[mesh_file]]\nname = {}\nfile_unit_m = {}\ncorners_m = [\n", quoted(file), unit_m);
  for (const Vec3d& c : soup.corners) text += fmt::format("  {}, {}, {},\n", c.x, c.y, c.z);  // round-trips exactly
  text += "]\ntriangles = [\n";
  for (const auto& t : soup.triangles) text += fmt::format("  {}, {}, {},\n", t[0], t[1], t[2]);
  return text + "]\n";
}

}  // namespace

void MeshReader::read_kept(std::span<const text::TomlNode> tables) {
  unsigned number = 0;
  for (const text::TomlNode& node : tables) {
    text::TableReader t(&node, fmt::format("[mesh_file.{}]", ++number), diagnostics_);
    if (!t.there()) continue;
    t.require("name", "the name of a file, as a body has it");
    t.require("corners_m", "[x, y, z, x, ...]: the corners of the triangles");
    t.require("triangles", "[a, b, c, a, ...]: three corners each, from 0");
    const FileKey key{t.text("name", "", kLongestFileName), t.number("file_unit_m", 1, kFileUnit)};
    std::vector<double> places, corners;
    const bool good = read_numbers(t, "corners_m", 3 * kMaxMeshCorners, diagnostics_, places) &&
                      read_numbers(t, "triangles", 3 * kMaxMeshTriangles, diagnostics_, corners);
    t.finish();
    if (!good) continue;
    const auto is_corner = [&](double c) {
      return c >= 0 && c < static_cast<double>(places.size() / 3) && std::floor(c) == c;
    };
    if (places.size() % 3 != 0 || corners.empty() || corners.size() % 3 != 0 ||
        !std::all_of(corners.begin(), corners.end(), is_corner)) {
      t.mistake("triangles", "do not fit the corners", "three numbers of corners each, from 0");
      continue;
    }
    TriangleSoup soup;
    for (std::size_t i = 0; i < places.size(); i += 3)
      soup.corners.push_back({places[i], places[i + 1], places[i + 2]});
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      auto& triangle = soup.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) triangle[k] = static_cast<std::uint32_t>(corners[i + k]);
    }
    given_[key] = {weld(soup), 0};
  }
}

std::optional<MeshOfBody> MeshReader::read(text::TableReader& body) {
  body.require("file", "the name of a file that ends in .obj or .stl");
  const FileKey key{body.text("file", "", kLongestFileName), body.number("file_unit_m", 1, kFileUnit)};
  if (!body.has("file")) return std::nullopt;
  if (key.first.empty()) {
    body.mistake("file", "is no name of a file", "a name that ends in .obj or .stl");
    return std::nullopt;
  }
  const Given* given = find(body, key);
  if (given == nullptr) return std::nullopt;
  return add(body, key.first, *given);
}

const MeshReader::Given* MeshReader::find(text::TableReader& body, const FileKey& key) {
  if (const auto known = given_.find(key); known != given_.end()) return &known->second;
  if (!folder_) {
    body.mistake("file", "only a scene that is a file itself may name one", "a [[mesh_file]] table of that name");
    return nullptr;
  }
  auto soup = read_triangle_file(*folder_ / key.first);
  if (!soup.ok()) {
    const auto [what, accepted] = halves_of(soup.message());
    body.mistake("file", what, accepted);
    return nullptr;
  }
  for (Vec3d& corner : soup.value().corners) corner = corner * key.second;
  Given given{weld(soup.value()), 0};
  given.welded = static_cast<unsigned>(soup.value().corners.size() - given.soup.corners.size());
  kept_ += table_of(key.first, key.second, given.soup);
  return &(given_[key] = std::move(given));
}

std::optional<MeshOfBody> MeshReader::add(text::TableReader& body, const std::string& file, const Given& given) {
  for (const Vec3d& p : given.soup.corners) {
    if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kFarthest_m) continue;
    body.mistake("file", fmt::format("has a corner at [{:g}, {:g}, {:g}] m", p.x, p.y, p.z),
                 fmt::format("corners within {:g} m: is file_unit_m right?", kFarthest_m));
    return std::nullopt;
  }
  corners_ += given.soup.corners.size();
  triangles_ += given.soup.triangles.size();
  if (corners_ > kMaxMeshCorners || triangles_ > kMaxMeshTriangles) {
    body.mistake("file", fmt::format("makes {} triangles with {} corners in all meshes", triangles_, corners_),
                 fmt::format("at most {} and {} in a scene: a coarser mesh", kMaxMeshTriangles, kMaxMeshCorners));
    return std::nullopt;
  }
  auto built = build_mesh(given.soup, next_patch_);
  if (!built.ok()) {
    const auto [what, accepted] = halves_of(built.message());
    body.mistake("file", what, accepted);
    return std::nullopt;
  }
  MeshAccount& account = built.value().account;
  account.file = file;
  account.welded = given.welded;
  account.body = static_cast<BodyId>(scene_.bodies.size());
  next_patch_ += account.patches;
  scene_.mesh_accounts.push_back(account);
  scene_.meshes.push_back(built.value().mesh);
  scene_.shape_data.push_back(built.value().parts);
  return MeshOfBody{static_cast<std::uint32_t>(scene_.meshes.size() - 1), built.value().given_from_body};
}

}  // namespace tactus::sim
