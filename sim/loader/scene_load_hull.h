// Reads the hulls of a scene file: points in the text, or a file of corners beside it.
//
// A file's vertices are stored at the end of the scene's source as [[hull_file]] tables, so that a tape replays without
// the file: a text that has them needs no file.
// Thread: [setup]. Mistakes go to the reader's diagnostics. Bound: kMaxSceneHulls; two bodies of the same file and unit
// share a hull.
#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "rt/text/table_reader.h"
#include "sim/geometry/hull_builder.h"
#include "sim/model/scene.h"

namespace tactus::sim {

inline constexpr std::size_t kMaxSceneHulls = 1000;
inline constexpr std::size_t kMaxHullPoints = 100'000;

struct HullOfBody {
  std::uint32_t index{0};  // into the scene's hulls
  Posed given_from_body;
};

class HullReader {
 public:
  // `folder`: file names are relative to it; none: no file is opened.
  HullReader(Scene& scene, text::Diagnostics& diagnostics, std::optional<std::filesystem::path> folder)
      : scene_(scene), diagnostics_(diagnostics), folder_(std::move(folder)) {}

  // The [[hull_file]] tables of the text.
  void read_kept(std::span<const text::TomlNode> tables);

  // Builds the hull from a body's points_m, or its file and file_unit_m. If that fails: empty, and a mistake.
  std::optional<HullOfBody> read(text::TableReader& body);

  // The same hull with other mass properties, as an entry of its own. If the centre is not inside it: empty.
  std::optional<HullOfBody> with_mass(const HullOfBody& made, const Vec3d& centre, const SymMat3d& inertia_per_kg);

  const physics::Hull& hull(std::uint32_t index) const { return scene_.hulls[index]; }
  // Text to append to the source, so that it needs no file: the corners of the files that were opened.
  const std::string& kept() const { return kept_; }

 private:
  using FileKey = std::pair<std::string, double>;  // name, unit in metres

  std::optional<HullOfBody> read_file(text::TableReader& body);
  std::optional<BuiltHull> build(text::TableReader& body, const char* key, std::span<const Vec3d> points);
  void compare_with_mesh(text::TableReader& body, const std::filesystem::path& file, double unit_m,
                         const BuiltHull& built);
  HullOfBody add(const BuiltHull& built);

  Scene& scene_;
  text::Diagnostics& diagnostics_;
  std::optional<std::filesystem::path> folder_;
  std::map<FileKey, std::vector<Vec3d>> given_;  // in m, from the text
  std::map<FileKey, HullOfBody> of_file_;
  std::string kept_;
};

}  // namespace tactus::sim
